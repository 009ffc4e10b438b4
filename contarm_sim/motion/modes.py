"""The modes that an arm swings in: of the simulated chain, of the beam that it stands for, and measured in motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.motion import stepped_beam
from contarm_sim.motion.course import remaining
from contarm_sim.motion.release import TIMESTEP, SwingSettings, release
from contarm_sim.statics.equilibrium import driven_plant, equilibrium
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.stiffness import TangentStiffness

SMALL = 1e-3
"""Amplitude at the tip of a swing that counts as small [lengths]."""


def natural_frequencies(arm: Arm, load: Load, count: int) -> Array:
    """Return the lowest natural frequencies [Hz], shape (count,), undamped, about the rest left when a load is let go.

    Raises:
        EquilibriumError: there is no such rest.
    """
    arm.refuse_objects("natural frequencies are found")
    left = remaining(load)
    plant = driven_plant(arm, left)
    plant.data.qpos[:] = equilibrium(arm, left).qpos
    return _modes(plant, left, count)[0]


def _modes(plant: Plant, load: Load, count: int) -> tuple[Array, Array]:
    """Return frequencies [Hz], shape (count,), and joint angles, shape (dofs, count), of modes about a plant's pose."""
    from scipy.linalg import eigh

    model, data = plant.model, plant.data
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    K = TangentStiffness(plant, AppliedLoad(plant, load))()
    squares, shapes = eigh(0.5 * (K + K.T), M, subset_by_index=[0, min(count, model.nv) - 1])
    return np.sqrt(np.maximum(squares, 0)) / (2 * np.pi), shapes


def bare(arm: Arm) -> Arm:
    """Return the arm that `beam_frequencies` speaks of: without gravity and torsion."""
    sections = tuple(replace(section, torsional_stiffness=None) for section in arm.sections)
    return replace(arm, gravity=(0.0, 0.0, 0.0), sections=sections)


def beam_frequencies(arm: Arm, count: int = 3) -> Array:
    """Return the lowest natural frequencies [Hz] in a plane of a clamped beam, shape (count,): no muscles, no gravity.

    Rayleigh's beam with a point mass at its tip. With arc length in lengths, b^2 = omega^2 m L^3/EI, mu = payload/m and
    s = (section radius / 2 L)^2,

        w'''' + s b^2 w'' = b^2 w,  w = cosh(ax) - cos(cx) - C (sinh(ax)/a - sin(cx)/c),
        a^2, c^2 = b (sqrt(1 + (s b/2)^2) -+ s b/2),
        w''(1) = 0,  w'''(1) + s b^2 w'(1) + mu b^2 w(1) = 0.

    Of several sections, see `stepped_beam`.
    """
    from scipy.optimize import brentq

    if len(arm.sections) > 1:
        return stepped_beam.frequencies(arm, count)

    s = (0.5 * (arm.section_radius or arm.disk_radius) / arm.length) ** 2
    mu = arm.payload / arm.mass

    def off(root_b: Array | float) -> Array:
        b = np.square(root_b)
        a, c = (np.sqrt(b * (np.hypot(1, 0.5 * s * b) + sign * 0.5 * s * b)) for sign in (-1, 1))
        # Over cosh(a), which would overflow.
        ch, sh, co, si = 1.0, np.tanh(a), np.cos(c) / np.cosh(a), np.sin(c) / np.cosh(a)
        one = np.array([ch - co, a * sh + c * si, a**2 * ch + c**2 * co, a**3 * sh - c**3 * si])
        other = np.array([sh / a - si / c, ch - co, a * sh + c * si, a**2 * ch + c**2 * co])
        shear = [w[3] + s * b**2 * w[1] + mu * b**2 * w[0] for w in (one, other)]
        return np.asarray(one[2] * shear[1] - other[2] * shear[0])

    reach = np.pi * (count + 1)
    while True:
        grid = np.arange(0.05, reach, 0.05)
        signs = np.sign(off(grid))
        found = np.flatnonzero(signs[1:] != signs[:-1])
        if len(found) >= count:
            break
        reach *= 2
    b = np.array([brentq(off, grid[i], grid[i + 1], xtol=1e-13) for i in found[:count]]) ** 2
    return b * np.sqrt(arm.bending_stiffness / (arm.mass * arm.length**3)) / (2 * np.pi)


