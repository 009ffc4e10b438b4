"""How the arm looks: cameras that leave words and plots free, swelling muscles, soft shadow, the analytic line."""

from dataclasses import replace

import numpy as np
import pytest
from test_rendering import NOTHING, project, samples_of, spiral

from contarm_sim import presets
from contarm_sim.kinematics import arc
from contarm_sim.mjcf import scene_spec
from contarm_sim.mjcf.framing import FOVY, Frame, axes, place
from contarm_sim.mjcf.scene import line_spacing
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.tendon import Tendon
from contarm_sim.view.colours import ANALYTIC, SCENARIOS, rgb
from contarm_sim.view.rendering.braid import braid
from contarm_sim.view.rendering.cameras import Camera, extent
from contarm_sim.view.rendering.draw import ArmRenderer
from contarm_sim.view.rendering.floor import shadow
from contarm_sim.view.rendering.ghost import fade
from contarm_sim.view.rendering.tubes import smooth


def seen_at(points, eye, turn, aspect):
    """Places in the picture, -1 to 1 to the right and upwards, by the pinhole formula."""
    x, y, z = ((points - eye) @ turn.T).T
    half = np.tan(np.radians(FOVY / 2)) * -z
    return np.stack([x / half / aspect, y / half], axis=1)


@pytest.mark.parametrize("angles", [(-62, 14), (0, 6), (-90, 89), (200, -30)])
@pytest.mark.parametrize("cards", [(0.0, 0.0), (0.28, 0.3)])
def test_a_camera_is_as_near_as_words_and_plots_allow(angles, cards):
    frame, turn = Frame(aspect=16 / 9, top=0.08, cards=cards), axes(*angles)
    rng = np.random.default_rng(1)
    for size in (0.01, 1.0, 30.0):
        points = size * rng.normal(size=(200, 3)) * [1.0, 0.6, 0.4]
        eye = place(points, 0.0, turn, frame)
        middle = points.mean(axis=0)

        def free(eye, points=points):
            x, y = seen_at(points, eye, turn, frame.aspect).T
            beside = np.abs(x) > 1 - 2 * cards[0]
            inside = (np.abs(x) < 0.9401) & (y > -0.9401) & (y < 0.7801)
            return inside.all() and (not cards[1] or np.all(y[beside] > -1 + 2 * cards[1] - 1e-6))

        assert free(eye)
        nearer = eye + 0.02 * ((middle - eye) @ turn[2]) * turn[2]
        shifts = 0.05 * size * np.array([[i, j, 0] for i in range(-4, 5) for j in range(-4, 5)]) @ turn
        assert cards[1] or not any(free(nearer + shift) for shift in shifts)


def test_a_run_is_within_its_extent_and_in_all_cameras(arm):
    run = spiral(arm)
    seen = extent(run)
    for points in (run.stations.reshape(-1, 3), run.target):
        assert np.all(points >= seen.min(axis=0) - 0.01 * arm.length)
        assert np.all(points <= seen.max(axis=0) + 0.01 * arm.length)
    world = seen + scene_spec(arm).compile().body("base").pos
    frame = Frame(aspect=16 / 9, top=0.08, cards=(0.28, 0.3))
    near = {}
    for name in ("front", "side", "top", "orbit"):
        camera = Camera(name, arm, world, frame)
        for share in np.linspace(0, 1, 9):
            eye = camera.at(np.zeros(3), share)
            turn = axes(eye.azimuth - 180, -eye.elevation)
            x, y = seen_at(world, eye.lookat + eye.distance * turn[2], turn, frame.aspect).T
            assert np.abs(x).max() < 1
            assert y.max() < 0.84
            assert y.min() > -1
        near[name] = eye.distance
    whole = {name: Camera(name, arm, None, frame).at(np.zeros(3), 0.0).distance for name in near}
    assert all(near[name] < whole[name] for name in near)  # a spiral takes less room than all that can be reached


def test_the_fibres_of_a_braid_keep_their_length():
    law, rest = McKibben(), 0.4
    lengths = np.linspace(0.75, 1.05, 7) * rest
    found = law.diameter_at(lengths, rest)
    turned = rest * np.tan(law.braid_angle)  # of a fibre around a braid at rest
    fibre = np.hypot(lengths, turned * found / law.diameter)
    np.testing.assert_allclose(fibre, rest / np.cos(law.braid_angle), rtol=1e-12)
    assert np.all(np.diff(found) < 0)
    assert law.diameter_at(rest, rest) == pytest.approx(law.diameter)
    assert law.diameter_at(2 * rest, rest) == law.braid_min_diameter
    np.testing.assert_array_equal(Tendon(diameter=0.002).diameter_at(lengths, rest), 0.002)


def test_the_tube_appears_smoothly_about_one_per_cent():
    distance = np.linspace(0, 0.03, 3001)
    share = fade(distance)
    assert share[distance <= 0.005].max() == 0
    assert share[distance >= 0.015].min() == 1
    assert fade(np.array(0.01)) == pytest.approx(0.5)
    assert np.diff(share).min() >= 0
    assert np.diff(share).max() < 0.0016  # a hundredth of a per cent of length changes it by a hundredth or so


