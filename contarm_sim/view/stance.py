"""How an arm stands or hangs, and what it carries, in a few words for headings and panels."""

from __future__ import annotations

import numpy as np

from contarm_sim.model.arm import Arm


def stance(arm: Arm) -> str:
    """Return "free", "hanging", "standing", or how far from hanging gravity pulls, and the payload."""
    pull = np.array(arm.gravity)
    if not pull.any():
        return "free"
    along = float(pull[2] / np.linalg.norm(pull))
    tilt = float(np.degrees(np.arccos(np.clip(along, -1, 1))))
    said = "hanging" if tilt < 0.5 else "standing" if tilt > 179.5 else f"{tilt:.0f}° from hanging"
    return f"{said}, {1e3 * arm.payload:.4g} g" if arm.payload else said
