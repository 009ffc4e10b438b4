"""Contact in numbers: tables, summaries, the report of a run; all about motions whose contacts are made by hand."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.compare import compare
from contarm_sim.results.touched import touched
from contarm_sim.view.report.contact_words import in_numbers, paragraph, rows, what_it_touches
from contarm_sim.view.report.contacts_csv import write_contacts
from contarm_sim.view.report.headline import headline
from contarm_sim.view.report.output import to_json
from contarm_sim.view.report.run import RunReport
from contarm_sim.view.report.samples_csv import write_samples

POST = Object(name="post", shape="cylinder", radius=0.02, length=0.3, position=(0.3, 0, 0.1), friction=0.5)
BALL = Object(name="ball", shape="sphere", radius=0.02, mass=0.1, position=(-0.3, 0, 0.1))
WALL = Object(name="wall", shape="plane", position=(1.0, 0, 0), axis=(-1, 0, 0))


def motion(objects):
    """Return a quarter of a second without contact."""
    arm = Arm(links=4, objects=objects)
    bend = np.stack([np.linspace(0, 0.4, 26), np.zeros(26)], axis=1)
    return simulate(arm, Reference.from_bends(bend, arm, 0.01 * np.arange(26)), "servo")


@pytest.fixture(scope="module")
def bare():
    return motion(())


@pytest.fixture(scope="module")
def run():
    """Return a motion whose contacts are known: link 3 and the tip with the post, the tip once with the ball."""
    found = motion((POST, BALL, WALL))
    sample = [5, 6, 6, 7, 9, 10, 20]
    station = [3, 3, 4, 3, 4, 4, 4]
    partner = [0, 0, 0, 0, 0, 0, 1]
    force = np.array([[-2, 0, 0], [-4, 1, 0], [-3, 0, 1.5], [-1, 0, 0], [-2, 0, 0], [-2, 0, 0], [0, 0, 6.0]])
    normal = np.array([[-1.0, 0, 0]] * 6 + [[0, 0, 1.0]])
    depth = 1e-4 * np.array([1, 2, 4, 1, 1, 1, 3.0])
    contacts = Contacts(sample, station, partner, force / 10, force, normal, depth, ("post", "ball", "wall"))
    objects = found.objects.copy()
    objects[20:, 0, 2] -= 0.01
    return replace(found, contacts=contacts, objects=objects)


def test_what_is_touched_is_told_object_by_object(run):
    found = touched(run)
    post, ball, wall = found.objects
    assert (found.contacts, found.samples, found.most_links) == (7, 6, 2)
    assert found.largest_force_n == pytest.approx(np.hypot(4, 1) + np.hypot(3, 1.5))
    assert found.largest_force_at_s == pytest.approx(0.06)
    assert found.largest_depth_m == pytest.approx(4e-4)
    assert (post.samples, post.links, post.first_touch_s) == (5, 2, pytest.approx(0.05))
    assert post.longest_touch_s == pytest.approx(0.02)  # samples 5 to 7
    assert post.largest_force_n == pytest.approx(np.linalg.norm([7, 1, 1.5]))  # of both links together
    assert post.friction_used == pytest.approx(1.5 / (0.5 * 3))
    assert post.moved_m is None
    assert ball.moved_m == pytest.approx(0.01)
    assert (wall.samples, wall.first_touch_s, wall.friction_used) == (0, None, None)


def test_every_contact_is_a_row_and_every_sample_says_the_sum(run, bare, tmp_path):
    write_contacts(tmp_path / "contacts.csv", run)
    read = list(csv.DictReader((tmp_path / "contacts.csv").read_text().splitlines()))
    assert len(read) == 7
    assert {name for name in read[0] if not re.search(r"_(m|n|s)$", name)} == {
        "sample", "link", "link_name", "object", "normal_x", "normal_y", "normal_z"
    }  # fmt: skip
    assert [row["link_name"] for row in read[:3]] == ["link_03", "link_03", "tip"]
    assert read[6]["object"] == "ball"
    for row in read:
        sizes = [float(row[f"{name}force_n"]) for name in ("", "normal_", "friction_")]
        assert np.hypot(*sizes[1:]) == pytest.approx(sizes[0])
        assert float(row["point_x_m"]) == pytest.approx(float(row["force_x_n"]) / 10)
    write_samples(tmp_path / "samples.csv", {"run": (run, compare(run))})
    table = list(csv.DictReader((tmp_path / "samples.csv").read_text().splitlines()))
    assert float(table[6]["contact_force_n"]) == pytest.approx(np.hypot(4, 1) + np.hypot(3, 1.5))
    assert [int(table[i]["contacts"]) for i in (0, 5, 6)] == [0, 1, 2]
    assert float(table[6]["contact_depth_m"]) == pytest.approx(4e-4)
    assert float(table[25]["ball_z_m"]) == pytest.approx(run.objects[25, 0, 2])
    write_samples(tmp_path / "bare.csv", {"run": (bare, compare(bare))})
    header = (tmp_path / "bare.csv").read_text().split("\n", 1)[0]
    assert "contact" not in header
    assert ["scenario", *header.split(",")[1:]] == list(table[0])[: header.count(",") + 1]


def test_what_two_links_do_to_each_other_counts_once(run):
    """Both have a contact; the forces cancel, so their sizes are what tells."""
    arm = replace(run.arm.alone, self_contact=True)
    force = [[0, 0, 3.0], [0, 0, -3.0]]
    both = Contacts([4, 4], [0, 3], [0, 0], np.zeros((2, 3)), force, np.sign(force), [1e-5] * 2, ("itself",))
    found = touched(replace(run, arm=arm, contacts=both, objects=None))
    assert (found.contacts, found.largest_force_n) == (2, 3.0)
    assert found.objects[0].largest_force_n == 3.0
    assert "Contacts(2 in 1 samples, with itself; force up to 3 N" in repr(both)


def test_a_step_that_is_too_long_is_told(run):
    fine, coarse = (replace(run, step_error=np.full(len(run), share * run.arm.length)) for share in (5e-4, 2e-3))
    assert "NOT converged" not in repr(fine)
    assert "NOT converged: the time step puts the tip off by up to 0.74 mm" in repr(coarse)


def test_friction_is_never_used_by_more_than_all_of_it(run):
    """The sum of the forces of a link on an edge may be across the normal of the deepest, though none slides."""
    found = run.contacts.where(slice(0, 1))
    edge = replace(found, force=[[-2, 0, 1.05]], normal=[[-1, 0, 0]])
    assert touched(replace(run, contacts=edge)).objects[0].friction_used == 1.0


def test_tables_of_pandas_and_xarray_have_contact(run, bare):
    pytest.importorskip("pandas")
    frame = run.to_dataframe()
    assert frame["contacts"][6] == 2
    assert frame["contact_force [N]"][20] == pytest.approx(6.0)
    assert frame["ball_z [m]"].iloc[-1] == pytest.approx(run.objects[-1, 0, 2])
    assert not [name for name in bare.to_dataframe() if "contact" in name]
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert data.contact_force.sel(touched="ball", axis="z")[20] == 6.0
    assert data.link_contact_force[6].values.tolist() == pytest.approx([0, 0, 0, np.hypot(4, 1), np.hypot(3, 1.5)])
    assert data.object_position.attrs["units"] == "m"
    assert "contact_force" not in bare.to_xarray()


def test_a_trajectory_says_what_it_touched(run, bare):
    assert "touched post, ball: contact force up to 7.48 N, depth up to 0.4 mm" in repr(run)
    assert "touched" not in repr(bare)
    nothing = replace(run, contacts=run.contacts.where(slice(0, 0)))
    assert "touched nothing of post, ball, wall" in repr(nothing)
    assert touched(nothing).largest_force_at_s is None


def test_the_page_of_a_run_has_a_section_on_contact_only_where_something_can_be_touched(run, bare, tmp_path):
    pages = {}
    for name, each in (("run", run), ("bare", bare)):
        job, folder = RunReport(each, poses=2), tmp_path / name
        folder.mkdir()
        summary = job.told("bend", command="contarm run")
        job.write(folder)
        job.write_page(folder, summary)
        pages[name], told = (folder / "report.html").read_text(), json.loads(to_json(summary))
        assert (folder / "contacts.csv").is_file() == (name == "run")
        assert ("contact" in job.figures) == (name == "run")
        assert ("contact" in told) == (name == "run")
    page = pages["run"]
    assert "What the arm touches" in page
    assert "What the arm touches" not in pages["bare"]
    assert "It never touches the wall." in page
    cells = re.findall(r'<tr><th scope="row">ball</th>(.*?)</tr>', page)[0]
    assert re.findall("<td>(.*?)</td>", cells) == ["0.20", "0.00", "1", "6", "0.3", "0", "10"]
    assert "the arm touches the post and ball." in re.findall("<h1>(.*?)</h1>", page)[0]


def test_words_name_what_is_touched():
    one = {"name": "post", "samples": 1, "first_touch_s": 0.1, "longest_touch_s": 0.2, "largest_force_n": 3.0,
           "largest_depth_m": 1e-4, "links": 2, "friction_used": None}  # fmt: skip
    many = [one | {"name": name} for name in ("a", "b", "c", "d", "e", "itself")]
    found = {"contacts": 1, "samples": 1, "most_links": 1, "largest_force_n": 3.0, "largest_force_at_s": 0.1,
             "largest_depth_m": 1e-4, "objects": many}  # fmt: skip
    summary = {"samples": 50, "contact": found, "constant_curvature": {"holds": True, "error_percent": 0.5}}
    assert what_it_touches(summary) == "the arm touches the a, b, c, 2 other objects and itself"
    assert headline(summary).endswith(
        "of the arm’s length, though the arm touches the a, b, c, 2 other objects and itself."
    )
    assert in_numbers(summary).endswith("in 2 % of samples; contact force up to 3 N, depth up to 0.1 mm")
    none = summary | {"contact": found | {"contacts": 0, "objects": [one | {"samples": 0}]}}
    assert "The arm touches nothing: the post is not touched." in paragraph(none)
    assert rows(none)[0][1][0] == "never"
    assert headline(none) == "Constant curvature holds within 0.50 % of the arm’s length."
