"""Sweeps read from TOML files, dicts, or by the name of one that comes with the package; all is checked here."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

from contarm_sim.engine.backends import BACKENDS
from contarm_sim.errors import InputError, did_you_mean, in_short, one_line
from contarm_sim.inputs import as_path, read_text
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_table, load_arm
from contarm_sim.model.muscle_table import refuse_unknown
from contarm_sim.model.named import find, with_parameters
from contarm_sim.model.presets import PRESETS
from contarm_sim.sweeps.designs import DESIGNS, MOST_CASES, MOST_HYPERCUBE
from contarm_sim.sweeps.distributions import Normal, Range, Varied, varied_from
from contarm_sim.sweeps.distributions import Values as Listed
from contarm_sim.sweeps.keys import by_full_names, whole_number
from contarm_sim.sweeps.names import RUNS, Parameter, known_names
from contarm_sim.sweeps.never import why_never
from contarm_sim.sweeps.quantities import QUANTITIES
from contarm_sim.sweeps.spec import Spec

MADE = "made"
"""The table of a kept sweep that says what it was made with; no part of it."""

_KEYS = ("run", "arm", "design", "cases", "points", "seed", "ask", "backend", "fixed", "vary")

_DRAWN = 256


def built_in() -> dict[str, Any]:
    """Return the sweeps that come with the package, by name."""
    folder = files("contarm_sim.sweeps") / "specs"
    return {each.name.removesuffix(".toml"): each for each in folder.iterdir() if each.name.endswith(".toml")}


def read(given: str | PathLike[str] | Mapping[str, Any] | Spec, backend: str | None = None) -> Spec:
    """Return a sweep, checked.

    Args:
        given: a TOML file, the name of a sweep that comes with the package, or what such a file holds, as a dict.
        backend: in place of the one that it says.

    Raises:
        InputError: it cannot be read, or says something that is unknown, empty, or too much.
    """
    if isinstance(given, Spec):
        return given if backend is None else read(given.to_dict() | {"backend": backend})
    extra = {} if backend is None else {"backend": backend}
    if isinstance(given, Mapping):
        return _spec({**given, **extra}, "sweep", Path())
    name = str(given)
    if name in built_in():
        return _spec({**tomllib.loads(built_in()[name].read_text("utf-8")), **extra}, name, Path())
    path = as_path("sweep", given, "a TOML file")
    if not path.exists() and path.suffix != ".toml" and path.name == name:
        raise InputError("sweep", repr(name), f"a TOML file, or one of {', '.join(sorted(built_in()))}")
    text = read_text(path, "a TOML file that describes a sweep", 2**24)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        said = f"not TOML ({one_line(str(error), 80)})"
        raise InputError("file", said, 'lines such as: run = "rest"', str(path)) from error
    try:
        return _spec({**table, **extra}, path.stem, path.parent)
    except InputError as error:
        raise error.located(": ".join(filter(None, (str(path), error.where)))) from None


def _spec(table: dict[str, Any], name: str, beside: Path) -> Spec:
    refuse_unknown({key: value for key, value in table.items() if key != MADE}, _KEYS)
    run = _one_of("run", table.get("run", "rest"), RUNS)
    design = _one_of("design", table.get("design", "grid"), DESIGNS)
    backend = _one_of("backend", table.get("backend", "cpu"), BACKENDS)
    if backend != "cpu" and run != "motion":
        raise InputError("backend", backend, "cpu, where nothing moves")
    arm = _arm(table.get("arm", "paper"), beside)
    if run == "motion":
        arm.refuse_memory("simulated motions are")
    else:
        arm.refuse_objects(f"cases of run = {run!r} are found")
    if backend != "cpu":
        arm.refuse_objects(f"{backend} steps arms")
    known = known_names(arm, run)
    fixed = _fixed(by_full_names(table.get("fixed", {}), "fixed", known), known)
    vary = _varied(by_full_names(table.get("vary", {}), "vary", known), known)
    for one in vary:
        if one in fixed:
            raise InputError(f"parameter {one!r}", "both in [fixed] and in [vary]", "in one of them")
        if one.rpartition(".")[0] in vary:
            raise InputError(f"parameter {one!r}", "varied beside the vector that it is of", "one of them")
    never = {one: why_never(one, run, arm, fixed, vary) for one in QUANTITIES[run]}
    asked = _asked(table.get("ask"), run, never)
    made = table.get(MADE)
    name = str(made.get("name", name)) if isinstance(made, Mapping) else name
    seed = whole_number("seed", table.get("seed", 0), 0, 2**63 - 1)
    spec = Spec(name, run, arm, design, _drawn(table, design), seed, asked, fixed, vary, backend)
    if not 1 <= spec.cases <= MOST_CASES:
        raise InputError("number of cases", f"{spec.cases:,}", f"at most {MOST_CASES:,}: {_fewer(design)}")
    _check_values(spec)
    return spec


def _fewer(design: str) -> str:
    return 'fewer values, or design = "sobol"' if design == "grid" else "fewer points, or fewer parameters"


def _one_of(name: str, given: Any, choices: tuple[Any, ...]) -> Any:
    if given not in choices:
        raise InputError(name, repr(given), ", ".join(choices))
    return given


def _drawn(table: Mapping[str, Any], design: str) -> int:
    """Return how many cases, or points, are drawn."""
    wanted, other = ("points", "cases") if design == "sobol-indices" else ("cases", "points")
    if other in table:
        allowed = "points, a power of two: there are parameters + 2 cases to each" if wanted == "points" else "cases"
        raise InputError(other, table[other], f"with this design, {allowed}")
    if design == "grid":
        if "cases" in table:
            raise InputError("cases", table["cases"], "left out: a grid has as many as its values make")
        return 0
    found = whole_number(
        wanted, table.get(wanted, _DRAWN), 1, MOST_HYPERCUBE if design == "latin-hypercube" else MOST_CASES
    )
    if wanted == "points" and found & (found - 1):
        raise InputError(wanted, found, "a power of two, such as 256")
    return found


def _arm(given: Any, beside: Path) -> Arm:
    """Return the arm of a preset, a TOML file beside the sweep's, or a table."""
    if isinstance(given, Arm):
        return given
    if isinstance(given, Mapping):
        return arm_from_table(dict(given), "[arm]")
    if isinstance(given, str) and given in PRESETS:
        return PRESETS[given]()
    allowed = f"{', '.join(PRESETS)}, or a TOML file beside this one"
    if not isinstance(given, str) or not given.endswith(".toml"):
        raise InputError("arm", repr(given), allowed)
    return load_arm(beside / as_path("arm", given, allowed))


