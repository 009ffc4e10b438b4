"""A rod pressed on a post or a plane, without friction: a boundary-value problem with a point contact, by shooting.

Planar, clamped at the origin along +Z, inextensible; x' = sin a, z' = cos a, EI a'' = f_z sin a - f_x cos a with f the
force beyond. The rod is a round tube of radius r up to 1.25 r before its tip, and ends with a ball: it is fixed to the
tip, with its middle r behind it along the tip's tangent. A contact force N along the normal n acts

- on a post (a cylinder across the plane) at an unknown arc length s where the tube touches: 4 unknowns, the curvature
  at the clamp, N, s and the angle there, for the post's surface (2), the angle at s, and the couple at the tip;
- on a plane likewise at s where the rod runs along the plane, or, where it meets the plane, at the ball, with the
  couple of that lever, or at the tube's end, which a curled rod may touch with before the ball.

Each is followed from the free rod, which the obstacle touches without force, to where the obstacle is pushed to. It
imports nothing of the package.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

PUSHES = 4
NECK = 1.25
PARTS = ("tube", "end", "ball")
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
        return np.linalg.norm(points - self.at, axis=-1) - self.radius - radius


@dataclass(frozen=True)
class Leaning:
    """A solution: tip [m], contact force [N], its arc length [m], and what touches, of `PARTS`."""

    tip: np.ndarray
    angle: float
    force: float
    along: float
    part: str
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


def _lever(rod, angle):
    """Return where the middle of the ball is from the tip [m]."""
    return -rod.radius * np.array([np.sin(angle), np.cos(angle)])


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
    return _told(rod, np.array([curvature, 0.0, rod.length]), np.zeros(2), 0.5 * rod.length, "tube")


def _told(rod, unknowns, push, at, part):
    _, tip, states = _shoot(rod, unknowns[0], at, push, fine=True)
    return Leaning(tip[:2], tip[2], unknowns[1], at, part, states[:2].T, states[2], unknowns)


def _solve(rod, obstacle, guess, part):
    """Return the contact near a guess of unknowns (curvature, force, s, angle there), or None."""
    L, EI, end = rod.length, rod.stiffness, rod.length - NECK * rod.radius
    size = np.array([1 / L, EI / L**2, L, 1.0])[: 2 if part != "tube" else 4 if obstacle.radius else 3]

    def off(scaled):
        k, N, *more = scaled * size
        if part == "ball":
            _, tip, _ = _shoot(rod, k, L, N * obstacle.normal)
            lever = _lever(rod, tip[2])
            couple = rod.couple + N * (lever[1] * obstacle.normal[0] - lever[0] * obstacle.normal[1])
            gap = obstacle.gaps(tip[:2] + lever, rod.radius)
            return [gap / L, tip[3] * L - couple * L / EI]
        if part == "end":
            here, tip, _ = _shoot(rod, k, end, N * obstacle.normal)
            return [obstacle.gaps(here[:2], rod.radius) / L, tip[3] * L - rod.couple * L / EI]
        at = min(max(more[0], 0.02 * L), L)
        angle = more[1] if obstacle.radius else obstacle.tilt
        normal = np.array([-np.cos(angle), np.sin(angle)])
        here, tip, _ = _shoot(rod, k, at, N * normal)
        rest = [here[2] - angle, tip[3] * L - rod.couple * L / EI]
        if obstacle.radius is None:
            return [obstacle.gaps(here[:2], rod.radius) / L, *rest]
        return [*((here[:2] - obstacle.at - (obstacle.radius + rod.radius) * normal) / L), *rest]

    found = root(off, guess[: len(size)] / size, tol=1e-11)
    if np.abs(found.fun).max() > 1e-9:
        return None
    unknowns = found.x * size
    at = unknowns[2] if part == "tube" else end if part == "end" else L
    if part == "tube" and not 0.02 * L < at <= end:
        return None
    angle = unknowns[3] if len(unknowns) > 3 else obstacle.tilt
    push = unknowns[1] * np.array([-np.cos(angle), np.sin(angle)])
    return _told(rod, unknowns, push, at, part)


def followed(rod, obstacle, start, way):
    """Return the rod when an obstacle that touches the free rod has been pushed by `way` [m], shape (2,), or None.

    Args:
        start: (unknowns of the free rod with the place that is touched, which part that is of).
    """
    guess, part = start
    found = None
    for share in np.arange(1, PUSHES + 1) / PUSHES:
        here = replace(obstacle, at=obstacle.at + share * way)
        found = _solve(rod, here, guess, part)
        if obstacle.radius is None and (found is None or not clear_elsewhere(rod, here, found)):
            for other in PARTS:  # what touches has changed
                begun = np.array([guess[0], guess[1], rod.length - 2 * rod.radius])
                found = _solve(rod, here, begun, other)
                if found is not None and found.force > 0 and clear_elsewhere(rod, here, found):
                    part = other
                    break
                found = None
        if found is None:
            return None
        guess = found.unknowns
    return found


def clear_elsewhere(rod, obstacle, found):
    """Whether the rod overlaps the obstacle nowhere."""
    points, angles = _tube(rod, found)
    gaps = obstacle.gaps(points, rod.radius)
    ball = obstacle.gaps(found.tip + _lever(rod, found.angle), rod.radius)
    allowed = -1e-7 * rod.length
    if obstacle.radius is None:  # only where it runs along the plane does the tube come nearest before its end
        along = np.stack([np.sin(angles), np.cos(angles)], axis=1) @ obstacle.normal
        turning = np.flatnonzero((along[:-1] < 0) & (along[1:] >= 0))
        inner = not len(turning) or gaps[turning].min() > -1e-5 * rod.length
        return inner and (ball > allowed or found.part == "ball") and (gaps[-1] > allowed or found.part == "end")
    return gaps.min() > allowed and ball > allowed


def _tube(rod, found):
    """Return points and angles up to where the tube ends."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(found.points, axis=0), axis=1))])
    end, inside = rod.length - NECK * rod.radius, along < rod.length - NECK * rod.radius
    last = [np.interp(end, along, of) for of in (*found.points.T, found.angles)]
    return np.vstack([found.points[inside], last[:2]]), np.append(found.angles[inside], last[2])


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
    if found.part == "ball":
        lever = _lever(rod, found.angle)
        K[-1, -1] += found.force * (lever @ normal)
        slope[-1] += np.array([lever[1], -lever[0]]) @ normal
    elif found.part == "tube":
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
    sides to lean on; that would not stay; that press with less than 0.1 EI/L^2; that touch a post with the ball or with
    the first 20 % of their length; that touch a plane with two parts at once; or that turn by more than 2 rad.
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
        start = np.array([curvature, 0.0, along[place], angles[place]]), "tube"
    else:
        plane = Obstacle(np.zeros(2), slope)
        normal, end = plane.normal, int(np.searchsorted(along, rod.length - NECK * rod.radius))
        away = plane.gaps(points[: end + 1], rod.radius)
        place = int(away.argmin())
        ball = loose.tip + _lever(rod, loose.angle)
        part = "ball" if plane.gaps(ball, rod.radius) <= away[place] else "end" if place == end else "tube"
        at = (ball if part == "ball" else points[place]) - rod.radius * normal
        obstacle = replace(plane, at=at)
        start = np.array([curvature, 0.0, along[place]]), part
    found = followed(rod, obstacle, start, depth * normal)
    if found is None:
        return None
    moved = replace(obstacle, at=obstacle.at + depth * normal)
    straight = np.stack([0 * along, along], axis=1)[along <= rod.length - NECK * rod.radius]
    clear = moved.gaps(straight, rod.radius).min() > 0.002 * rod.length
    enough = found.force > 0.1 * rod.stiffness / rod.length**2 and abs(found.angles).max() < 2.0
    inner = kind == "plane" or found.along > 0.2 * rod.length
    if clear and enough and inner and clear_elsewhere(rod, moved, found) and stays(rod, moved, found):
        return rod, moved, found
    return None
