"""The errors a caller can act on. Each carries the numbers it speaks of."""

from __future__ import annotations

import copyreg
import difflib
import math
import reprlib
from collections.abc import Iterable
from typing import Any

LONGEST = 110
"""Most characters of a value, a name or a place in a message."""

MESSAGE = 385
"""Most characters of a message about a value; what was allowed is cut short where it would be longer."""


def one_line(text: str, most: int = LONGEST) -> str:
    """Return text without line breaks and control characters; what is too long loses its middle."""
    if len(text) > most:
        head = most * 2 // 3
        text = f"{text[:head]} ... {text[head + 5 - most :]}"
    return "".join(c if c.isprintable() else " " if c.isspace() else ascii(c)[1:-1] for c in text)[: 4 * most]


class _Short(reprlib.Repr):
    """Writes values as Python does, the long ones in short."""

    def __init__(self) -> None:
        super().__init__()
        self.maxother = self.maxstring = LONGEST
        self.maxlist = self.maxtuple = self.maxdict = 8

    def repr_int(self, x: int, level: int) -> str:
        """Write a whole number; Python refuses to write those of thousands of digits."""
        return repr(x) if x.bit_length() < 256 else f"a whole number of {x.bit_length()} bits"

    def repr_ndarray(self, x: Any, level: int) -> str:
        """Write a NumPy array by what it is; a single number as such."""
        return str(x) if x.ndim == 0 else f"an array of {x.dtype} of shape {x.shape}"


def in_short(value: Any) -> str:
    """Return a value for a message: one line, at most about `LONGEST` characters."""
    return one_line(value if isinstance(value, str) else _Short().repr(value))


def did_you_mean(given: Any, known: Iterable[str]) -> str:
    """Return a question for the nearest known name, with a space behind it; nothing where none is near."""
    near = difflib.get_close_matches(str(given)[:100], list(known), n=1)
    return f"did you mean {near[0]!r}? " if near else ""


class _Sent(BaseException):
    """An error that other processes may send: pickled by its message and attributes, not by what made it."""

    def __reduce__(self) -> tuple[Any, ...]:
        return copyreg.__newobj__, (type(self), *self.args), vars(self)  # type: ignore[attr-defined]


class ContarmError(_Sent, Exception):
    """Root of every error that contarm_sim raises on purpose."""


class InputError(ContarmError, ValueError):
    """A value that cannot be used: says what was given, what is allowed, and where.

    Attributes:
        name: the name of the parameter, as in Python, TOML and (with dashes) on the command line.
        given: the value that was given.
        allowed: what would have been accepted, in words.
        where: the file or place that the value came from, or None.
    """

    def __init__(self, name: str, given: Any, allowed: str, where: str | None = None) -> None:
        self.name, self.given, self.allowed, self.where = name, given, allowed, where
        place = f"{one_line(where)}: " if where else ""
        said = f"{place}{one_line(name, 60)} is {in_short(given)}; allowed: "
        super().__init__(said + one_line(allowed, max(80, MESSAGE - len(said))))

    def located(self, where: str | None) -> InputError:
        """Return the same error, said to come from a file or place."""
        return InputError(self.name, self.given, self.allowed, where)


def expect(name: str, value: Any, kind: type) -> None:
    """Refuse a value of another type.

    Raises:
        InputError: names what was given and what is expected.
    """
    if not isinstance(value, kind):
        given = f"the class {value.__name__}" if isinstance(value, type) else _one(type(value))
        raise InputError(name, given, _one(kind))


def _one(kind: type) -> str:
    return f"{'an' if kind.__name__[0] in 'AEIOUaeiou' else 'a'} {kind.__name__}"


class UnreachableError(InputError):
    """A target out of reach: of one section, off the dome of reachable tips.

    Attributes:
        target: the first target refused [m], shape (3,).
        miss: distance from it to the nearest point that can be reached [m].
        nearest: that point [m], shape (3,).
        index: its place among the targets, 0 for a single one.
        question: what may explain it, such as a unit; or nothing.
        angle: what is left of a direction or orientation asked for [rad].
        limits: largest bend angles of several sections that were let [rad].
    """

    def __init__(
        self,
        target: Any,
        miss: float,
        nearest: Any,
        tolerance: float,
        index: int,
        where: str | None = None,
        question: str = "",
        angle: float = 0.0,
        dome: bool = True,
        limits: tuple[float, ...] = (),
    ) -> None:
        self.target, self.miss, self.nearest, self.index = target, miss, nearest, index
        self.tolerance, self.question, self.angle, self._dome, self.limits = tolerance, question, angle, dome, limits
        asked = f" ({question})" if question else ""
        bends = f" with bends up to {', '.join(f'{math.degrees(x):.4g}' for x in limits)} deg" if limits else ""
        place = "off the dome of reachable tips" if dome else f"out of reach{bends}"
        small = 1e-9 * max(abs(float(x)) for x in (*target, *nearest))
        found = ", ".join(f"{0.0 if abs(x) < small else x:.6g}" for x in nearest)
        said = f"{miss * 1e3:.4g} mm {place}"
        if angle:
            turned = f"{math.degrees(angle):.4g} deg off where its tip is to point"
            said = turned if miss <= tolerance else f"{miss * 1e3:.4g} mm {place}, and {turned}"
        super().__init__(
            "target",
            f"({', '.join(f'{x:.6g}' for x in target)}) m{asked}, which is {said}",
            f"a miss of at most {tolerance * 1e3:.3g} mm (the nearest reachable point is ({found}) m), or a "
            f"projection: nearest{', ray, paper' if dome else ''}",
            where,
        )

    def located(self, where: str | None) -> UnreachableError:
        """Return the same error, said to come from a file or place."""
        return self._again(where, self.question)

    def asking(self, question: str) -> UnreachableError:
        """Return the same error with a question that explains it, such as one about the unit."""
        return self._again(self.where, question)

    def _again(self, where: str | None, question: str) -> UnreachableError:
        return UnreachableError(
            self.target, self.miss, self.nearest, self.tolerance, self.index, where, question, self.angle, self._dome,
            self.limits,
        )  # fmt: skip


