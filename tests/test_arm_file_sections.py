"""Arms of several sections as TOML: read back equal, shared values once, and every mistake said of its section."""

import math
import tomllib
from dataclasses import fields, replace

import numpy as np
import pytest

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_dict, arm_to_dict, arm_to_toml, load_arm
from contarm_sim.model.ideal import Ideal
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.template import arm_template
from contarm_sim.model.tendon import Tendon
from contarm_sim.model.world import World

ISSUE = """
gravity = [0, 0, 9.81]
[muscle]
law = "mckibben"
[[section]]
length = 0.20
links = 12
mass = 0.15
bending_stiffness = 0.1
muscle_radius = 0.018
muscle_count = 3
muscle_offset = 0.0
muscle_from = "section"
[[section]]
length = 0.17
"""


@pytest.fixture
def load(tmp_path):
    def read(text):
        (tmp_path / "arm.toml").write_text(text)
        return load_arm(tmp_path / "arm.toml")

    return read


def _some(rng, kind, **limits):
    """Return a value of a kind with some of its optional and other numbers changed."""
    base, changed = kind(), {}
    for item in fields(base):
        low, high = limits.get(item.name, (None, None))
        if low is not None and rng.random() < 0.4:
            changed[item.name] = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    return replace(base, **changed)


def _law(rng):
    limits = {"servo_stiffness": (1e3, 1e5), "servo_time": (1e-3, 0.1), "min_tension": (0.1, 9.0), "friction": (0.1, 2),
              "stiffness": (1e3, 1e5), "pretension": (0.1, 9.0), "wall": (1.5e-3, 4e-3), "braid_friction": (0.1, 2),
              "passive_stiffness": (10, 900), "diameter": (1e-3, 9e-3)}  # fmt: skip
    return _some(rng, (McKibben, Tendon, Ideal)[rng.integers(3)], **limits)


def _routing(rng):
    count = int(rng.choice([0, 1, 2, 3, 4, 6, 9]))
    offset = float(rng.choice([0.0, rng.uniform(-7, 7)]))
    where = {"path": str(rng.choice(["parallel", "spans"])), "start": str(rng.choice(["section", "base"]))}
    at = tuple(np.sort(rng.uniform(-3, 3, max(count, 1))).tolist()) if rng.random() < 0.3 else None
    return Routing(radius=rng.uniform(0.005, 0.03), offset=offset, **where, **({"at": at} if at else {"count": count}))


def random_arm(rng):
    """Return an arm of one to six sections, its laws often alike in part."""
    count = int(rng.integers(1, 7))
    limits = {"length": (0.12, 1.0), "mass": (0.05, 1.0), "bending_stiffness": (0.01, 1.0), "damping_time": (0.01, 0.1),
              "torsional_stiffness": (0.01, 1), "joint_friction": (1e-4, 1e-3),
              "section_radius": (0.01, 0.03), "contact_radius": (0.01, 0.05)}  # fmt: skip
    law = _law(rng)
    return Arm(
        sections=tuple(replace(_some(rng, Section, **limits), links=int(rng.integers(2, 66))) for _ in range(count)),
        routings=tuple(_routing(rng) for _ in range(count)),
        laws=tuple(law if rng.random() < 0.5 else _law(rng) for _ in range(count)),
        world=World(
            gravity=tuple(rng.normal(size=3).tolist()) if rng.random() < 0.5 else (0.0, 0.0, 0.0),
            base_orientation=(0.5, 0.5, -0.5, 0.5) if rng.random() < 0.3 else None,
            payload=float(rng.random()),
        ),
    )


def test_random_arms_read_back_equal(load):
    rng = np.random.default_rng(0)
    for _ in range(200):
        arm = random_arm(rng)
        assert arm_from_dict(arm_to_dict(arm)) == arm
        assert load(arm_to_toml(arm)) == arm
        assert load(arm_template(arm)) == arm


