"""Arms of several sections in pictures: what is drawn is where it should be; the live arm is pulled without jumps."""

import csv

import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from contarm_sim.kinematics import sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.moments import weight_moment
from contarm_sim.mjcf import scene_spec
from contarm_sim.mjcf.outline import outline
from contarm_sim.model.arm import Arm
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.compare import compare
from contarm_sim.view.figures import figures_of, reach
from contarm_sim.view.figures.common import followed
from contarm_sim.view.live.redundancy import Redundancy
from contarm_sim.view.live.session import Session
from contarm_sim.view.rendering.backbone import _PALER
from contarm_sim.view.rendering.draw import ArmRenderer, Overlays
from contarm_sim.view.rendering.film import Look, film
from contarm_sim.view.report.budget import draw_budget
from contarm_sim.view.report.run_figures import draw_muscles, draw_path
from contarm_sim.view.report.samples_csv import write_samples
from contarm_sim.view.sections import muscle_hexes, section_colour, section_hex, section_places, tube_radii
from contarm_sim.view.style import drawn, save
from contarm_sim.view.workspace import around, folds, hull, workspace

NOTHING = Overlays(path=False, trace=False, target=False, ghost=False, frames=False)
SECTIONS = (
    Section(length=0.2, links=6, mass=0.12),
    Section(length=0.17, links=5, mass=0.1, bending_stiffness=0.08),
    Section(length=0.12, links=4, mass=0.05, bending_stiffness=0.06),
)
BACKBONE = Backbone(lengths=(0.2, 0.17), limits=(2.0, 1.5))


def arm(count=2, **world):
    lines = tuple(Routing(count=3 + i, offset=0.4 * i, radius=0.016 - 0.002 * i) for i in range(count))
    return Arm(sections=SECTIONS[:count], routings=lines, **world)


@pytest.fixture(scope="module")
def moved():
    """A short motion of two sections."""
    time = np.arange(31) / 100
    angle = 5 * time[:, None] ** 2
    bend = np.concatenate([angle * [1.0, 0.5], angle * [-0.5, 1.0]], axis=1)
    return simulate(arm(), Reference.from_bends(bend, arm(), time))


def drawn_poses(backbone, count=20_000, seed=4):
    rng = np.random.default_rng(seed)
    limits = np.array(backbone.limits)
    angle, plane = rng.uniform(size=(count, len(limits))) * limits, rng.uniform(-np.pi, np.pi, (count, len(limits)))
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)


@pytest.mark.parametrize("lengths", [(0.3,), (0.2, 0.17), (0.06, 0.3), (0.2, 0.17, 0.12), (0.1,) * 6])
def test_the_outline_encloses_every_centreline_and_no_more(lengths):
    one = Arm(sections=tuple(Section(length=length, links=4) for length in lengths))
    corners = np.array(outline(one))
    assert corners[:, 0].min() >= 0
    backbone = Backbone(lengths=lengths, limits=np.pi - 1e-9)
    bends = drawn_poses(backbone, 3000)
    planar = bends[:1500]
    planar[..., 1], planar[..., 0] = 0.0, np.round(planar[..., 0] / (np.pi / 3)) * (np.pi / 3 - 1e-9)
    places = sections.position(bends[:, None], backbone, np.linspace(0, 1, 25)).reshape(-1, 3) / one.length
    seen = np.stack([np.hypot(places[:, 0], places[:, 1]), places[:, 2]], axis=1)
    angle = np.linspace(0, np.pi, 37)
    ways = np.stack([np.sin(angle), np.cos(angle)])
    room = (corners @ ways).max(axis=0) - (seen @ ways).max(axis=0)
    assert room.min() > -0.01  # directions and bends are taken in steps
    assert (corners @ ways).max(axis=0)[0] == pytest.approx(1.0)  # straight up
    if len(lengths) == 1:
        assert corners[:, 0].max() == pytest.approx(0.7246, abs=2e-3)  # (1 - cos b)/b at its largest


def test_the_floor_lies_below_all_that_several_sections_can_touch():
    for count in (2, 3):
        one = arm(count)
        model = scene_spec(one).compile()
        height = model.body("base").pos[2]
        lowest = min(z for _, z in outline(one)) * one.length
        assert height + lowest > 0.1 * one.length