def _fixed(table: Mapping[str, Any], known: Mapping[str, Parameter]) -> dict[str, Any]:
    made = {}
    for name, value in table.items():
        one = find(name, known, "[fixed]")
        if not one.of_arm:
            _refuse_idle(one)
        listed = varied_from([value], name, one.unit)
        assert isinstance(listed, Listed)
        made[name] = one.checked(listed.values[0])
    return made


def _varied(table: Mapping[str, Any], known: Mapping[str, Parameter]) -> dict[str, Varied]:
    if not table:
        raise InputError("[vary]", "empty or missing", "a parameter or more, such as payload = [0, 0.1]")
    made: dict[str, Varied] = {}
    for name, said in table.items():
        one = find(name, known, "[vary]")
        _refuse_idle(one)
        if not isinstance(said, (list, tuple, Mapping)):
            raise InputError(name, said, "a list of values, a range or a distribution; one value is in [fixed]")
        varied = varied_from(dict(said) if isinstance(said, Mapping) else said, name, one.unit)
        if isinstance(varied, Listed):
            varied = Listed(tuple(map(one.checked, varied.values)))
        elif one.kind in ("text", "vector"):
            parts = f"its components, {name}.x say" if one.kind == "vector" else "a list of values"
            raise InputError(name, "a range or a distribution", parts)
        made[name] = varied
    return made


def _refuse_idle(one: Parameter) -> None:
    if one.idle:
        raise InputError(f"parameter {one.name!r}", one.idle, "another; contarm sweep SPEC --names lists all")


def _asked(given: Any, run: Any, never: Mapping[str, str]) -> tuple[str, ...]:
    """Return the names of quantities; all that a run tells without more work, unless some are asked for."""
    known = QUANTITIES[run]
    if given is None:
        return tuple(name for name, quantity in known.items() if not quantity.costly and not never[name])
    if not isinstance(given, (list, tuple)) or not given:
        raise InputError("ask", given, "a list of quantities")
    for name in given:
        if name not in known:
            asked = f"{did_you_mean(name, known)}contarm sweep SPEC --names lists all"
            raise InputError(f"quantity {in_short(name)!r}", f"unknown to run = {run!r}", asked, "ask")
        if never[name]:
            raise InputError(f"quantity {name!r}", "one that no case has", never[name], "ask")
    return tuple(dict.fromkeys(given))


def _check_values(spec: Spec) -> None:
    """Refuse values that no arm can have, or nothing can be asked for, whatever the others are."""
    from contarm_sim.sweeps.case import options_of, refuse_both

    base = {name: value for name, value in spec.fixed.items() if spec.known[name].of_arm}
    with_parameters(spec.arm, base)
    options_of(spec, {name: value for name, value in spec.fixed.items() if name not in base})
    refuse_both({**spec.fixed, **spec.vary})
    drawn = spec.extremes() if any(isinstance(varied, Normal) for varied in spec.vary.values()) else {}
    for name, varied in spec.vary.items():
        ends = varied.values if isinstance(varied, Listed) else drawn.get(name, ())
        ends = (varied.low, varied.high) if isinstance(varied, Range) else ends
        for value in map(spec.known[name].drawn, ends):
            try:
                if spec.known[name].of_arm:
                    with_parameters(spec.arm, {**base, name: value})
                else:
                    options_of(spec, {name: value})
            except InputError as error:
                if error.name.rpartition(".")[2] == name.rpartition(".")[2]:  # and not of something else beside it
                    if isinstance(varied, Normal):
                        said, advice = f"{value:.4g}, drawn in a case", "least and most cut a distribution off"
                        raise InputError(name, said, f"{error.allowed}; {advice}", "[vary]") from None
                    raise error.located("[vary]") from None