def test_a_shadow_lies_where_the_light_puts_it_and_is_softer_from_higher():
    slant, spread = np.array([-0.3, 0.25]), []
    grid = 2 * (np.arange(128) + 0.5) / 128 - 1
    for height in (0.1, 0.8):
        dark = shadow(np.array([[0.2, -0.1, height]]), np.array([0.05]), np.array([0.1]), slant, np.zeros(2), 1.0, 128)
        assert 0 <= dark.min() < dark.max() < 1
        middle = np.array([dark.sum(axis=0) @ grid, dark.sum(axis=1) @ grid]) / dark.sum()
        np.testing.assert_allclose(middle, np.array([0.2, -0.1]) + height * slant, atol=0.01)
        spread.append(np.sqrt(dark.sum(axis=0) @ (grid - middle[0]) ** 2 / dark.sum()))
    assert np.abs(np.diff(dark, axis=0)).max() < 0.03  # no step
    assert spread[1] > 1.7 * spread[0]


def test_the_braid_repeats_without_a_seam():
    tile = braid()[..., 0].astype(int)
    for axis in (0, 1):
        inside = np.abs(np.diff(tile, axis=axis)).max()
        seam = np.abs(np.take(tile, 0, axis) - np.take(tile, -1, axis)).max()
        assert seam <= inside
    assert np.ptp(tile) > 80


def test_a_smooth_curve_runs_through_the_stations_of_an_arc():
    bend, xi = np.array([1.2, 0.7]), np.linspace(0, 1, 25)
    points, frames = arc.position(bend, 0.37, xi), arc.rotation(bend, xi)
    curve, turned = smooth(points, frames, 4)
    assert len(curve) == len(turned) == 97
    np.testing.assert_allclose(curve[::4], points, atol=1e-15)
    dense = arc.position(bend, 0.37, np.linspace(0, 1, 5001))
    assert np.linalg.norm(curve[:, None] - dense, axis=2).min(axis=1).max() < 1.2e-4
    np.testing.assert_allclose(turned, arc.rotation(bend, np.linspace(0, 1, 97)), atol=2e-3)


def test_lines_on_the_floor_are_round_numbers_apart():
    apart = {length: line_spacing(Arm(length=length)) for length in (0.06, 0.37, 1.0, 3.0)}
    assert apart == pytest.approx({0.06: 0.02, 0.37: 0.1, 1.0: 0.2, 3.0: 1.0})


@pytest.mark.gl
def test_muscles_are_drawn_as_thick_as_their_law_says(gl, arm):
    samples = samples_of(arm, [1.5, 0.0])
    with ArmRenderer(arm, 160, 120) as renderer:
        renderer.frame(samples, 0, NOTHING)
        scene, model = renderer._renderer.scene, renderer._model
        lengths = arm.length - arm.muscle_radius * 1.5 * np.cos(arm.routing.angles)
        for i, length in enumerate(lengths):
            number = model.skin(f"muscle_{i + 1}").id
            first = 3 * scene.skinvertadr[number]
            vertices = scene.skinvert[first : first + 3 * scene.skinvertnum[number]].reshape(-1, 17, 3)
            radius = np.linalg.norm(vertices[:, :-1] - vertices[:, :-1].mean(axis=1, keepdims=True), axis=2)
            wanted = 0.5 * arm.muscle.diameter_at(length, arm.muscle_rest_length)
            np.testing.assert_allclose(radius, wanted, rtol=2e-3)


@pytest.mark.gl
def test_a_line_over_the_arm_and_no_tube_where_arc_and_arm_agree(gl, arm):
    bend, violet = np.array([1.2, 0.9]), 255 * np.array(rgb(ANALYTIC))
    agreeing, apart = samples_of(arm, bend), samples_of(arm, bend, bent=0.8 * bend)
    with ArmRenderer(arm, 640, 480) as renderer:
        pictures = []
        for samples in (agreeing, apart):
            plain = renderer.frame(samples, 0, NOTHING).astype(int)
            drawn = renderer.frame(samples, 0, replace(NOTHING, ghost=True)).astype(int)
            pictures.append((plain, drawn))
    line = project(arm, arc.position(bend, arm.length, np.linspace(0.02, 0.98, 150)), 640, 480)
    for _, drawn in pictures:
        rows, columns = np.nonzero(np.abs(drawn - violet).max(axis=2) < 70)
        distance = np.linalg.norm(np.stack([columns + 0.5, rows + 0.5], axis=1)[None] - line[:, None], axis=2)
        assert np.quantile(distance.min(axis=1), 0.95) < 2.5  # seen all along, before the muscles too
    touched = [np.mean(np.abs(drawn - plain).max(axis=2) > 4) for plain, drawn in pictures]
    assert touched[0] < 0.02
    assert touched[1] > 2 * touched[0]


@pytest.mark.gl
def test_the_mount_of_a_hanging_arm_is_cut_away_from_above(gl):
    one = presets.two()
    with ArmRenderer(one, 64, 48, "top") as renderer:
        assert renderer._model.geom("column").group[0] == 5
    with ArmRenderer(one, 64, 48, "front") as renderer:
        assert renderer._model.geom("column").group[0] != 5


def test_every_load_and_scenario_has_a_look_of_its_own_without_colour_too(arm):
    from contarm_sim.studies.scenarios import scenarios, under_loads

    names = [scenario.name for scenario in scenarios(arm)]
    looks = [SCENARIOS[name] for name in names]
    for part in ("colour", "mark"):
        assert len({getattr(look, part) for look in looks}) == len(names)
    dashes = [SCENARIOS[name].dashes for name in (*under_loads(arm), "upright")]
    assert len(set(dashes)) == 4
    assert SCENARIOS["free"] == SCENARIOS["ideal"]