def test_sections_are_drawn_in_their_colours(gl):
    one, pictures = arm(3), []
    with ArmRenderer(one, 320, 240) as renderer:
        model = renderer._model
        for station, number in (("section_1_link_02", 0), ("section_2_link_02", 1), ("section_3_link_02", 2)):
            colour = model.mat_rgba[model.geom_matid[model.geom(f"{station}_disk").id], :3]
            paler = 1 - (1 - colour) / (1 - np.array(section_colour(number)))  # its colour, mixed with white
            np.testing.assert_allclose(paler, paler[0], atol=1e-6)
            assert paler[0] == pytest.approx(1 - _PALER, abs=1e-6)
        bend = np.array([0.5, 0.1, -0.4, 0.6, 0.2, 0.3])
        qpos = renderer.bent(bend)
        renderer._pose(qpos)
        tip = renderer.to_world(shape.chain_tip(bend, one))
        np.testing.assert_allclose(renderer._data.body("tip").xpos, tip, atol=2e-3)
        pictures.append(renderer.pose(qpos))
    assert pictures[0].std() > 10


def test_the_ghost_covers_all_sections_and_marks_their_ends(moved, gl):
    one = moved.arm
    with ArmRenderer(one, 320, 240) as renderer:
        bare = renderer.frame(moved, 30, NOTHING).astype(int)
        before = renderer._renderer.scene.ngeom
        ghost = renderer.frame(moved, 30, Overlays(False, False, False, True, False)).astype(int)
        scene = renderer._renderer.scene
        added = [np.array(scene.geoms[i].pos) for i in range(before, scene.ngeom)]
        changed = np.argwhere(np.abs(ghost - bare).sum(axis=2) > 24)
        end = renderer.to_world(shape.position(moved.bend[30], one, 0.2 / 0.37))
    assert len(changed) > 200
    ring = [place for place in added if np.linalg.norm(place - end) < 1.5 * tube_radii(one)[0]]
    assert len(ring) >= 12
    places = section_places(one, 12)
    assert places[0][0] == 0
    assert places[1][-1] == 1
    assert places[0][-1] == places[1][0] == pytest.approx(0.2 / 0.37)


def test_a_film_says_the_bends_of_all_sections_and_has_its_plots(moved, gl):
    frames = list(film(moved, [0, 30], Look(960, 540)))
    assert len(frames) == 2
    assert np.abs(frames[1].astype(int) - frames[0]).max() > 50
    cables = Arm(sections=SECTIONS[:2], laws=(Tendon(), Tendon()))
    time = np.arange(11) / 100
    pulled = simulate(cables, Reference.from_bends(np.outer(time, [1.0, 0, 0, 1.0]), cables, time))
    (picture,) = film(pulled, [10], Look(960, 540))
    assert picture.shape == (540, 960, 3)


def test_six_muscles_of_a_section_have_six_colours_and_sections_their_own():
    many = Arm(sections=SECTIONS[:2], routings=(Routing(count=6), Routing(count=4)))
    colours = muscle_hexes(many)
    assert len(set(colours[:6])) == 6
    assert colours[6:] == colours[:4]
    assert len({section_colour(number) for number in range(6)}) == 6


def test_a_report_has_columns_and_figures_by_section(moved, tmp_path):
    comparison = compare(moved)
    for name, draw in (
        ("path", draw_path),
        ("budget", draw_budget),
        ("muscles", lambda sheet, run, _: draw_muscles(sheet, run)),
    ):
        save(tmp_path, name, lambda sheet, draw=draw: draw(sheet, moved, comparison))
        assert (tmp_path / f"{name}.png").stat().st_size > 20_000
    write_samples(tmp_path / "samples.csv", {"run": (moved, comparison)})
    rows = list(csv.DictReader((tmp_path / "samples.csv").read_text().splitlines()))
    last = {name: float(value) for name, value in rows[-1].items() if name != "scenario"}
    assert last["section_2_bend_y_rad"] == pytest.approx(moved.bend[-1, 3])
    assert last["section_2_muscle_4_length_m"] == pytest.approx(moved.muscle_lengths[-1, 6])
    assert last["section_1_shape_m"] == pytest.approx(comparison.section_shape[-1, 0], rel=1e-6)


def test_maps_of_the_workspace_hold_all_poses_and_count_them_right():
    found = workspace(BACKBONE, 24, 60_000)
    assert (found.density * found.grid.volumes).sum() == pytest.approx(1.0)
    tips = sections.position(drawn_poses(BACKBONE), BACKBONE)
    hit = found.reached.ravel()[found.grid.cell(tips)]
    assert hit.mean() > 0.995  # cells at an edge may be missed by chance
    outer = hull(BACKBONE)
    seen = np.stack([np.hypot(tips[:, 0], tips[:, 1]), tips[:, 2]], axis=1)
    angle = np.linspace(0, np.pi, 37)
    ways = np.stack([np.sin(angle), np.cos(angle)])
    assert ((outer @ ways).max(axis=0) - (seen @ ways).max(axis=0)).min() > -1e-3
    ring = around(outer, np.array([0.0, np.pi / 2]))
    np.testing.assert_allclose(ring[:, 1], outer[:, [0, 0, 1]] * [0, 1, 1], atol=1e-15)
    # The best pose of a place is at least as good as any pose drawn there.
    bends = drawn_poses(BACKBONE, 300)
    J = sections.jacobian(bends, BACKBONE)[:, :3]
    least = np.linalg.svd(J, compute_uv=False)[:, -1]
    best = found.slowest.ravel()[found.grid.cell(sections.position(bends, BACKBONE))]
    assert (best > 0.8 * least).mean() > 0.99