def test_the_file_of_the_issue(load):
    assert load(ISSUE) == Arm(
        sections=(Section(length=0.2, links=12, mass=0.15, bending_stiffness=0.1), Section(length=0.17)),
        gravity=(0, 0, 9.81),
    )
    assert load("length = 0.3\n[muscle]\nwall = 0.001") == Arm(length=0.3, muscle=McKibben(wall=0.001))
    assert load("[[section]]\nlength = 0.3") == Arm(length=0.3)


def test_a_section_overrides_what_all_share(load):
    arm = load("""
        [muscle]
        max_pressure = "6 bar"
        path = "spans"
        count = 4
        [[section]]
        [[section]]
        min_tension = "4 N"
        muscle_angles = ["10 deg", "1.5 rad"]
        [section.muscle]
        wall = "1.5 mm"
        [[section]]
        muscle_radius = "15 mm"
        muscle = {law = "tendon", stiffness = "15 kN", path = "parallel"}
    """)
    six = McKibben(max_pressure=6e5)
    assert arm.laws == (six, McKibben(max_pressure=6e5, min_tension=4.0, wall=0.0015), Tendon(stiffness=15e3))
    given = Routing(path="spans", at=(math.radians(10), 1.5))
    assert arm.routings == (Routing(path="spans", count=4), given, Routing(count=4, radius=0.015))


def test_shared_values_are_written_once():
    arm = Arm(sections=(Section(), Section(), Section()), laws=(McKibben(), McKibben(wall=0.001), McKibben()))
    values = tomllib.loads(arm_to_toml(arm))
    assert [table.get("muscle") for table in values["section"]] == [{"wall": 0.002}, {"wall": 0.001}, {"wall": 0.002}]
    assert "wall" not in values["muscle"]
    assert values["muscle"]["max_pressure"] == 7e5
    assert "length" not in values


