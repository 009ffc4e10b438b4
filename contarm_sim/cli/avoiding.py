"""What `contarm ik --avoid` does: poses that keep clear of the objects of the world, what is said and drawn of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from contarm_sim.errors import BlockedError, InputError, UnreachableError
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.paths.targets import Targets
    from contarm_sim.planning import Avoiding

PICTURES = ("png", "pdf", "svg")


def check_flags(avoid: bool, margin: float | None, figure: str | None, choose: str | None, project: str) -> None:
    """Refuse flags that do not go together.

    Raises:
        InputError: says which.
    """
    for name, given in (("--margin", margin), ("--figure", figure)):
        if given is not None and not avoid:
            raise InputError(name, "given without --avoid", "--avoid beside it: it is of poses that keep clear")
    if avoid and choose == "all":
        raise InputError("--choose", "all with --avoid", "one pose; --figure draws the family, blocked and clear")
    if avoid and project != "refuse":
        raise InputError("--project", f"{project} with --avoid", "targets within reach: leave --project out")
    if figure is not None and Path(figure).suffix[1:].lower() not in PICTURES:
        raise InputError("--figure", repr(figure), f"a file that ends in {', '.join('.' + kind for kind in PICTURES)}")


def avoided(arm: Arm, targets: Targets, margin: float | None, choose: Any, near: Any, limits: Any) -> list[Avoiding]:
    """Return the clear pose of each target.

    Raises:
        UnreachableError, BlockedError, InputError: as `planning.avoid`; of several targets says which.
    """
    from contarm_sim import planning

    out = []
    for k, position in enumerate(targets.position):
        direction, rotation = (None if each is None else each[k] for each in (targets.direction, targets.rotation))
        where = targets.place(k)
        try:
            out.append(planning.avoid(arm, position, margin, direction, rotation, choose, near, limits))
        except UnreachableError as error:
            error.index = k
            raise
        except BlockedError as error:
            said = f"{where}: {error}" if where else str(error)
            raise BlockedError(said, error.clearance, error.margin, error.object) from None
        except InputError as error:
            raise error.located(where or error.where) from None
    return out


def said_of(found: Avoiding) -> dict[str, Any]:
    """Return what is said of how clear a pose is, as part of a document."""
    nearest = found.nearest
    return {
        "clearance": nearest.clearance, "margin": found.margin, "nearest_object": nearest.object,
        "nearest_xi": nearest.xi, "nearest_point": list(nearest.point), "poses_looked_at": found.looked,
    }  # fmt: skip


def clearance_words(arm: Arm, solution: dict[str, Any]) -> str:
    """Return the same for people."""
    at, margin = 1e3 * solution["nearest_xi"] * arm.length, 1e3 * solution["margin"]
    place = f"{solution['nearest_object']}, at {at:.1f} mm along the arm"
    return f"{1e3 * solution['clearance']:.2f} mm from {place}; margin {margin:.4g} mm"


def draw(file: Path, arm: Arm, targets: Targets, found: Avoiding) -> None:
    """Draw the poses that reach the only target, and the one that was chosen."""
    from contarm_sim.files import appearing
    from contarm_sim.view.figures.avoiding import avoiding
    from contarm_sim.view.style import drawn, write

    turn = [None if each is None else each[0] for each in (targets.direction, targets.rotation)]
    sheet = drawn(lambda sheet: avoiding(sheet, arm, targets.position[0], found, *turn))
    with appearing(file) as scratch:
        write(sheet, scratch)