def test_folds_are_where_two_sections_stop_reaching():
    """At a fold, planar bends move the tip along one line only, or a bend is at its limit: found by differences."""
    curves = folds(BACKBONE, 181)
    outer = hull(BACKBONE, 19)
    away = np.array([np.concatenate([np.linalg.norm(curve - p, axis=1) for curve in curves]).min() for p in outer])
    assert np.sort(away)[: len(outer) - 2].max() < 5e-3  # all but the hull's ends on the axis


def _valued(axes, backbone):
    """Return the share of drawn poses whose tips are on a cell of a map that has a value."""
    (mesh,) = (each for each in axes.collections if isinstance(each, QuadMesh))
    places, values = mesh.get_coordinates(), np.ma.filled(mesh.get_array(), np.nan)
    tips = 1e3 * sections.position(drawn_poses(backbone), backbone)
    column = np.searchsorted(places[0, :, 0], np.hypot(tips[:, 0], tips[:, 1])) - 1
    row = np.searchsorted(places[:, 0, 1], tips[:, 2]) - 1
    found = values[row, column]
    assert np.nanmin(found) < 0.5 * np.nanmax(found)
    return np.isfinite(found).mean()


def test_three_sections_reach_directions_and_two_have_an_elbow(monkeypatch):
    monkeypatch.setattr(reach, "CELLS", 16)
    monkeypatch.setattr(reach, "POSES", 20_000)
    assert "elbow" in figures_of(arm(2))
    assert "elbow" not in figures_of(arm(3))
    assert "spiral" in figures_of(Arm())
    for count in (2, 3):
        one = arm(count)
        sheets = {}
        for name, (_, draw) in figures_of(one).items():
            sheets[name] = drawn(lambda sheet, draw=draw, one=one: draw(sheet, one))
        outer, run = 1e3 * hull(shape.backbone(one)), followed(one)
        sides = [line.get_xydata() for line in sheets["slices"].axes[0].lines if len(line.get_xdata()) == len(outer)]
        for side in (-1, 1):
            assert any(np.allclose(points, outer * [side, 1]) for points in sides)
        for name in ("density", "dexterity"):
            assert _valued(sheets[name].axes[0], shape.backbone(one)) > 0.98, name
        traced = {line.get_label(): line.world for line in sheets["path"].axes[0].lines if hasattr(line, "world")}
        np.testing.assert_allclose(traced["simulated tip"], 1e3 * run.tip, atol=1e-9)
        for number in range(count):
            asked = sheets["angles"].axes[0].lines[count + number].get_ydata()
            np.testing.assert_allclose(asked, np.degrees(np.hypot(*run.bend[:, 2 * number : 2 * number + 2].T)))
        if count == 2:
            lines = [line for line in sheets["elbow"].axes[0].lines if hasattr(line, "world")]
            (target,) = (line.world for line in lines if line.get_label() == "target")
            ends = [line.world[-1] for line in lines if line.get_color() == section_hex(1)]
            assert len(ends) > 5
            np.testing.assert_allclose(ends, np.broadcast_to(target, (len(ends), 3)), atol=1e-3)
    found = workspace(shape.backbone(arm(3)), 12, 100_000)
    assert 0.2 < found.directions.max() <= 1


def test_weight_on_several_sections_is_found_in_one_call():
    one = arm(3, gravity=(1.0, -2.0, 9.0), payload=0.05)
    bend, step = np.array([0.5, 0.1, -0.4, 0.6, 0.2, 0.3]), 1e-5
    xi = (np.arange(3000) + 0.5) / 3000
    ends = np.cumsum([section.length for section in SECTIONS])
    density = np.array([s.mass / s.length for s in SECTIONS])[np.searchsorted(ends, xi * one.length)]

    def work(b):
        places = shape.position(b, one, xi) * (density * one.length / 3000)[:, None]
        return (places.sum(axis=0) + one.payload * shape.position(b, one)) @ np.array(one.gravity)

    rate = [(work(bend + e) - work(bend - e)) / (2 * step) for e in step * np.eye(6)]
    np.testing.assert_allclose(weight_moment(bend, one), rate, atol=5e-5)


