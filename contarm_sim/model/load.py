"""Loads on an arm at rest, beside its own gravity and payload: wrenches, couples, and how the muscles are driven."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.model.parameters import LARGEST, Vector, as_number, as_numbers

Drive = Literal["off", "deltas", "setpoints", "tensions", "pressures", "bend"]
DRIVES: tuple[Drive, ...] = get_args(Drive)
_SIZE = {"off": 0}


def _vector(value: Any, size: int | None, name: str) -> tuple[float, ...]:
    """Return finite numbers: so many, or as many as there are muscles, which only an arm knows."""
    vector = as_numbers(value)
    if size is None:
        size = max(1, len(vector or ()))
    if vector is None or len(vector) != size or not all(abs(x) <= LARGEST for x in vector):
        allowed = f"{size} finite numbers" if size > 1 else "finite numbers, one for each muscle"
        allowed += f", at most {LARGEST:g}"
        raise InputError(name, repr(value) if isinstance(value, str) else value, allowed)
    return vector


@dataclass(frozen=True, kw_only=True, repr=False)
class Wrench(Told):
    """A dead force [N] and couple [N m], fixed in the base frame, on the backbone at normalised arc length xi.

    Raises:
        InputError: xi outside [0, 1], or not three finite numbers.
    """

    xi: float
    force: Vector = (0.0, 0.0, 0.0)
    moment: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not 0 <= as_number(self.xi) <= 1:
            raise InputError("wrench.xi", self.xi, "a number from 0 (base) to 1 (tip)")
        object.__setattr__(self, "xi", as_number(self.xi))
        for name in ("force", "moment"):
            object.__setattr__(self, name, _vector(getattr(self, name), 3, f"wrench.{name}"))


@dataclass(frozen=True, kw_only=True, repr=False)
class Muscles(Told):
    """How the muscles are driven.

    Attributes:
        kind: `off` (no force), `deltas` (length changes of the chain of links [m], held by servos), `setpoints` (what
            servos are told [m]; they give way under tension), `tensions` (constant [N], pulling > 0), `pressures`
            (gauge [Pa], by the law of pneumatic muscles), `bend` (bend and plane angle [rad], held by servos).
        values: none for `off`, two numbers for `bend` (for each section), else one for each muscle, section by section.

    Raises:
        InputError: an unknown kind, or the wrong numbers.
    """

    kind: Drive = "off"
    values: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.kind, str) or self.kind not in DRIVES:
            raise InputError("muscles", repr(self.kind) if isinstance(self.kind, str) else self.kind, ", ".join(DRIVES))
        object.__setattr__(self, "values", _vector(self.values, _SIZE.get(self.kind), f"muscles {self.kind}"))
        if self.kind == "bend" and len(self.values) not in range(2, 13, 2):
            raise InputError("muscles bend", self.values, "2 finite numbers, or two for each section, at most 12")
        if self.kind in ("tensions", "pressures") and min(self.values) < 0:
            unit = "[N]: muscles pull" if self.kind == "tensions" else "[Pa]"
            raise InputError(f"muscles {self.kind}", self.values, f"0 or more {unit}")

    @property
    def servos(self) -> bool:
        """Whether length servos drive them."""
        return self.kind in ("deltas", "setpoints", "bend")


@dataclass(frozen=True, kw_only=True, repr=False)
class Load(Told):
    """What acts on an arm besides its own weight and payload; vectors in the base frame, SI units.

    Attributes:
        wrenches: dead forces and couples along the backbone.
        follower_moment: couple at the tip that turns with it [N m].
        actuation_moment: bending moment about the material x and y axes, uniform along the arm, as ideal muscles at
            constant radius make it [N m].
        muscles: how the muscles are driven.
    """

    wrenches: tuple[Wrench, ...] = ()
    follower_moment: Vector = (0.0, 0.0, 0.0)
    actuation_moment: tuple[float, float] = (0.0, 0.0)
    muscles: Muscles = field(default_factory=Muscles)

    def __post_init__(self) -> None:
        try:
            wrenches: tuple[Any, ...] = (None,) if isinstance(self.wrenches, (str, dict, set)) else tuple(self.wrenches)
        except TypeError:  # not a sequence
            wrenches = (None,)
        if not all(isinstance(wrench, Wrench) for wrench in wrenches):
            raise InputError("wrenches", self.wrenches, "a tuple of Wrench")
        object.__setattr__(self, "wrenches", wrenches)
        if not isinstance(self.muscles, Muscles):
            raise InputError("muscles", self.muscles, "a Muscles")
        object.__setattr__(self, "follower_moment", _vector(self.follower_moment, 3, "follower_moment"))
        object.__setattr__(self, "actuation_moment", _vector(self.actuation_moment, 2, "actuation_moment"))


_CASE_KEYS = ("gravity", "payload", "wrenches", "follower_moment", "actuation_moment", "muscles")


def load_from_dict(case: Any, where: str) -> tuple[Load, dict[str, Any]]:
    """Return (load, arm parameters to change: gravity, payload) of a case as JSON holds it.

    Raises:
        InputError: an unknown key (with the nearest known one) or a bad value; names `where`.
    """
    if not isinstance(case, dict):
        raise InputError("case", case, f"an object with keys {', '.join(_CASE_KEYS)}", where)
    _known(case, _CASE_KEYS, where)
    try:
        wrenches = case.get("wrenches", [])
        if not isinstance(wrenches, list):
            raise InputError("wrenches", wrenches, "a list of {xi, force, moment}")
        given = {key: case[key] for key in ("follower_moment", "actuation_moment") if key in case}
        load = Load(wrenches=tuple(_wrench(item, where) for item in wrenches), muscles=_muscles(case, where), **given)
    except InputError as error:
        raise error.located(where) from None
    return load, {key: case[key] for key in ("gravity", "payload") if key in case}


def _wrench(item: Any, where: str) -> Wrench:
    if not isinstance(item, dict) or "xi" not in item:
        raise InputError("wrench", item, "an object {xi, force, moment}")
    _known(item, ("xi", "force", "moment"), where)
    return Wrench(**item)


def _muscles(case: dict[str, Any], where: str) -> Muscles:
    item = case.get("muscles", {"kind": "off"})
    if not isinstance(item, dict) or "kind" not in item:
        raise InputError("muscles", item, "an object {kind, values}")
    _known(item, ("kind", "values"), where)
    return Muscles(kind=item["kind"], values=item.get("values", ()))


def _known(item: dict[str, Any], keys: tuple[str, ...], where: str) -> None:
    for key in item:
        if key not in keys:
            near = difflib.get_close_matches(str(key)[:100], keys, n=1, cutoff=0.0)[0]
            raise InputError(f"key {key!r}", "unknown", f"did you mean {near!r}? All: {', '.join(keys)}", where)
