"""The reference rod against solutions that others found, closed forms, its own equations, and perturbations."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rod import parallel_rod

from contarm_sim.arm import Arm

DATA = Path(__file__).parent / "data"
DRIVES = json.loads((DATA / "drives.json").read_text())["cases"]
ELASTICA = json.loads((DATA / "elastica.json").read_text())


@pytest.mark.parametrize("case", DRIVES)
def test_driven_rods_are_those_another_solver_found(case):
    arm = Arm(gravity=tuple(case["gravity"]), payload=case["payload"])
    found = parallel_rod(arm, force=case["force"], moment=case["moment"], **{case["kind"]: case["values"]})
    np.testing.assert_allclose(found.tip, case["tip"], atol=1e-10)
    np.testing.assert_allclose(found.R, case["R"], atol=1e-10)
    np.testing.assert_allclose(found.lengths, case["lengths"], atol=1e-11)
    np.testing.assert_allclose(found.tensions, case["tensions"], atol=1e-8)


@pytest.mark.parametrize("case", ELASTICA["cases"], ids=lambda case: case["name"])
def test_elastica_are_those_two_other_solvers_found(case):
    size = ELASTICA["parameters"]
    arm = Arm(
        length=size["length_m"], bending_stiffness=size["bending_stiffness_Nm2"], mass=size["mass_kg_uniform"],
        gravity=tuple(case["gravity"]), payload=case["payload"],
    )  # fmt: skip
    name = {"act": "actuation_moment", "follower": "follower_moment"}.get(case["kind"], "moment")
    couple = {name: case["moment_Nm"][:2] if case["kind"] == "act" else case["moment_Nm"]}
    if "buckled" in case["name"]:
        couple["guess"] = parallel_rod(replace(arm, gravity=(0, 0, 0)), actuation_moment=(0, 0.3)).curvature
    found = parallel_rod(arm, force=case["tip_force"], **couple)
    np.testing.assert_allclose(found.tip, case["tip"], atol=1e-10)
    np.testing.assert_allclose(found.R, case["R_tip"], atol=1e-10)
    points, _ = found.at(np.linspace(0, 1, 25))
    np.testing.assert_allclose(points, case["centreline"], atol=1e-8)