@pytest.mark.parametrize("count", [2, 3])
def test_a_live_arm_of_several_sections_goes_where_it_is_aimed(count):
    session = Session(arm(count), "tip")
    bend = np.tile([0.4, 0.3], count)
    session.aim(bend)
    for _ in range(round(4 / session.period)):
        reading = session.tick()
    np.testing.assert_allclose(reading.bend, bend, atol=1e-3)
    assert reading.error < 1e-3 * session.arm.length
    for controller in ("pressure", "servo", "paper"):
        session.change(controller=controller)
        assert np.linalg.norm(session.tick().tip - reading.tip) < 5e-3, controller
        reading = session.reading
    session.aim(np.tile([9.0, 0.0], count) * 0.3)
    assert np.hypot(*session.goal[:2]) == pytest.approx(2.7)
    session.reset()
    assert session.goal.shape == (2 * count,)
    assert not session.goal.any()


def test_four_sections_and_more_are_controlled_half_as_often():
    assert Session(Arm(links=4)).period == pytest.approx(0.01)
    many = Session(Arm(sections=(Section(length=0.1, links=3, mass=0.05),) * 4))
    assert many.period == pytest.approx(0.02)
    many.tick()
    many.tick()
    assert many.plant.data.time == pytest.approx(0.04)


class TestRedundancy:
    @pytest.mark.parametrize("count", [2, 3])
    @pytest.mark.parametrize("taken", ["nearest", "least bend"])
    def test_a_pulled_tip_is_followed_without_a_jump(self, count, taken):
        one = arm(count)
        lead = Redundancy(one)
        lead.taken = taken
        bend = np.array([0.9, 0.2, 0.3, -0.8, 0.4, 0.5])[: 2 * count]
        start, moves = lead.tip(bend), []
        for share in np.linspace(0, 2 * np.pi, 80):
            point = start + 0.02 * one.length * np.array([np.cos(share) - 1, np.sin(share), 0.0])
            new = lead.pull(bend, point)
            assert np.linalg.norm(shape.position(new, one) - point) < 1e-6 * one.length
            moves.append(np.abs(new - bend).max())
            bend = new
        assert max(moves[3:]) < 0.12

    def test_least_bend_bends_less(self):
        lead, bend = Redundancy(arm(3)), np.array([0.9, 0.5, -0.8, 0.4, 0.6, -0.9])
        point = lead.tip(bend)
        lead.taken = "least bend"
        for _ in range(5):
            settled = lead.pull(bend, point)
            assert np.linalg.norm(settled) <= np.linalg.norm(bend) + 1e-9
            bend = settled
        null = np.linalg.svd(sections.jacobian(settled.reshape(3, 2), lead.backbone)[:3])[2][3:]
        assert np.abs(null @ settled).max() < 0.05  # no way along the poses makes it less

    def test_out_of_reach_the_tip_comes_near_and_back(self):
        one = arm(2)
        lead, bend = Redundancy(one), np.array([0.5, 0.2, 0.3, -0.1])
        home = lead.tip(bend)
        away = lead.pull(bend, np.array([0.0, 0.0, 2.0]))
        assert np.linalg.norm(lead.tip(away) - [0, 0, one.length]) < 2e-2
        back = lead.pull(away, home)
        assert np.linalg.norm(lead.tip(back) - home) < 1e-6

    def test_a_kept_direction_stays(self):
        lead, bend = Redundancy(arm(3)), np.array([0.5, 0.3, -0.4, 0.4, 0.3, -0.5])
        lead.direction = shape.rotation(bend, arm(3))[:, 2]
        point = lead.tip(bend) + np.array([0.01, -0.01, 0.005])
        new = lead.pull(bend, point)
        np.testing.assert_allclose(lead.tip(new), point, atol=1e-8)
        np.testing.assert_allclose(shape.rotation(new, arm(3))[:, 2], lead.direction, atol=1e-7)

    def test_the_slider_goes_along_all_poses_of_one_tip(self):
        lead, bend = Redundancy(arm(2)), np.array([0.7, 0.2, 0.3, -0.4])
        poses = np.array([lead.along(bend, share) for share in np.linspace(0, 1, 41)])
        tips = shape.position(poses, arm(2))
        np.testing.assert_allclose(tips, np.broadcast_to(lead.tip(bend), tips.shape), atol=1e-9)
        assert np.abs(np.diff(poses, axis=0)).max() < 0.4
        assert np.ptp(poses, axis=0).max() > 0.3
        share = lead.share(bend)
        np.testing.assert_allclose(lead.along(bend, share), bend, atol=0.05)
