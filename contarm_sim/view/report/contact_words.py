"""What is said of contact, from `contact` of a run's summary: on the page, on the terminal, in its first sentence."""

from __future__ import annotations

from typing import Any

NEVER = "never"

COLUMNS = (
    "first touch [s]", "longest touch [s]", "links", "force [N]", "depth [mm]", "friction used [%]", "moved [mm]",
)  # fmt: skip
"""Of the table of objects; the last is left out where no object is free."""

STILL = 1e-5
"""Farthest that an object goes which is said not to move [m]."""

_MEANT = "Links that touch it at one time or another; largest net force on the arm, and depth"


def touched_names(summary: dict[str, Any]) -> list[str]:
    """Return the names of what an arm touched; of none where it could touch nothing."""
    return [one["name"] for one in summary.get("contact", {}).get("objects", []) if one["samples"]]


def named(objects: list[str]) -> list[str]:
    """Return names of objects as they are listed in a sentence: `the post`, `table`, ..."""
    return [f"the {name}" if place == 0 and name != "itself" else name for place, name in enumerate(objects)]


def listed(words: list[str], last: str = "and") -> str:
    """Return words as one says them: `a`, `a and b`, `a, b and c`."""
    return f" {last} ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def what_it_touches(summary: dict[str, Any]) -> str:
    """Return `the arm touches ...` of a run that touches something; else ""."""
    found = touched_names(summary)
    others = named([name for name in found if name != "itself"])
    if len(others) > 4:
        others = [*others[:3], f"{len(others) - 3} other objects"]
    return f"the arm touches {listed([*others, *(['itself'] if 'itself' in found else [])])}" if found else ""


def in_numbers(summary: dict[str, Any]) -> str:
    """Return in a line what was touched, for how long, how hard and how deep."""
    found = summary["contact"]
    if not found["contacts"]:
        names = [one["name"] for one in found["objects"]]
        others = named([name for name in names if name != "itself"])
        said = (
            [f"none of {listed(others)} is touched" if len(others) > 1 else f"{others[0]} is not touched"]
            if others
            else []
        )
        return listed([*said, *["the arm does not touch itself"] * ("itself" in names)])
    share = 100 * found["samples"] / summary["samples"]
    what = what_it_touches(summary).removeprefix("the arm ")
    return (
        f"{what} in {share:.3g} % of samples; contact force up to {found['largest_force_n']:.3g} N, depth up to "
        f"{1e3 * found['largest_depth_m']:.2g} mm"
    )


def paragraph(summary: dict[str, Any]) -> str:
    """Return what the section of a page says in whole sentences."""
    found = summary["contact"]
    if not found["contacts"]:
        return f"The arm touches nothing: {in_numbers(summary)}."
    what, links = what_it_touches(summary), found["most_links"]
    share = 100 * found["samples"] / summary["samples"]
    untouched = named([one["name"] for one in found["objects"] if not one["samples"]])
    said = [
        f"{what[0].upper()}{what[1:]}, in {share:.3g} % of all samples and with at most {links} "
        f"link{'s' * (links != 1)} at once.",
        f"All contact forces of a moment come to at most {found['largest_force_n']:.3g} N, at "
        f"{found['largest_force_at_s']:.2f} s.",
        f"Links and objects overlap by at most {1e3 * found['largest_depth_m']:.2g} mm, for contact is a little soft.",
        "Constant curvature knows of no contact: its arcs run through objects, and what contact does to the arm is part"
        " of the tip error.",
    ]
    if untouched:
        said.insert(1, f"It never touches {listed(untouched, 'or')}.")
    return " ".join(said)


def columns(summary: dict[str, Any]) -> tuple[str, ...]:
    """Return the columns of the table of objects."""
    return COLUMNS if any("moved_m" in one for one in summary["contact"]["objects"]) else COLUMNS[:-1]


def rows(summary: dict[str, Any]) -> list[tuple[str, list[str]]]:
    """Return the table of objects: name and values of each; what never was is a dash."""
    count = len(columns(summary))
    return [(one["name"], _row(one)[:count]) for one in summary["contact"]["objects"]]


def legend(summary: dict[str, Any]) -> str:
    """Return what the columns of the table mean."""
    said = f"{_MEANT}; friction over what it can give at that load, at 100 % it slides"
    return f"{said}; how far a free object moved." if len(columns(summary)) == len(COLUMNS) else f"{said}."


def _row(one: dict[str, Any]) -> list[str]:
    moved = "fixed" if "moved_m" not in one else f"{1e3 * one['moved_m']:.3g}" if one["moved_m"] > STILL else "no"
    if not one["samples"]:
        return [NEVER, *["–"] * 5, moved]
    used = "–" if one["friction_used"] is None else f"{100 * one['friction_used']:.0f}"
    return [f"{one['first_touch_s']:.2f}", f"{one['longest_touch_s']:.2f}", f"{one['links']}",
            f"{one['largest_force_n']:.3g}", f"{1e3 * one['largest_depth_m']:.2g}", used, moved]  # fmt: skip
