"""Places along the backbone: frames between stations, for one pose or for many at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.names import section_stations
from contarm_sim.model.arm import Arm

AT_STATION = 1e-9
"""Distance from a station that counts as none [link pitches]."""


def station_coordinate(arm: Arm, xi: Array) -> Array:
    """Return places at normalised arc lengths xi in numbers of stations: whole at stations, even in between."""
    if len(arm.sections) == 1:
        return np.asarray(xi * arm.links)
    stations, lengths = section_stations(arm), [section.length for section in arm.sections]
    return np.interp(xi * arm.length, [0.0, *np.cumsum(lengths)], stations)


def pitch_at(arm: Arm, coordinate: Array) -> Array:
    """Return the distance [m] of the stations before and after places, given in numbers of stations."""
    number = np.searchsorted(section_stations(arm)[1:-1], coordinate, side="right")
    return np.array([section.link_pitch for section in arm.sections])[number]


class Places:
    """Places at normalised arc lengths xi, shape (K,), of an arm.

    Attributes:
        xi: shape (K,), 0 base to 1 tip.
        stations: the station before and after each place, shape (K, 2); the same one twice at a station.
        part: of the way from one to the other, shape (K,).

    Raises:
        InputError: no places, or one outside [0, 1].
    """

    def __init__(self, arm: Arm, xi: Sequence[float] | Array) -> None:
        self.xi = np.array(xi, dtype=float)
        if self.xi.ndim != 1 or not len(self.xi) or not np.all((self.xi >= 0) & (self.xi <= 1)):
            raise InputError("xi", list(xi), "one or more numbers from 0 (base) to 1 (tip)")
        at = station_coordinate(arm, self.xi)
        at = np.where(np.abs(at - np.round(at)) < AT_STATION, np.round(at), at)
        self.stations = np.stack([np.floor(at), np.ceil(at)], axis=-1).astype(int)
        self.part = at - self.stations[:, 0]
        self._pitch = pitch_at(arm, at)

    def of(self, frames: Array) -> Array:
        """Return frames at the places, shape (K, 4, 4), of frames at all stations, shape (N + 1, 4, 4)."""
        return self.between(frames[self.stations, :3, 3], frames[self.stations, :3, :3])

    def between(self, positions: Array, rotations: Array) -> Array:
        """Return frames at the places, shape (..., K, 4, 4).

        Cubic Hermite between stations, whose tangents are the frames' z axes; orientations turn evenly.

        Args:
            positions: of the two stations about each place [m], shape (..., K, 2, 3).
            rotations: their orientations, shape (..., K, 2, 3, 3).
        """
        out = np.zeros((*positions.shape[:-2], 4, 4))
        out[..., :3, 3], out[..., :3, :3], out[..., 3, 3] = positions[..., 0, :], rotations[..., 0, :, :], 1.0
        for k in np.flatnonzero(self.part):
            x, p, R = self.part[k], positions[..., k, :, :], rotations[..., k, :, :, :]
            slopes = self._pitch[k] * R[..., 2]
            blend = [(1 + 2 * x) * (1 - x) ** 2, x**2 * (3 - 2 * x)]
            lean = [x * (1 - x) ** 2, x**2 * (x - 1)]
            out[..., k, :3, 3] = np.einsum("i,...ia->...a", blend, p) + np.einsum("i,...ia->...a", lean, slopes)
            out[..., k, :3, :3] = _turned(R[..., 0, :, :], R[..., 1, :, :], x)
        return out


def _turned(start: Array, end: Array, part: float) -> Array:
    """Return the orientation a part of the way along the rotation from `start` to `end`, shape (..., 3, 3)."""
    from scipy.spatial.transform import Rotation

    between = (start.swapaxes(-1, -2) @ end).reshape(-1, 3, 3)
    lost = np.asarray(~np.isfinite(between).all(axis=(1, 2)))  # of an arm without a pose: SciPy stops at NaN
    turn = Rotation.from_matrix(np.where(lost[:, None, None], np.eye(3), between))
    turned = Rotation.from_rotvec(part * turn.as_rotvec()).as_matrix()
    return start @ np.where(lost[:, None, None], np.nan, turned).reshape(start.shape)


def quaternions(frames: Array) -> Array:
    """Return the orientations of frames (..., 4, 4) as unit quaternions w x y z, w >= 0, shape (..., 4)."""
    from scipy.spatial.transform import Rotation

    xyzw = Rotation.from_matrix(frames[..., :3, :3].reshape(-1, 3, 3)).as_quat()
    wxyz = xyzw[:, [3, 0, 1, 2]] * np.where(xyzw[:, 3:] < 0, -1.0, 1.0)
    return wxyz.reshape(*frames.shape[:-2], 4)
