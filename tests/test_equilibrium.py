"""Rest poses of the simulated arm against closed forms, finite differences and converged elastica references."""

import json
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from references import resting
from sampling import bends, differenced_stiffness

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics import arc, chain, hinges, muscles
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.mjcf import names
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.solver import RESIDUAL, Solver
from contarm_sim.statics.stiffness import TangentStiffness

ELASTICA = json.loads((Path(__file__).parent / "data" / "elastica.json").read_text())
ROD = ELASTICA["parameters"]


def _at_rest(arm, bend, controller="servo"):
    return poses_at_rest(arm, resting(arm, bend), controller)


@pytest.mark.parametrize("path", ["parallel", "spans"])
@pytest.mark.parametrize("links", [4, 24, 31])
def test_engine_geometry_is_the_chain_form(links, path):
    """Sites and tendons of MuJoCo at a uniform planar bend, where the two-hinge joint is exactly a ball joint."""
    arm = Arm(links=links, path=path)
    plant = Plant(arm)
    for bend in arc.from_polar(np.array([0.0, 1e-6, 0.5, 2.9]), np.array([0.0, np.pi / 2, np.pi, -np.pi / 2])):
        plant.reset(bend)
        mujoco.mj_forward(plant.model, plant.data)
        stations = chain.station(bend, arm.length, links, np.arange(links + 1))
        np.testing.assert_allclose(plant.stations, stations, atol=1e-14)
        np.testing.assert_allclose(plant.tip_rotation, arc.rotation(bend), atol=1e-13)
        np.testing.assert_allclose(plant.muscle_lengths, routing.lengths_from_bend(bend, arm), atol=1e-14)


@pytest.mark.parametrize("torsion", [None, 0.05])
@pytest.mark.parametrize("links", [4, 24, 31])
def test_engine_geometry_is_that_of_hinge_pairs_in_every_plane(links, torsion):
    plant = Plant(Arm(links=links, torsional_stiffness=torsion))
    arm = plant.arm
    for bend in bends(20, largest=3.0):
        plant.reset(bend)
        mujoco.mj_forward(plant.model, plant.data)
        frames = hinges.frames(bend, arm.length, links)
        np.testing.assert_allclose(plant.stations, frames[:, :3, 3], atol=1e-14)
        np.testing.assert_allclose(plant.rotations, frames[:, :3, :3], atol=1e-13)
        lengths = routing.lengths_from_bend(bend, arm)
        np.testing.assert_allclose(plant.muscle_lengths, lengths, atol=1e-15)
        arc_lengths = arm.length + muscles.deltas_from_bend(bend, arm.muscle_radius)
        np.testing.assert_allclose(lengths, arc_lengths, atol=0.02 / links**2)
        np.testing.assert_allclose(routing.bend_from_lengths(lengths, arm)[0], bend, atol=1e-13)
        # Muscles are drawn where they act: on every link, at the muscle radius.
        for index, name in enumerate(names.muscles(arm)):
            for place, body in enumerate(("base", "link_01", "tip")):
                geom, link = plant.data.geom(f"{body}_{name}"), plant.data.body(body)
                across = link.xmat.reshape(3, 3).T @ (geom.xpos - link.xpos)
                angle = 2 * np.pi * index / 3
                wanted = arm.muscle_radius * np.array([np.cos(angle), np.sin(angle)])
                np.testing.assert_allclose(across[:2], wanted, atol=1e-15, err_msg=f"{place}")


@pytest.mark.parametrize("path", ["parallel", "spans"])
@pytest.mark.parametrize("pull_only", [True, False])
@pytest.mark.parametrize("torsion", [None, 0.05])
def test_tangent_stiffness_is_the_derivative_of_the_forces(pull_only, torsion, path):
    arm = Arm(links=10, gravity=(1, 2, -9), payload=0.1, torsional_stiffness=torsion, path=path)
    plant = Plant(arm, pull_only=pull_only)
    model, data = plant.model, plant.data
    plant.reset(np.array([1.0, 0.7]))
    data.qpos += np.random.default_rng(0).normal(size=model.nq) * 0.02
    data.ctrl[:] = [-0.0195, -0.0025, 0.02]
    mujoco.mj_forward(model, data)
    plant.stiffen_twist()
    K = TangentStiffness(plant, AppliedLoad(plant, Load()))()
    np.testing.assert_allclose(K, differenced_stiffness(plant), atol=1e-7 * np.abs(K).max())


def test_at_rest_without_gravity_the_arm_is_the_chain_and_tensions_are_the_closed_form(arm):
    bend = arc.from_polar(np.radians([0.0, 40, 90, 170, 170]), np.radians([0, 10, 200, -75, 60]))
    samples = _at_rest(arm, bend)
    np.testing.assert_allclose(samples.stations[:, -1], hinges.tip(bend, arm.length, arm.links), atol=1e-9)
    np.testing.assert_allclose(samples.stations[:, -1], chain.tip(bend, arm.length, arm.links), atol=2e-5)
    np.testing.assert_allclose(samples.muscle_tensions, holding_tensions(bend, arm), atol=1e-3)


