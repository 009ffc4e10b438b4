"""Sliders, and what they say."""

from __future__ import annotations

from typing import Any

import numpy as np


def slider(
    gui: Any, label: str, limits: tuple[float, float], step: float, initial: float, hint: str | None = None
) -> Any:
    """Add a slider."""
    return gui.add_slider(label, min=limits[0], max=limits[1], step=step, initial_value=initial, hint=hint)


def value(control: Any) -> float:
    """Return what a slider says, within its limits: boxes pass on whatever is typed, key by key."""
    said = control.value
    number = float(said) if isinstance(said, int | float) and np.isfinite(said) else control.min
    return float(np.clip(number, control.min, control.max))
