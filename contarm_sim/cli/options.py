"""Options shared by the subcommands: the arm's parameters as flags, and how help presents them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import Field, replace
from typing import Any

import click

from contarm_sim.control.registry import NAMES
from contarm_sim.errors import InputError, in_short
from contarm_sim.model.arm import Arm
from contarm_sim.model.flat import MUSCLE_PARAMETERS, PARAMETERS
from contarm_sim.model.presets import PRESETS
from contarm_sim.model.units import quantity

_MUSCLE = "muscle__"
_SIZES = {"gravity": (3, "GX GY GZ"), "base_orientation": (4, "W X Y Z")}


class Quantity(click.ParamType):
    """A number in an SI unit, or one with its unit: 0.25, 250mm."""

    name = "quantity"

    def __init__(self, unit: str) -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number in the SI unit."""
        if isinstance(value, (int, float)):
            return float(value)
        try:
            return quantity(value, self.unit, "value")
        except InputError as error:
            return self.fail(f"{in_short(error.given)}; allowed: {error.allowed}", param, ctx)


class Percent(click.ParamType):
    """A number of percent, with or without the sign: 2, 2%."""

    name = "percent"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number of percent."""
        try:
            return float(str(value).removesuffix("%"))
        except ValueError:
            return self.fail(f"{in_short(repr(value))}; allowed: a number of percent", param, ctx)


LENGTH, ANGLE, TIME, PLAIN = Quantity("m"), Quantity("rad"), Quantity("s"), Quantity("-")
PRESSURE = Quantity("Pa")


class Command(click.Command):
    """A command whose help lists its own options first, then the arm's, then the muscles'."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; a flag that takes one value may come once, for the others would be lost unread."""
        order = self.make_parser(ctx).parse_args(list(args))[2] if not ctx.resilient_parsing else []
        for param in order:
            if isinstance(param, click.Option) and not param.multiple and not param.is_flag and order.count(param) > 1:
                raise click.UsageError(f"{param.opts[-1]} is given {order.count(param)} times; allowed: once", ctx)
        return super().parse_args(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options in sections."""
        sections: dict[str, list[tuple[str, str]]] = {"Options": [], "Arm (SI units)": [], "Muscles": []}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if record is not None:
                sections[getattr(param, "section", "Options")].append(record)
        for title, records in sections.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


class ArmOption(click.Option):
    """An option that belongs to a section of the help."""

    section = "Arm (SI units)"


class MuscleOption(ArmOption):
    """An option of the muscles."""

    section = "Muscles"


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def _type(item: Field[Any]) -> Any:
    """Return what a parameter's flag takes."""
    if "choices" in item.metadata:
        return click.Choice(item.metadata["choices"])
    return int if item.name == "links" else Quantity(item.metadata["unit"])


def _parameter_options() -> list[Callable[[Any], Any]]:
    made = [
        click.option(
            "--arm",
            "arm_file",
            cls=ArmOption,
            metavar="FILE.toml",
            help="Read parameters from TOML; flags win over it.",
        ),
        click.option(
            "--preset",
            cls=ArmOption,
            type=click.Choice(list(PRESETS)),
            help="Begin with a preset in place of a file: arms of two and three sections, or with tendons.",
        ),
        click.option(
            "--objects", "objects_file", cls=ArmOption, metavar="FILE.toml",
            help="Add what the arm can touch: tables [[object]] of a TOML file; those of --arm stay.",
        ),
        click.option(
            "--self-contact/--no-self-contact", cls=ArmOption, default=None,
            help="Whether the arm's links touch one another; default no.",
        ),
        click.option(
            "--world", "world_file", cls=ArmOption, metavar="FILE.xml",
            help="Attach the arm to a world of your own, an MJCF file, which says gravity.",
        ),
        click.option(
            "--mount", cls=ArmOption, metavar="SITE",
            help="Site of that world that the base goes to; omitted: its origin.",
        ),
    ]  # fmt: skip
    groups: tuple[tuple[dict[str, Field[Any]], str, type[ArmOption]], ...] = (
        (PARAMETERS, "", ArmOption), (MUSCLE_PARAMETERS, _MUSCLE, MuscleOption),
    )  # fmt: skip
    for parameters, prefix, cls in groups:
        for name, item in parameters.items():
            size, metavar = _SIZES.get(name, (1, None))
            unit = item.metadata["unit"]
            default = "omitted" if item.default is None else item.default
            if isinstance(default, tuple):
                default = " ".join(f"{x:g}" for x in default)
            elif isinstance(default, float):
                default = f"{default:g}"
            made.append(
                click.option(
                    _flag("muscle." + name if prefix else name),
                    prefix + name,
                    cls=cls,
                    type=_type(item),
                    nargs=size,
                    metavar=metavar or {"links": "N"}.get(name, None if "choices" in item.metadata else "X"),
                    help=f"{item.metadata['help']}{'' if unit == '-' else f' [{unit}]'}; default {default}.",
                )
            )
    return made


def arm_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add --arm, --preset and a flag for every parameter; the function receives them as `arm`, an `Arm`."""

    def wrapped(**given: Any) -> Any:
        from contarm_sim.model.arm_file import arm_from_dict, load_arm, load_objects

        own = {name: value for name in PARAMETERS if (value := given.pop(name)) is not None}
        muscle = {name: value for name in MUSCLE_PARAMETERS if (value := given.pop(_MUSCLE + name)) is not None}
        file, name, world, mount = (given.pop(each) for each in ("arm_file", "preset", "world_file", "mount"))
        objects, itself = given.pop("objects_file"), given.pop("self_contact")
        if file is not None and name is not None:
            raise InputError("preset", repr(name), "either --preset or --arm")
        base = load_arm(file) if file is not None else PRESETS[name]() if name is not None else None
        if world is not None or mount is not None:
            base = _attached(base or Arm(), world, mount)
        arm = arm_from_dict({**own, "muscle": muscle}, base=base)
        if objects is not None:
            arm = replace(arm, objects=(*arm.world.objects, *load_objects(objects)))
        if itself is not None:
            arm = replace(arm, self_contact=itself)
        return function(arm=arm, **given)

    wrapped.__doc__, wrapped.__name__ = function.__doc__, function.__name__
    wrapped.__click_params__ = getattr(function, "__click_params__", [])  # type: ignore[attr-defined]
    for option in reversed(_parameter_options()):
        wrapped = option(wrapped)
    return wrapped


def _attached(arm: Arm, file: str | None, mount: str | None) -> Arm:
    """Return an arm in the world that flags name, which wins over that of its file.

    Raises:
        InputError: a mount without a world, or what cannot be a host.
    """
    from contarm_sim.model.host import Host

    host = arm.world.host
    if file is not None:
        host = Host(file=file, site=mount)
    elif host is not None:
        host = Host(file=host.file, site=mount)
    else:
        raise InputError("mount", repr(mount), "beside --world FILE.xml")
    return arm.in_world(arm.world.hosted(host))


def controller_option(meaning: str) -> Callable[[Any], Any]:
    """Return the --controller option."""
    return click.option("--controller", default="servo", show_default=True, type=click.Choice(NAMES), help=meaning)


def bend_option(meaning: str, required: bool = False) -> Callable[[Any], Any]:
    """Return the --bend option, which comes once for each section; `bends_from_words` reads what it holds."""
    return click.option(
        "--bend", type=ANGLE, nargs=2, multiple=True, required=required, metavar="BEND_ANGLE PLANE_ANGLE", help=meaning
    )


def bends_from_words(bend: tuple[tuple[float, float], ...], arm: Arm, name: str = "bend") -> Any:
    """Return the bend [rad] that --bend describes, shape (2,); of several sections their bends, shape (S, 2).

    Raises:
        InputError: not one for each section, or an angle of half a turn or more.
    """
    import numpy as np

    from contarm_sim.kinematics import arc

    count = len(arm.sections)
    if len(bend) != count:
        allowed = "once" if count == 1 else f"{count} times, once for each section from the base to the tip"
        raise InputError(f"--{name}", f"given {len(bend)} time{'s' * (len(bend) != 1)}", allowed)
    bends = []
    for number, (angle, plane) in enumerate(bend, 1):
        if not 0 <= angle < math.pi:
            said = "" if count == 1 else f" of section {number}"
            given = f"{angle:.6g} rad ({math.degrees(angle):.6g} deg){said}"
            raise InputError("bend_angle", given, "0 <= bend_angle < pi rad (180 deg)")
        bends.append(arc.from_polar(angle, plane))
    return bends[0] if count == 1 else np.stack(bends)


json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON document, SI units, and nothing else."
)


def out_option(default: str) -> Callable[[Any], Any]:
    """Return the --out option."""
    return click.option("--out", metavar="PATH", help=f"Where to write; must not exist yet. Default: {default}.")


def muscles_option(meaning: str) -> Callable[[Any], Any]:
    """Return the --muscles option; `muscles_from_words` reads what it holds."""
    return click.option("--muscles", default="off", metavar="KIND [X ...]", help=meaning)


def muscles_from_words(text: str) -> Any:
    """Return the `Muscles` that --muscles describes: a kind and its numbers.

    Raises:
        InputError: an unknown kind, or the wrong numbers.
    """
    from contarm_sim.model.load import Muscles

    kind, *words = text.replace("|", " ").split() or [text]  # bars between sections, as they are printed
    unit = {"deltas": "m", "setpoints": "m", "tensions": "N", "pressures": "Pa", "bend": "rad"}.get(kind, "-")
    values = tuple(quantity(word, unit, f"muscles {kind}") for word in words)
    return Muscles(kind=kind, values=values)  # type: ignore[arg-type]