def test_straight_spans_hold_the_bend_of_their_closed_form(arm):
    arm = replace(arm, path="spans")
    bend = arc.from_polar(np.radians([0.0, 40, 90, 170, 170]), np.radians([0, 10, 200, -75, 60]))
    samples = _at_rest(arm, bend)
    np.testing.assert_allclose(samples.stations[:, -1], chain.tip(bend, arm.length, arm.links), atol=4e-5)
    np.testing.assert_allclose(samples.muscle_tensions[:3], holding_tensions(bend, arm)[:3], rtol=0.01, atol=0.02)


def test_symmetry_under_120_degrees_and_mirror():
    """Rotating the bending plane permutes the muscles; the hinges break the symmetry only by microns at 24 links."""
    arm = Arm()
    plane = np.radians([20, 140, 260, -20])
    samples = _at_rest(arm, arc.from_polar(np.full(4, 1.2), plane))
    lengths, tensions = samples.muscle_lengths, samples.muscle_tensions
    for i in (1, 2):
        np.testing.assert_allclose(lengths[i], np.roll(lengths[0], i), atol=3e-6)
        np.testing.assert_allclose(tensions[i], np.roll(tensions[0], i), atol=0.02)
    np.testing.assert_allclose(lengths[3], lengths[0][[0, 2, 1]], atol=1e-12)


def test_the_residual_is_really_small_and_the_pose_really_stays(arm):
    """Held by its set-points, the arm stepped for two seconds from the rest pose does not move."""
    bend = np.array([[1.0, -0.8]])
    samples = _at_rest(replace(arm, gravity=(0, 0, 9.81), payload=0.1), bend)
    plant = Plant(replace(arm, gravity=(0, 0, 9.81), payload=0.1))
    plant.data.qpos[:] = samples.qpos[0]
    plant.data.ctrl[:] = samples.setpoint[0]
    mujoco.mj_forward(plant.model, plant.data)
    assert np.abs(plant.data.qfrc_smooth).max() <= RESIDUAL
    mujoco.mj_step(plant.model, plant.data, 400)
    mujoco.mj_forward(plant.model, plant.data)
    np.testing.assert_allclose(plant.tip, samples.stations[0, -1], atol=1e-8)


def _free_rod(links, gravity):
    """Return the reference rod with its muscles switched off."""
    arm = Arm(
        length=ROD["length_m"], bending_stiffness=ROD["bending_stiffness_Nm2"], mass=ROD["mass_kg_uniform"],
        gravity=gravity, links=links,
    )  # fmt: skip
    return Plant(arm, actuation="none")


@pytest.mark.parametrize("name", ["B_hang_M0", "B_hor_M0"])
def test_sagging_cantilever_converges_to_the_elastica_with_second_order(name):
    case = next(case for case in ELASTICA["cases"] if case["name"] == name)
    errors = []
    for links in (12, 24, 48):
        plant = _free_rod(links, tuple(case["gravity"]))
        for fraction in (0.25, 0.5, 1.0):
            plant.model.opt.gravity[:] = fraction * np.array(case["gravity"])
            Solver(plant)(np.empty((0, 3)))
        errors.append(np.linalg.norm(plant.tip - case["tip"]) / ROD["length_m"])
    assert errors[1] < 7.5e-4
    if errors[1] > 1e-9:
        np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.15)


def test_an_upright_arm_past_its_buckling_load_does_not_stand():
    """The reference rod weighs 2.8 % more than it can carry; straight is an equilibrium, but not a stable one."""
    plant = _free_rod(24, (0.0, 0.0, -9.81))
    with pytest.raises(EquilibriumError, match="unstable"):
        Solver(plant)(np.empty((0, 3)))
    plant = _free_rod(24, (0.0, 0.0, -9.81 * 0.95))
    assert Solver(plant)(np.empty((0, 3))) <= RESIDUAL


def test_torsional_compliance_lets_a_loaded_arm_twist():
    bend = np.array([[1.2, 0.0]])
    loads = {"gravity": (0.0, 9.81, 0.0), "mass": 0.1}
    stiff, soft = (_at_rest(Arm(**loads, torsional_stiffness=gj), bend) for gj in (50.0, 0.05))
    rigid = _at_rest(Arm(**loads), bend)
    assert np.linalg.norm(stiff.stations - rigid.stations, axis=-1).max() < 2e-4
    assert np.linalg.norm(soft.stations - rigid.stations, axis=-1).max() > 2e-3