@pytest.mark.parametrize(
    ("text", "said"),
    [("[[section]]\n[[section]]\nlenght = 1", "section 2: key 'lenght' is unknown; allowed: did you mean 'length'?"),
     ("[[section]]\n[section.muscle]\nmin_tention = 1", "section 1: key 'muscle.min_tention' is unknown"),
     ("length = 1\n[[section]]", "key 'length' is outside of the sections"),
     ("muscle_radius = 1\n[[section]]", "key 'muscle_radius' is outside of the sections"),
     ("lenght = 1\n[[section]]", "key 'lenght' is unknown"),
     ("[section]\nlength = 1", "allowed: tables, [[section]]"), ("section = 3", "allowed: tables, [[section]]"),
     ("section = []", "allowed: tables, [[section]]"), ("section = [3]", "allowed: tables, [[section]]"),
     ("[[section]]\n" * 7, "section is 7 tables; allowed: at most 6"),
     ("[[section]]\n[[section]]\nlength = 1e-6", "section 2: length is 1e-06; allowed: a finite number, at least"),
     ("[[section]]\nlinks = 1", "section 1: links is 1; allowed: a whole number from 2"),
     ("[[section]]\nmuscle_count = 13", "section 1: muscle_count is 13; allowed: a whole number from 0 to 12"),
     ("[[section]]\nmuscle_angles = [1, 2, 4]\nmuscle = {count = 5}", "section 1: muscle.count is given twice"),
     ("[[section]]\nmuscle_count = 2.5", "section 1: muscle_count is 2.5"),
     ("[[section]]\nmuscle_count = 4\nmuscle_angles = [1, 2]", "section 1: muscle_count is 4; allowed: 2, as many"),
     ("[[section]]\nmuscle_angles = ['90 deg', '-270 deg']", "these coincide"),
     ("[[section]]\nmuscle_angles = 'all'", "section 1: muscle_angles is 'all'"),
     ("[[section]]\nmuscle_angles = []", "section 1: muscle_angles is []"),
     ("[[section]]\nmuscle_from = 'tip'", "section 1: muscle_from is 'tip'; allowed: section, base"),
     ("[[section]]\n[[section]]\nmuscle_from = 'base'", "muscle 1 of section 2 is where muscle 1 of section 1 is"),
     ("[[section]]\n[[section]]\nlength = '3 kg'", "section 2: length is '3 kg'; allowed: a number [m]"),
     ("[[section]]\n[[section]]\nmuscle_radius = 18", "section 2: muscle_radius is 18.0; allowed: below length/pi"),
     ("[[section]]\n[[section]]\nmuscle_radius = 18", "in millimetres?"),
     ("[[section]]\n[[section]]\nmass = 1e-9\nlinks = 300", "section 2: mass is 1e-09"),
     ("[[section]]\nlinks = 300\n[[section]]\nlinks = 300", "links is 600; allowed: at most 400 in all"),
     ("[[section]]\nlaw = 'cubic'", "section 1: muscle.law is cubic; allowed: mckibben, tendon, ideal"),
     ("[[section]]\nlaw = 'tendon'\nwall = 1", "section 1: key 'wall' is unknown"),
     ("[[section]]\nwall = 0.002\nmuscle = {wall = 0.002}", "section 1: muscle.wall is given twice"),
     ("[[section]]\nmuscle_count = 3\nmuscle = {count = 3}", "section 1: muscle.count is given twice"),
     ("[[section]]\nmuscle = 3", "section 1: muscle is 3; allowed: a table, [section.muscle]"),
     ("muscle = 3\n[[section]]", "muscle is 3; allowed: a table, [muscle]")],
)  # fmt: skip
def test_mistakes_are_one_line_that_names_file_and_section(load, text, said):
    with pytest.raises(InputError) as caught:
        load(text)
    assert said in str(caught.value)
    assert "arm.toml: " in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [(lambda: Arm(sections=(Section(),) * 7), "sections is 7 of them; allowed: at most 6"),
     (lambda: Section(length=1e-6), "at least 0.001"), (lambda: Section(links=1), "from 2 to 400"),
     (lambda: Routing(at=(0.0, 1.0, 2 * math.pi)), "muscles at places of their own"),
     (lambda: Routing(at=(0.0, math.nan)), "finite angles"), (lambda: Routing(at=()), "1 to 12 finite angles"),
     (lambda: Routing(at=(0.0, 1.0), count=4), "as many as muscle.angles"),
     (lambda: Arm(sections=(Section(),) * 3, routings=(Routing(start="base"),) * 3), "muscles that coincide"),
     (lambda: Arm(sections=(Section(), Section()), routings=(Routing(count=6), Routing(start="base", offset=math.pi))),
      "muscle 3 of section 2 is where muscle 2 of section 1 is")],
)  # fmt: skip
def test_the_same_in_python(wrong, said):
    with pytest.raises(InputError) as caught:
        wrong()
    assert said in str(caught.value)


def test_muscles_that_cross_no_section_together_may_have_one_place():
    Arm(sections=(Section(), Section()))
    Arm(sections=(Section(), Section()), routings=(Routing(), Routing(start="base", radius=0.015)))
    Arm(sections=(Section(), Section()), routings=(Routing(start="base"), Routing()))


def test_flags_of_the_world_change_an_arm_of_several_sections():
    arm = Arm(sections=(Section(), Section()))
    assert arm_from_dict({"payload": 0.1}, base=arm) == replace(arm, payload=0.1)
    with pytest.raises(InputError, match=r"mass is 1.0; allowed: an arm of one section; this one has 2"):
        arm_from_dict({"mass": 1.0}, base=arm)
    with pytest.raises(InputError, match=r"muscle.wall is 0.001; allowed: an arm of one section"):
        arm_from_dict({"muscle": {"wall": 0.001}}, base=arm)


def test_given_angles():
    routing = Routing(at=(0.2, 1.0, 3.0, -2.0), offset=0.1)
    assert routing.count == 4
    assert routing.angles == pytest.approx((0.3, 1.1, 3.1, -1.9))
    assert replace(routing, at=None).count == 4
