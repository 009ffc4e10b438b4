"""Many motions at once: each to the bits of `simulate` by itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from contarm_sim.control.base import Controller
from contarm_sim.control.registry import ControllerName
from contarm_sim.control.registry import controller as resolved
from contarm_sim.engine.backends import alike, at_once, check_backend
from contarm_sim.engine.room import engine_room
from contarm_sim.engine.threads import at_most
from contarm_sim.errors import ContarmError, InputError, InterruptedMany, expect
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import check_count
from contarm_sim.motion.legs import Flight, Flown, Leg, fly_together
from contarm_sim.motion.simulate import checked, flight
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory


def simulate_many(
    arms: Arm | Sequence[Arm],
    references: Reference | Sequence[Reference],
    controllers: ControllerName | Controller | Sequence[ControllerName | Controller] = "servo",
    *,
    stepping: Stepping | Sequence[Stepping | None] | None = None,
    check_step: bool | None = None,
    threads: int = 0,
    on_done: Callable[[int], object] | None = None,
    backend: str = "cpu",
) -> list[Trajectory | ContarmError]:
    """Follow many references at once, stepped on threads: arms of one layout together, others in groups.

    Arms, references, controllers and steppings are one, or one for each of B motions. Every trajectory has the very
    bits of `simulate` for that motion alone, the time step found included (on the backend `cpu`); `real_time_factor`
    alone is of its share of the time.

    Args:
        arms, references, controllers, stepping, check_step: as of `simulate`.
        threads: most that are used; 0: one a processor. Results do not depend on it.
        on_done: called with the index of each motion that is done, for progress.
        backend: what simulates: `cpu`, or `warp`: MuJoCo Warp, on a GPU where there is one, in single precision, so
            that tips differ from those of `simulate` by about a millionth of length. It knows no objects.

    Returns:
        what came of each motion, in order: its trajectory, or the error that `simulate` would raise (no rest to start
        from, a step that diverged, a bend that muscles cannot hold).

    Raises:
        InputError: arguments of unlike counts, or of wrong types; an unknown backend, or an integrator that it has not.
        MissingError: the backend is not installed.
        InterruptedMany: Ctrl-C; carries what is done. It is a KeyboardInterrupt.
    """
    check_backend(backend)
    check_count("threads", threads, 0, "threads")
    cases = _cases(arms, references, controllers, stepping)
    results: list[Trajectory | ContarmError | None] = [None] * len(cases)

    def done(index: int, result: Any) -> None:
        results[index] = result.with_traceback(None) if isinstance(result, ContarmError) else result
        if on_done is not None:
            on_done(index)

    try:
        with engine_room(), at_most(threads):
            most = at_once(backend)
            for first in range(0, len(cases), most):
                some = dict(list(enumerate(cases))[first : first + most])
                _Fleet(some, check_step, done).fly(threads, backend)
    except KeyboardInterrupt:
        raise InterruptedMany(results) from None
    return results  # type: ignore[return-value]


_SHARED, _NEW = "shared", "a new one at each call of Controller.feedback"


class _Fleet:
    """Motions under way together."""

    def __init__(self, cases: dict[int, Any], check_step: bool | None, done: Callable[[int, Any], None]) -> None:
        self._cases, self._check_step, self._done = cases, check_step, done
        self._flights: dict[int, Flight] = {}
        self._legs: dict[int, Leg] = {}

    def fly(self, threads: int, backend: str) -> None:
        """Fly legs, those of one kind together, until all motions are done."""
        for index, (arm, reference, controller, stepping) in self._cases.items():
            try:
                if backend != "cpu":
                    arm.refuse_objects(f"{backend} steps arms")
                chosen = checked(arm, reference, controller, stepping)
                self._flights[index] = flight(arm, reference, chosen, stepping, self._check_step)
            except ContarmError as error:
                self._done(index, error)
            else:
                self._go_on(index, None)
        while self._legs:
            kinds: dict[Any, list[int]] = {}
            several = Counter(id(leg.one.feedback) for leg in self._legs.values() if leg.one.feedback is not None)
            for index, leg in self._legs.items():
                shared = several[id(leg.one.feedback)] > 1
                kind = _SHARED if shared else (leg.kind, alike(leg.one.plant, backend))
                kinds.setdefault(kind, []).append(index)
            waiting, self._legs = self._legs, {}
            for index in kinds.pop(_SHARED, []):
                self._go_on(index, InputError("feedback", "one object for several arms", _NEW))
            for places in kinds.values():
                flown = fly_together([waiting[index] for index in places], threads, backend)
                for index, result in zip(places, flown, strict=True):
                    self._go_on(index, result)

    def _go_on(self, index: int, result: Flown | ContarmError | None) -> None:
        """Hand a motion what came of its leg, and take its next."""
        going = self._flights[index]
        try:
            if result is None:
                leg = next(going)
            else:
                leg = going.throw(result) if isinstance(result, ContarmError) else going.send(result)
        except StopIteration as end:
            self._end(index, end.value)
        except ContarmError as error:
            self._end(index, error)
        else:
            self._legs[index] = leg

    def _end(self, index: int, result: Any) -> None:
        del self._flights[index]
        self._done(index, result)


def _cases(*given: Any) -> list[tuple[Any, ...]]:
    """Return the arguments of each motion.

    Raises:
        InputError: neither one, nor as many as there are of others, or of wrong types.
    """
    names = ("arms", "references", "controllers", "stepping")
    several = [None if isinstance(one, str) or not isinstance(one, Sequence) else one for one in given]
    counts = {name: len(one) for name, one in zip(names, several, strict=True) if one is not None}
    total = next((count for count in counts.values() if count != 1), 1)
    for name, count in counts.items():
        if count not in (1, total):
            raise InputError(name, f"{count} of them", f"one, or {total}")
    rows = [[one] * total if many is None else list(many) * (total if len(many) == 1 else 1)
            for one, many in zip(given, several, strict=True)]  # fmt: skip
    cases = []
    for arm, reference, controller, stepping in zip(*rows, strict=True):
        expect("arm", arm, Arm)
        expect("reference", reference, Reference)
        if stepping is not None:
            expect("stepping", stepping, Stepping)
        cases.append((arm, reference, resolved(controller), stepping))
    return cases
