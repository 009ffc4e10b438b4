"""What README and docs show that a machine can make again: examples with their output, and tables.

Three kinds of block, all plain Markdown:

    ```console    one line `$ contarm ...`, followed by ```text: what it prints
    ```python     followed by ```text: what it prints
    <!-- made by: python benchmarks/elastica.py -->   Markdown that the command prints, to   <!-- end -->

`scripts/docs` runs them and writes what comes out in their place; tests run them and compare.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

_LINES = r"(?:(?!```).*\n)*"  # up to the end of the fence
_EXAMPLE = re.compile(
    rf"^```(?P<kind>console|python)\n(?P<code>{_LINES})```\n\s*```text\n(?P<shown>{_LINES})```", re.MULTILINE
)
_TABLE = re.compile(r"^<!-- made by: (?P<code>.*?) -->\n(?P<shown>.*?)^<!-- end -->", re.DOTALL | re.MULTILINE)
_COMMANDS = re.compile(r"^\$ contarm +(.*?)(?:\s{2,}#.*)?$", re.MULTILINE)
_VOLATILE = re.compile(r"runs/\S+|[\d.]+ x real time", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """Something shown that was made by running something.

    Attributes:
        page: the file that it stands in.
        kind: console, python or table.
        code: what to run.
        shown: what stands there as its output.
        span: where `shown` stands in the page.
    """

    page: Path
    kind: str
    code: str
    shown: str
    span: tuple[int, int]

    def run(self, folder: Path) -> str:
        """Return what it prints now, run in a folder: stdout, then what stderr says of files that were written.

        Raises:
            RuntimeError: it did not run to its end.
        """
        words = [sys.executable, "-W", "error", "-c", self.code]
        if self.kind == "console":
            words = [sys.executable, "-m", "contarm_sim", *self.words]
        elif self.kind == "table":
            program, *rest = shlex.split(self.code.removeprefix("python "))
            words = [sys.executable, str(ROOT / program), *rest]
        path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": path})
        return self.printed(done.returncode, done.stdout, done.stderr)

    @property
    def words(self) -> list[str]:
        """The arguments of `contarm` in a block of the kind console."""
        return shlex.split(_COMMANDS.findall(self.code)[0])

    def printed(self, code: int, out: str, err: str) -> str:
        """Return what is to be shown of an exit code, stdout and stderr.

        Raises:
            RuntimeError: they are those of something that did not run to its end.
        """
        if code not in (0, 1) or "Traceback" in err or (self.kind != "console" and code):
            raise RuntimeError(f"{self.page.name}: {self.code}\n{err}")
        written = [line for line in err.splitlines() if line.startswith("written:")]  # all else is progress
        text = "\n".join([out.rstrip("\n"), *(written if self.kind == "console" else [])])
        return "".join(line.rstrip() + "\n" for line in text.strip("\n").splitlines())

    def same(self, printed: str) -> bool:
        """Tell whether an output is what is shown, apart from times and the names of new folders."""
        return _VOLATILE.sub("~", printed) == _VOLATILE.sub("~", self.shown)


def pages() -> list[Path]:
    """Return the Markdown files that people read."""
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path) -> Iterator[Block]:
    """Yield a page's blocks that have an output."""
    text = page.read_text()
    for match in _EXAMPLE.finditer(text):
        yield Block(page, match["kind"], match["code"], match["shown"], match.span("shown"))
    for match in _TABLE.finditer(text):
        yield Block(page, "table", match["code"], match["shown"], match.span("shown"))


def commands() -> list[str]:
    """Return the arguments of every `$ contarm ...` line of all pages, each once."""
    found = [line for page in pages() for line in _COMMANDS.findall(page.read_text())]
    return list(dict.fromkeys(found))
