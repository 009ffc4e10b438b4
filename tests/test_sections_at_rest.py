"""Several sections without loads: closed forms against the engine's own sites, and held bends against chain and arc."""

from dataclasses import replace
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sections_at_rest import LEAST, arm_of, chain_frames, random_bends, simulated, smooth_points

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics import hinges, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.mjcf import names

FEW_AND_MANY = [(61, 10), pytest.param(2061, 1000, marks=pytest.mark.slow)]


@pytest.mark.parametrize("size", [2, 3, 4])
def test_chains_of_hinges_are_the_engines_sites(size):
    """Guides of straight spans are sites on every link: that of the last muscle says where its frame is."""
    arm = arm_of(size, 7, "base")
    parts = [replace(part, links=links) for part, links in zip(arm.sections, (5, 8, 7, 6), strict=False)]
    arm = replace(arm, sections=parts, routings=[replace(line, path="spans") for line in arm.routings])
    plant, muscle = Plant(arm), names.muscles(arm)[-1]
    x, y = arm.routings[-1].points[-1]
    bodies = names.stations(arm)
    heights = [part.guide_height for part in arm.sections for _ in range(part.links)]
    for bends in random_bends(0, 20, size):
        turned = [hinges.angles(bend, part.links)[0] for bend, part in zip(bends, arm.sections, strict=True)]
        plant.reset(np.array(turned))  # spans take it for the sum of angles
        mujoco.mj_kinematics(plant.model, plant.data)
        frames = chain_frames(arm, bends)
        for body, frame, height in zip(bodies, frames, heights, strict=False):
            site = plant.data.site(names.guide(body, muscle)).xpos
            np.testing.assert_allclose(site, (frame @ [x, y, height, 1])[:3], atol=1e-12)
        for name, frame in ((names.BASE, frames[0]), (names.TIP, frames[-1])):
            np.testing.assert_allclose(plant.data.site(name).xpos, frame[:3, 3], atol=1e-12)
            np.testing.assert_allclose(plant.data.site(name).xmat.reshape(3, 3), frame[:3, :3], atol=1e-12)


def _ball_chain(backbone):
    """Return a model of ball joints with a site at every station, the ends of connectors among them; and where."""
    bodies, sites, places, end, step = "", 1, [0.0], 0.0, 0.0
    for length, links, straight in zip(backbone.lengths, backbone.links, backbone.connectors, strict=True):
        pitch = length / links
        for number in range(links):
            bodies += f'<body pos="0 0 {step + 0.5 * pitch!r}"><joint type="ball"/><geom size="0.01" mass="1"/>'
            bodies += f'<site name="{sites}" pos="0 0 {0.5 * pitch!r}"/>'
            step, sites = 0.5 * pitch, sites + 1
            places.append(end + (number + 1) * pitch)
        bodies += f'<site name="{sites}" pos="0 0 {0.5 * pitch + straight!r}"/>'
        step, end, sites = step + straight, end + length + straight, sites + 1
        places.append(end)
    xml = f'<mujoco><worldbody><site name="0"/>{bodies}{"</body>" * sum(backbone.links)}</worldbody></mujoco>'
    return mujoco.MjModel.from_xml_string(xml), np.array(places) / end


@pytest.mark.parametrize("connectors", [(0.0,), (0.02, 0.01, 0.03)])
def test_chains_of_ball_joints_are_the_engines_sites(connectors):
    backbone = Backbone(lengths=(0.2, 0.17, 0.1), links=(6, 9, 1), connectors=connectors)
    model, xi = _ball_chain(backbone)
    data = mujoco.MjData(model)
    for bends in random_bends(1, 20, 3):
        turns = np.repeat(bends / np.array(backbone.links)[:, None], backbone.links, axis=0)
        vectors = np.stack([-turns[:, 1], turns[:, 0], 0 * turns[:, 0]], axis=1)
        data.qpos[:] = np.roll(Rotation.from_rotvec(vectors).as_quat(), 1, axis=1).ravel()
        mujoco.mj_kinematics(model, data)
        found = sections.transform(np.broadcast_to(bends, (len(xi), 3, 2)), backbone, xi)
        np.testing.assert_allclose(data.site_xpos, found[:, :3, 3], atol=1e-12)
        np.testing.assert_allclose(data.site_xmat[-1].reshape(3, 3), found[-1, :3, :3], atol=1e-12)


@pytest.mark.parametrize("start", ["section", "base"])
@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize(("seed", "count"), FEW_AND_MANY)
def test_bends_held_by_tensions_are_chain_and_arc(seed, count, size, start):
    """At 24 links a section, within 0.01 % of length of the chain and 0.15 % of the arc, at every station."""
    arm, held = arm_of(size, 24, start), random_bends(seed, count, size)
    held[:2, 0], held[1, 1:] = 0.0, 1e-9  # straight at the base, nearly so beyond
    for bends in held:
        found = simulated(arm, bends)
        assert found.stable
        assert found.muscle_tensions.min() == pytest.approx(LEAST)
        points = found.frames[:, :3, 3]
        np.testing.assert_allclose(found.frames, chain_frames(arm, bends), atol=1e-8)
        assert np.linalg.norm(points - smooth_points(arm, bends, 24), axis=1).max() <= 1e-4 * arm.length
        assert np.linalg.norm(points - smooth_points(arm, bends), axis=1).max() <= 1.5e-3 * arm.length


@pytest.mark.parametrize(("size", "start"), [(2, "section"), (3, "base")])
@pytest.mark.parametrize(("seed", "count"), [(62, 3), pytest.param(2062, 100, marks=pytest.mark.slow)])
def test_they_come_to_the_arc_with_second_order(seed, count, size, start):
    held, errors = random_bends(seed, count, size), []
    for links in (12, 24, 48):
        arm = arm_of(size, links, start)
        points = [simulated(arm, bends).frames[:, :3, 3] - smooth_points(arm, bends) for bends in held]
        errors.append(np.linalg.norm(points, axis=-1).max(axis=1))
    for coarse, fine in pairwise(errors):
        np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.3)  # errors of sections may cancel
        assert np.median(np.log2(coarse / fine)) == pytest.approx(2, abs=0.02)