class BlockedError(ContarmError):
    """No pose that was looked at reaches a target and keeps clear of the objects of the world.

    Attributes:
        clearance: the largest that was found [m], below zero where the arm overlaps an object.
        margin: what was asked for [m].
        object: the name of the object that is nearest then.
    """

    def __init__(self, reason: str, clearance: float, margin: float, object: str) -> None:
        self.clearance, self.margin, self.object = clearance, margin, object
        super().__init__(reason)


class PressureError(InputError):
    """A pose that needs more pressure than its muscles have.

    Attributes:
        needed: the highest of the least pressures that would hold it [Pa].
    """

    def __init__(self, name: str, given: Any, allowed: str, needed: float) -> None:
        super().__init__(name, given, allowed)
        self.needed = needed


class DivergenceError(ContarmError):
    """The simulation blew up; no number of that run is returned.

    Attributes:
        time: simulated time at which the engine gave the warning [s].
        dof: the degree of freedom it named, or -1.
        joint: the name of that degree of freedom's joint.
        settings: the time step, integrator and gains of the run.
    """

    def __init__(self, time: float, dof: int, joint: str, settings: dict[str, Any]) -> None:
        self.time, self.dof, self.joint, self.settings = time, dof, joint, settings
        said = ", ".join(f"{key} {value}" for key, value in settings.items())
        super().__init__(
            f"the simulation diverged at t = {time:.4f} s in dof {dof} ({joint}) with {said}; "
            "more damping, a slower path, fewer links or a shorter time step may help"
        )


class EquilibriumError(ContarmError):
    """No pose at rest that an arm would stay in; one of the three kinds below says which sort.

    Attributes:
        reason: why, and what would help.
        where: the pose or scenario that it is said of, or nothing.
        pose: joint angles of the last pose tried [rad], shape (dofs,), or None.
        load_fraction: the share of the load at which the last pose was sought, 1 for the whole.
        residual: largest generalised force left there [N m]; NaN where the arm is at rest, but cannot be held.
        value, limit: the number that decided, and the most that it may be; NaN if there is none.
    """

    def __init__(
        self,
        reason: str,
        value: float = math.nan,
        limit: float = math.nan,
        *,
        where: str = "",
        pose: Any = None,
        load_fraction: float = 1.0,
        residual: float = math.nan,
    ) -> None:
        self.reason, self.value, self.limit, self.where = reason, value, limit, where
        self.pose, self.load_fraction, self.residual = pose, load_fraction, residual
        super().__init__(f"{where}no pose at rest: {reason}")

    def located(self, where: str) -> EquilibriumError:
        """Return the same error, said of a pose or scenario."""
        return type(self)(
            self.reason, self.value, self.limit, where=f"{where}: {self.where}", pose=self.pose,
            load_fraction=self.load_fraction, residual=self.residual,
        )  # fmt: skip


class NotConvergedError(EquilibriumError):
    """The search ended without an answer: there may be a pose at rest, or none."""


class UnstableError(EquilibriumError):
    """There is a pose at rest, and the arm would not stay in it."""


class NoEquilibriumError(EquilibriumError):
    """Muscles as they are cannot hold the pose: it takes more force, pressure or stroke than they have."""


class Interrupted(_Sent, KeyboardInterrupt):
    """Ctrl-C ended a simulation early.

    Attributes:
        trajectory: what was recorded until then.
    """

    def __init__(self, trajectory: Any) -> None:
        self.trajectory = trajectory
        super().__init__(f"the simulation was interrupted after {len(trajectory)} samples")


class InterruptedMany(_Sent, KeyboardInterrupt):
    """Ctrl-C ended many simulations early.

    Attributes:
        results: what came of each until then, a trajectory or an error; None where it was not done.
    """

    def __init__(self, results: Any) -> None:
        self.results = results
        done = sum(result is not None for result in results)
        super().__init__(f"the simulations were interrupted after {done} of {len(results)} motions")


class RenderingError(ContarmError):
    """No picture can be made here; says what was tried and why each attempt failed."""


class EncodingError(RenderingError):
    """Pictures can be drawn, but no video encoder works here."""


class MissingError(ContarmError, ImportError):
    """A library that an optional part needs is not installed; says how to get it, in a copy of the repository.

    Attributes:
        library: its name.
        extra: the extra of this package that brings it.
    """

    def __init__(self, library: str, extra: str) -> None:
        self.library, self.extra = library, extra
        super().__init__(f"{library} is not installed; get it with: pip install '.[{extra}]'")


class GuardError(ContarmError):
    """The live page cannot be kept to this machine with the viser that is installed, so it is not served.

    Attributes:
        reason: what is not as it should be.
        version: the version of viser.
    """

    def __init__(self, reason: str, version: str) -> None:
        self.reason, self.version = reason, version
        super().__init__(
            f"viser {version} cannot be guarded ({reason}), so no page is served; an earlier one can: "
            "pip install 'viser==1.1.1'"
        )
