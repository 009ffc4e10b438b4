"""Bad command lines, made from the parameters' descriptions: exit code 2, one short line, and nothing is written."""

import contextlib
import io
import os
import sys

import pytest
from bad_inputs import LONG, parameters

from contarm_sim.cli.main import main

WORDS = [
    "",
    "x",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1 V",
    "3kgm",
    LONG,
    "1\n2",
    "0x10",
    "1,5",
    "1 2",
    "\u22121",
    "1e",
    "..",
    "[1]",
    "\x1b[0m",
]


def contarm(words):
    """Run the command line; return (exit code, stdout, stderr)."""
    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        patch.setattr(sys, "argv", ["contarm", *words])
        with pytest.raises(SystemExit) as ended:
            main()
    return ended.value.code, out.getvalue(), err.getvalue()


def _lines():
    flags = [f"--{'muscle.' if table else ''}{name.replace('_', '-')}" for table, name, _ in parameters()]
    sizes = {"--gravity": 3, "--base-orientation": 4}
    for command in (["fk", "--bend", "1", "0"], ["ik", "--tip", "0", "0", "0.37"], ["build"]):
        for flag in flags:
            for word in WORDS:
                yield [*command, flag, *[word] * sizes.get(flag, 1)]
    own = {"fk": {"--bend": 2, "--deltas": 3, "--xi": 1},
           "ik": {"--tip": 3, "--tolerance": 1, "--file": 1, "--project": 1},
           "run": {"--duration": 1, "--turns": 1, "--max-bend": 1, "--sphere-radius": 1, "--sphere-centre": 3,
                   "--timestep": 1, "--path": 1, "--controller": 1, "--project": 1},
           "envs": {"--seeds": 1, "--actions": 1}, "render": {"--fps": 1}, "view": {"--port": 1},
           "equilibrium": {"--muscles": 1}}  # fmt: skip
    for command, sized in own.items():
        for flag, size in sized.items():
            for word in WORDS:
                yield [command, flag, *[word] * size]
    for command in ("fk", "ik", "run", "build", "render", "init", "envs", "view", "doctor"):
        yield from (
            [command, "--json=1"],
            [command, f"--{LONG}"],
            [command, "--a\nb"],
            [command, "--json", LONG, "b", "c"],
        )
    for flag in ("--length", "--mass", "--links"):
        yield ["fk", "--bend", "1", "0", flag, "x", flag, "2"]
    for word in ("nothing", LONG, "a\nb", "--unknown", "-x"):
        yield [word]
    slips = [
        "--length 370",
        "--muscle-radius 12",
        "--payload 50",
        "--mass 300",
        "--gravity 9810 0 0",
        "--muscle.max-pressure 700",
    ]
    yield from (["run", *slip.split()] for slip in slips)
    yield from (["fk", "--bend", "1.57", "90"], ["run", "--max-bend", "120"], ["ik", "--tip", "235.5", "0", "235.5"])
    for name in ("/dev/zero", "/dev/null", "/", ".", "missing", "\udcff", "a" * 300, "fifo"):
        yield from (
            ["fk", "--bend", "1", "0", "--arm", name],
            ["ik", "--file", name],
            ["render", name],
            ["run", "--path", name],
        )
    for name in ("/proc/x", "/dev/null", "/dev/null/x", "a" * 300, "taken", "taken/", "\udcff.csv", "", "/"):
        yield from (["run", "--out", name], ["build", "--out", name], ["ik", "--tip", "0", "0", "0.37", "--out", name])
        yield ["init", name]
    yield from (["run", "--timestep", "1e-6", "--duration", "3600"], ["run", "--links", "400", "--duration", "3600"])


def test_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").mkdir()
    os.mkfifo("fifo")
    before, failed, count = sorted(tmp_path.rglob("*")), [], 0
    for words in _lines():
        said = " ".join(word[:30] for word in words)
        count += 1
        try:
            code, out, err = contarm(words)
        except Exception as error:
            failed.append(f"{said!r}: {type(error).__name__}: {str(error)[:200]}")
            continue
        if (code, out) != (2, "") or not err.startswith("contarm: ") or err.count("\n") != 1 or len(err) >= 400:
            failed.append(f"{said!r}: {code} {out[:100]!r} {len(err)} {err[:300]!r}")
        elif not err[:-1].isprintable():
            failed.append(f"{said!r}: not printable: {err[:300]!r}")
    assert not failed, f"{len(failed)} of {count}\n" + "\n".join(failed)
    assert sorted(tmp_path.rglob("*")) == before
    assert count > 1000
