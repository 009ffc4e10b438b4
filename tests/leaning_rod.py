"""A rod pressed on a post or a plane, without friction: a boundary-value problem with a point contact, by shooting.

Planar, clamped at the origin along +Z, inextensible; x' = sin a, z' = cos a, EI a'' = f_z sin a - f_x cos a with f the
force beyond. The rod is a round tube of radius r, cut off flat at its tip. A contact force N along the normal n acts

- on a post (a cylinder across the plane) at an unknown arc length s where the tube touches: 4 unknowns, the curvature
  at the clamp, N, s and the angle there, for the post's surface (2), the angle at s, and the couple at the tip;
- on a plane likewise at s where the rod runs along the plane, or, where it meets the plane, at the rim of its tip, with
  the couple of that lever.

Each is followed from the free rod, which the obstacle touches without force, to where the obstacle is pushed to. It
imports nothing of the package.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

PUSHES = 4
FINE = 400


@dataclass(frozen=True)
class Rod:
    """What is given: SI units; force, couple (about +Y) and gravity in the plane of x and z."""

    length: float
    stiffness: float
    mass: float
    radius: float
    force: tuple[float, float]
    couple: float
    gravity: tuple[float, float]


@dataclass(frozen=True)
class Obstacle:
    """A post of a radius [m] about `at`, or (None) a plane through `at` with the normal (-cos tilt, sin tilt)."""

    at: np.ndarray
    tilt: float = 0.0
    radius: float | None = None

    @property
    def normal(self):
        return np.array([-np.cos(self.tilt), np.sin(self.tilt)])

    def gaps(self, points, radius):
        """Return the gap [m] between a tube about points, shape (P, 2), and the obstacle, shape (P,)."""
        if self.radius is None:
            return (points - self.at) @ self.normal - radius
        return np.linalg.norm(points - self.at, axis=1) - self.radius - radius


@dataclass(frozen=True)
class Leaning:
    """A solution: tip [m], contact force [N], its arc length [m], whether the rim of the tip touches."""

    tip: np.ndarray
    angle: float
    force: float
    along: float
    at_rim: bool
    points: np.ndarray
    angles: np.ndarray
    unknowns: np.ndarray


def _shoot(rod, curvature, at, push, fine=False):
    """Integrate from the clamp; a force `push` acts at arc length `at`. Return states there, at the tip, and a grid."""
    line = rod.mass / rod.length * np.array(rod.gravity)

    def slope(s, y, more):
        f = np.array(rod.force) + line * (rod.length - s) + more
        a = y[2]
        return [np.sin(a), np.cos(a), y[3], (f[1] * np.sin(a) - f[0] * np.cos(a)) / rod.stiffness]

    def run(low, high, y, more):
        grid = np.linspace(low, high, FINE + 1) if fine else None
        found = solve_ivp(slope, (low, high), y, "DOP853", grid, rtol=1e-10, atol=1e-12, args=(more,))
        return found.y

    below = run(0.0, at, [0.0, 0.0, 0.0, curvature], push)
    above = run(at, rod.length, below[:, -1], 0.0 * push) if at < rod.length else below[:, -1:]
    return below[:, -1], above[:, -1], np.concatenate([below, above], axis=1)


def _rim(rod, obstacle, angle):
    """Return where the rim that is nearer to a plane is from the middle of the tip [m]."""
    across = np.array([np.cos(angle), -np.sin(angle)])
    return -rod.radius * np.sign(across @ obstacle.normal) * across


def free(rod):
    """Return the rod without obstacle."""

    def end(curvature):
        return _shoot(rod, curvature, 0.5 * rod.length, np.zeros(2))[1][3] * rod.length - moment

    moment = rod.couple / rod.stiffness * rod.length
    starts = np.linspace(-8, 8, 33) / rod.length
    values = [end(k) for k in starts]
    best = min(range(len(starts) - 1), key=lambda k: abs(starts[k]) if values[k] * values[k + 1] <= 0 else np.inf)
    if values[best] * values[best + 1] > 0:
        return None
    curvature = brentq(end, starts[best], starts[best + 1], xtol=1e-12)
    return _told(rod, np.array([curvature, 0.0, rod.length]), np.zeros(2), 0.5 * rod.length, False)


def _told(rod, unknowns, push, at, at_rim):
    _, tip, states = _shoot(rod, unknowns[0], at, push, fine=True)
    along = rod.length if at_rim else at
    return Leaning(tip[:2], tip[2], unknowns[1], along, at_rim, states[:2].T, states[2], unknowns)


def _solve(rod, obstacle, guess, at_rim):
    """Return the contact near a guess of unknowns (curvature, force, s, angle there), or None."""
    L, EI = rod.length, rod.stiffness
    size = np.array([1 / L, EI / L**2, L, 1.0])[: 2 if at_rim else 4 if obstacle.radius else 3]

    def off(scaled):
        k, N, *more = scaled * size
        if at_rim:
            _, tip, _ = _shoot(rod, k, L, N * obstacle.normal)
            lever = _rim(rod, obstacle, tip[2])
            couple = rod.couple + N * (lever[1] * obstacle.normal[0] - lever[0] * obstacle.normal[1])
            return [(tip[:2] + lever - obstacle.at) @ obstacle.normal / L, tip[3] * L - couple * L / EI]
        at = min(max(more[0], 0.02 * L), L)
        angle = more[1] if obstacle.radius else obstacle.tilt
        normal = np.array([-np.cos(angle), np.sin(angle)])
        here, tip, _ = _shoot(rod, k, at, N * normal)
        rest = [here[2] - angle, tip[3] * L - rod.couple * L / EI]
        if obstacle.radius is None:
            return [(here[:2] - obstacle.at) @ normal / L - rod.radius / L, *rest]
        return [*((here[:2] - obstacle.at - (obstacle.radius + rod.radius) * normal) / L), *rest]

    found = root(off, guess[: len(size)] / size, tol=1e-11)
    if np.abs(found.fun).max() > 1e-9:
        return None
    unknowns = found.x * size
    at = L if at_rim else unknowns[2]
    if not 0.02 * L < at <= L:
        return None
    angle = unknowns[3] if len(unknowns) > 3 else obstacle.tilt
    push = unknowns[1] * np.array([-np.cos(angle), np.sin(angle)])
    return _told(rod, unknowns, push, at, at_rim)


def followed(rod, obstacle, start, way):
    """Return the rod when an obstacle that touches the free rod has been pushed by `way` [m], shape (2,), or None.

    Args:
        start: (unknowns of the free rod with the place that is touched, whether that is the tip's rim).
    """
    guess, at_rim = start
    found = None
    for share in np.arange(1, PUSHES + 1) / PUSHES:
        here = replace(obstacle, at=obstacle.at + share * way)
        found = _solve(rod, here, guess, at_rim)
        if obstacle.radius is None:
            lifted = found is not None and at_rim and np.sin(obstacle.tilt - found.angle) > 0
            if at_rim and (found is None or lifted):  # the tip has lifted off: the rod runs along the plane before it
                guess = np.array([guess[0], guess[1], 0.97 * rod.length])
                found, at_rim = _solve(rod, here, guess, False), False
            elif not at_rim and found is None:
                found, at_rim = _solve(rod, here, guess, True), True
        if found is None:
            return None
        guess = found.unknowns if not at_rim else np.append(found.unknowns, rod.length)
    return found


def clear_elsewhere(rod, obstacle, found):
    """Whether the rod overlaps the obstacle nowhere."""
    angles = found.angles
    meets = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    gaps = obstacle.gaps(found.points, rod.radius)
    if obstacle.radius is None:  # only where it runs along the plane does the tube, not its flat end, come nearest
        rims = (found.tip + _rim(rod, obstacle, found.angle) - obstacle.at) @ obstacle.normal
        along = meets @ obstacle.normal
        turning = np.flatnonzero((along[:-1] < 0) & (along[1:] >= 0))
        return rims > -1e-7 * rod.length and (not len(turning) or gaps[turning].min() > -1e-5 * rod.length)
    return gaps.min() > -1e-7 * rod.length


def stays(rod, obstacle, found):
    """Whether the rod is a minimum of its energy among shapes that stay in touch: of 200 straight pieces, in plane."""
    count = 200
    h = rod.length / count
    middles = h * (np.arange(count) + 0.5)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(found.points, axis=0), axis=1))])
    a = np.interp(middles, along, found.angles)
    s = found.along
    shares = np.clip((s - h * np.arange(count)) / h, 0, 1)
    normal = obstacle.normal if obstacle.radius is None else None
    angle_there = np.interp(s, along, found.angles)
    if normal is None:
        normal = np.array([-np.cos(angle_there), np.sin(angle_there)])
    beyond = np.array(rod.force) + rod.mass / rod.length * np.array(rod.gravity) * (rod.length - middles)[:, None]
    beyond = beyond + found.force * normal * shares[:, None]
    t, across = np.stack([np.sin(a), np.cos(a)], axis=1), np.stack([np.cos(a), -np.sin(a)], axis=1)
    K = np.diag(h * (beyond * t).sum(axis=1))
    bend = np.diff(np.eye(count), axis=0, prepend=np.zeros((1, count)))
    weights = np.full(count, rod.stiffness / h)
    weights[0] *= 2
    K += bend.T @ (weights[:, None] * bend)
    slope = h * shares * (across @ normal)
    if found.at_rim:
        lever = _rim(rod, obstacle, found.angle)
        K[-1, -1] += found.force * (lever @ normal)
        slope[-1] += np.array([lever[1], -lever[0]]) @ normal
    else:
        # The contact slides: gap'' = across the rod (moved by turning) / (curvature of rod and post there).
        curved = np.gradient(found.angles, along + 1e-15 * np.arange(len(along)))
        bent = np.interp(s, along, curved)
        radius = np.inf if obstacle.radius is None else obstacle.radius + rod.radius
        slides = h * shares * (across @ np.array([np.sin(angle_there), np.cos(angle_there)]))
        own = np.zeros(count)
        own[min(int(s / h), count - 1)] = 1.0
        n_turn = own * (np.array([np.cos(angle_there), -np.sin(angle_there)]) @ normal) + slides / radius
        tighter = (np.array([np.cos(angle_there), -np.sin(angle_there)]) @ normal) * bent + 1 / radius
        K -= found.force * (np.outer(slides, slides) / radius - np.outer(n_turn, n_turn) / tighter)
    Z = np.linalg.svd(slope[None])[2][1:].T
    return np.linalg.eigvalsh(Z.T @ K @ Z)[0] > 0


def random_cases(kind, count, seed, length, stiffness, mass, radius):
    """Return (rod, obstacle, solution) of random loads and places of a `post` or a `plane`, and how many were drawn.

    Left out are rods that have no free shape or none in touch that the push leads to; whose straight shape, or whose
    shape found, overlaps the obstacle; whose post stands between the straight and the free shape, which leaves two
    sides to lean on; that would not stay; that press with less than 0.1 EI/L^2; that touch a post with the last 5 % of
    their length, where the tip's edge counts, or with the first 20 %; or that turn by more than 2 rad.
    """
    rng = np.random.default_rng(seed)
    found, drawn = [], 0
    unit = stiffness / length**2
    while len(found) < count:
        drawn += 1
        force = (unit * rng.uniform(0.3, 3.0), unit * rng.uniform(-1.0, 2.0))
        tilt = rng.uniform(0, 2 * np.pi)
        pull = 9.81 * rng.uniform(0, 1)
        rod = Rod(length, stiffness, mass, radius, force, unit * length * rng.uniform(-0.8, 0.8),
                  (pull * np.cos(tilt), pull * np.sin(tilt)))  # fmt: skip
        post, where = length * rng.uniform(0.02, 0.1), rng.uniform(0.3, 0.95)
        slope, depth = rng.uniform(-0.4, 0.4), length * rng.uniform(0.02, 0.2)
        loose = free(rod)
        if loose is None:
            continue
        case = _placed(rod, loose, kind, post, where * length, slope, depth)
        if case is not None:
            found.append(case)
    return found, drawn


def _placed(rod, loose, kind, post, where, slope, depth):
    along = np.linspace(0, rod.length, len(loose.points) - 1)
    points = np.delete(loose.points, FINE + 1, axis=0)
    angles = np.delete(loose.angles, FINE + 1)
    curvature = loose.unknowns[0]
    if kind == "post":
        place = int(np.argmin(abs(along - where)))
        normal = np.array([-np.cos(angles[place]), np.sin(angles[place])])
        if (np.array([0.0, along[place]]) - points[place]) @ normal <= 0:
            return None
        obstacle = Obstacle(points[place] - (post + rod.radius) * normal, radius=post)
        start = np.array([curvature, 0.0, along[place], angles[place]]), False
    else:
        plane = Obstacle(np.zeros(2), slope)
        rim = loose.tip + _rim(rod, plane, loose.angle)
        inside = np.flatnonzero((np.stack([np.sin(angles), np.cos(angles)], axis=1) @ plane.normal)[:-1] < 0)
        normal, away = plane.normal, points @ plane.normal - rod.radius
        place = int(away[1:-1].argmin()) + 1
        at_rim = rim @ normal <= away[place] or place >= len(points) - 2 or not len(inside)
        at = rim if at_rim else points[place] - rod.radius * normal
        obstacle = replace(plane, at=at)
        start = np.array([curvature, 0.0, rod.length if at_rim else along[place]]), at_rim
    found = followed(rod, obstacle, start, depth * normal)
    if found is None:
        return None
    moved = replace(obstacle, at=obstacle.at + depth * normal)
    straight = np.stack([0 * along, along], axis=1)
    clear = moved.gaps(straight, rod.radius).min() > 0.002 * rod.length
    if kind == "plane":
        clear = clear and ((straight[-1] + _rim(rod, moved, 0.0) - moved.at) @ moved.normal) > 0
    enough = found.force > 0.1 * rod.stiffness / rod.length**2 and abs(found.angles).max() < 2.0
    inner = kind == "plane" or 0.2 * rod.length < found.along < 0.95 * rod.length
    if clear and enough and inner and clear_elsewhere(rod, moved, found) and stays(rod, moved, found):
        return rod, moved, found
    return None
