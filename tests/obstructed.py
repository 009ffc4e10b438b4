"""Random scenes of a two-section arm (post, wall, window), and clearances by brute force that share no code with it.

Arcs are sampled densely from their own formula (Rodrigues), distances are those to the nearest point of each shape.
"""

from dataclasses import replace

import numpy as np

from contarm_sim import presets
from contarm_sim.kinematics import inverse
from contarm_sim.mechanics import shape
from contarm_sim.model.objects import Object

KINDS = ("post", "wall", "window")


def scene(number):
    """Return an arm of two sections whose world has objects, and a target that it reaches without them."""
    rng = np.random.default_rng([number, 20])
    arm = presets.two()
    limits = shape.backbone(arm).limits
    while True:
        bends = _random_pose(rng, limits)
        target = arcs(bends[None], arm, 1)[0, -1]
        other = np.concatenate(inverse.solve_all(target, shape.backbone(arm), points=20))
        through = arcs(other[[rng.integers(len(other))]], arm, 60)[0]
        objects = _KINDS[KINDS[number % 3]](rng, through)
        obstructed = replace(arm, world=replace(arm.world, objects=objects))
        ends = np.array([[[0, 0, 0.0]], [target]])
        if distances(ends, objects).min() > max(arm.contact_radii) + 0.005:
            return obstructed, target


def _random_pose(rng, limits):
    angle, plane = np.sqrt(rng.uniform(0, 0.8, 2)) * limits, rng.uniform(-np.pi, np.pi, 2)
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)