def small_swing(arm: Arm, timestep: float = TIMESTEP) -> tuple[float, float] | None:
    """Return the damped frequency [Hz] and the decay rate [1/s] of the bare arm's first mode, measured in motion.

    Samples at even times follow x_n+1 = 2 e^-d cos(w) x_n - e^-2d x_n-1. Damping of Kelvin and Voigt gives the decay
    rate tau omega^2/2 and the frequency sqrt(1 - (tau omega/2)^2) omega/2 pi. None where the mode creeps back without
    swinging.
    """
    arm = bare(arm)
    plant = driven_plant(arm, Load())
    (frequency,), shapes = _modes(plant, Load(), 1)
    damping_time = _damping_time(arm, frequency)
    if np.pi * frequency * damping_time >= 0.9:
        return None
    plant.data.qpos[:] = 1e-3 * shapes[:, 0] / np.abs(shapes).max()
    mujoco.mj_kinematics(plant.model, plant.data)
    side = plant.tip[:2] / np.hypot(*plant.tip[:2])
    held = plant.data.qpos * SMALL * arm.length / np.hypot(*plant.tip[:2])
    period = timestep * max(round(1 / (12 * frequency * timestep)), 1)
    duration = min(3 / frequency, max(8 * period, 3 / (2 * np.pi**2 * frequency**2 * damping_time + 1e-9)))
    x = release(arm, held, Load(), SwingSettings(timestep, duration, period)).tip[:, :2] @ side
    (twice, square), *_ = np.linalg.lstsq(np.stack([x[1:-1], -x[:-2]], axis=-1), x[2:], rcond=None)
    if square <= 0 or abs(twice) >= 2 * np.sqrt(square):
        return None
    angle = np.arccos(0.5 * twice / np.sqrt(square))
    return float(angle / (2 * np.pi * period)), float(-0.5 * np.log(square) / period)


def _damping_time(arm: Arm, frequency: float) -> float:
    """Return the Kelvin-Voigt time of the first mode [s]: that of each section by its share of the elastic energy."""
    times = [section.damping_time for section in arm.sections]
    if all(time == times[0] for time in times):
        return times[0]
    return float(stepped_beam.energy_shares(arm, frequency) @ times)


@dataclass(frozen=True)
class SmallSwing:
    """A swing of the first mode: its damped frequency [Hz] and decay rate [1/s]."""

    hz: float
    decay_per_s: float


@dataclass(frozen=True)
class SwingModes:
    """The lowest natural frequencies of a released arm, and of the beam that it stands for.

    Attributes:
        beam_hz, chain_hz: of beam and chain in one plane, without gravity and muscles [Hz], shape (3,).
        arm_hz: of the arm about where it comes to rest, in all planes [Hz], shape (6,).
        small_swing: of the first mode, measured in motion; None where it creeps back without swinging.
        small_swing_of_beam: what the beam does then; None beside it.
    """

    beam_hz: Array
    chain_hz: Array
    arm_hz: Array
    small_swing: SmallSwing | None
    small_swing_of_beam: SmallSwing | None


def swing_modes(arm: Arm, load: Load, timestep: float = TIMESTEP) -> SwingModes:
    """Return frequencies [Hz] and decay rates [1/s] of a released arm and of the beam."""
    beam = beam_frequencies(arm)
    decay = _damping_time(arm, beam[0]) * (2 * np.pi * beam[0]) ** 2 / 2
    small = small_swing(arm, timestep)
    damped = np.sqrt(max(beam[0] ** 2 - (decay / (2 * np.pi)) ** 2, 0.0))
    return SwingModes(
        beam_hz=beam,
        chain_hz=natural_frequencies(bare(arm), Load(), 6)[::2],
        arm_hz=natural_frequencies(arm, load, 6),
        small_swing=None if small is None else SmallSwing(*small),
        small_swing_of_beam=None if small is None else SmallSwing(float(damped), float(decay)),
    )