def _direction(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def _post(rng, through):
    """Return one to three posts beside or across the way of a pose."""
    posts = []
    for k in range(rng.integers(1, 4)):
        at = through[rng.integers(12, 110)] + rng.normal(scale=0.03, size=3)
        shaped = rng.choice(["cylinder", "capsule", "box"])
        thick, long = rng.uniform(0.006, 0.025), rng.uniform(0.05, 0.5)
        size = {"size": (2 * thick, 2 * thick, long)} if shaped == "box" else {"radius": thick, "length": long}
        axis = tuple(_direction(rng))
        posts.append(Object(name=f"post_{k}", shape=str(shaped), position=tuple(at), axis=axis, **size))
    return tuple(posts)


def _wall(rng, through):
    """Return a wall that ends somewhere, or a plane, beside the way of a pose."""
    at = through[rng.integers(30, 121)] + 0.06 * _direction(rng)
    if rng.random() < 0.3:
        axis = through[60] - at
        return (Object(name="wall", shape="plane", position=tuple(at), axis=tuple(axis)),)
    size = (rng.uniform(0.08, 0.4), rng.uniform(0.08, 0.4), rng.uniform(0.004, 0.03))
    return (Object(name="wall", shape="box", position=tuple(at), size=size, axis=tuple(_direction(rng))),)


def _window(rng, through):
    """Return four boxes that leave a hole somewhere on the way of a pose, more or less across it."""
    k = rng.integers(20, 100)
    axis = through[k + 1] - through[k - 1] + 0.3 * np.linalg.norm(through[k + 1] - through[k - 1]) * _direction(rng)
    z = axis / np.linalg.norm(axis)
    x = np.cross(z, _direction(rng))
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    half, frame, thick = 0.5 * rng.uniform(0.06, 0.12), rng.uniform(0.05, 0.2), rng.uniform(0.004, 0.02)
    middle = through[k] + rng.uniform(-0.01, 0.01, 2) @ np.stack([x, y])
    out = []
    for name, side, size in (
        ("left", -x, (frame, 2 * half, thick)), ("right", x, (frame, 2 * half, thick)),
        ("low", -y, (2 * (half + frame), frame, thick)), ("high", y, (2 * (half + frame), frame, thick)),
    ):  # fmt: skip
        at = middle + (half + 0.5 * frame) * side
        out.append(Object(name=name, shape="box", position=tuple(at), size=size, orientation=_quaternion(x, y, z)))
    return tuple(out)


_KINDS = {"post": _post, "wall": _wall, "window": _window}


def _quaternion(x, y, z):
    from scipy.spatial.transform import Rotation

    a, b, c, w = Rotation.from_matrix(np.stack([x, y, z], axis=-1)).as_quat()
    return (w, a, b, c)


def arcs(bends, arm, each=300):
    """Return places along the arcs, (K, 1 + S each, 3), of bends (K, S, 2)."""
    out, start, turn = [np.zeros((len(bends), 1, 3))], np.zeros((len(bends), 3)), np.tile(np.eye(3), (len(bends), 1, 1))
    share = np.arange(1, each + 1) / each
    for number, section in enumerate(arm.sections):
        angle = np.maximum(np.linalg.norm(bends[:, number], axis=-1), 1e-9)
        side = np.zeros((len(bends), 3))
        side[:, :2] = bends[:, number] / angle[:, None]
        passed = angle[:, None] * share
        ahead = np.sin(passed)[..., None] * np.array([0, 0, 1.0])
        own = (ahead + (1 - np.cos(passed))[..., None] * side[:, None]) * (section.length / angle)[:, None, None]
        out.append(start[:, None] + np.einsum("kij,kmj->kmi", turn, own))
        start = out[-1][:, -1]
        axis = np.cross([0, 0, 1.0], side)
        K = np.zeros((len(bends), 3, 3))
        K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -axis[:, 2], axis[:, 1], -axis[:, 0]
        K -= K.swapaxes(1, 2)
        sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
        turn = turn @ (np.eye(3) + sine * K + (1 - cosine) * K @ K)
    return np.concatenate(out, axis=1)


def distances(points, objects):
    """Return the distance of points (..., 3) to the nearest object, 0 inside; to planes below 0 behind them."""
    return np.min([_distance(each, points) for each in objects], axis=0)


def _distance(each, points):
    from scipy.spatial.transform import Rotation

    w, x, y, z = each.quaternion
    local = Rotation.from_quat([x, y, z, w]).inv().apply((points - np.array(each.position)).reshape(-1, 3))
    if each.shape == "plane":
        return local[:, 2].reshape(points.shape[:-1])
    nearest, grown = local.copy(), 0.0
    half = 0.5 * (each.length or 0.0)
    if each.shape == "box":
        nearest = np.clip(local, -0.5 * np.array(each.size), 0.5 * np.array(each.size))
    elif each.shape == "cylinder":
        across = np.linalg.norm(local[:, :2], axis=-1, keepdims=True)
        nearest[:, :2] *= np.minimum(1.0, each.radius / np.maximum(across, 1e-300))
        nearest[:, 2] = np.clip(local[:, 2], -half, half)
    else:
        nearest = np.zeros_like(local)
        nearest[:, 2] = np.clip(local[:, 2], -half, half)
        grown = each.radius
    return (np.maximum(np.linalg.norm(local - nearest, axis=-1) - grown, 0.0)).reshape(points.shape[:-1])


def clearances(bends, arm, each=300):
    """Return clearances of poses [m], shape (K,), of bends (K, S, 2): between samples, an arm may be less clear.

    The plate between sections is as thick as the thicker of them; half a link of it belongs to the next section.
    """
    far = distances(arcs(bends, arm, each), arm.world.objects)
    radius = np.full(far.shape[1], arm.contact_radii[0])
    for number, section in enumerate(arm.sections[1:], 1):
        plate = 1 + number * each + int(np.floor(0.5 * section.link_pitch / section.length * each))
        radius[plate:] = arm.contact_radii[number]
    return (far - radius).min(axis=1)


def solvable(arm, target, margin, points=1500):
    """Return whether dense sampling of the family finds a pose that is clear by a margin."""
    for curve in inverse.solve_all(target, shape.backbone(arm), points=points):
        for first in range(0, len(curve), 500):
            part = curve[first : first + 500]
            if (clearances(part, arm, 60) >= margin).any():
                near = part[clearances(part, arm, 60) >= margin]
                if (clearances(near, arm, 400) >= margin + 2e-5).any():
                    return True
    return False


def course(number):
    """Return an arm of two sections with a post in the way of a plain course, and its targets, shape (101, 3); or None.

    None where the arm does not reach the targets, whatever is in its way.
    """
    rng = np.random.default_rng([number, 7])
    arm = presets.two()
    share, backbone = np.linspace(0, 1, 101), shape.backbone(arm)
    azimuth = rng.uniform(-3, 3) + rng.uniform(1, 5) * share
    far = rng.uniform(0.66, 0.85) * arm.length + 0.02 * np.sin(2 * np.pi * share)
    off = rng.uniform(0.3, 1.2) + rng.uniform(-0.3, 0.3) * share
    ways = np.sin(off) * np.cos(azimuth), np.sin(off) * np.sin(azimuth), np.cos(off)
    targets = far[:, None] * np.stack(ways, axis=-1)
    if not inverse.solve(targets, backbone).reachable.all():
        return None
    plain = inverse.track(targets, backbone).bends[rng.integers(101)]
    at = shape.position(plain.reshape(-1), arm, rng.uniform(0.3, 0.65)) + rng.normal(scale=0.01, size=3)
    radius, length = rng.uniform(0.005, 0.012), rng.uniform(0.06, 0.2)
    post = Object(
        name="post", shape="cylinder", radius=radius, length=length, position=tuple(at), axis=tuple(_direction(rng))
    )
    return replace(arm, world=replace(arm.world, objects=(post,))), targets


def connected(arm, targets, margin, points=200, step=0.24):
    """Return whether a chain of clear poses, one for each target, has steps of the bends below `step` [rad]."""
    reached = None
    for target in targets:
        found = np.concatenate(inverse.solve_all(target, shape.backbone(arm), points=points))
        found = found[clearances(found, arm, 60) >= margin]
        if reached is not None:
            apart = ((found[:, None] - reached[None]) ** 2).sum(axis=(-1, -2))
            found = found[(apart < step**2).any(axis=1)]
        reached = found
        if not len(reached):
            return False
    return True
