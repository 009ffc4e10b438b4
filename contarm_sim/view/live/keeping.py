"""Recordings become folders like those of `contarm run`, written and drawn by another process: the live arm goes on."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json

WRITTEN, DRAWN = "written", "drawn"


@dataclass
class Kept:
    """A recording: its folder, and how far it is: "", `written` (numbers), `drawn` (all), or what failed."""

    folder: Path
    state: str = ""


class Keeper:
    """Keeps recordings.

    Args:
        say: is told what is kept, and where.
        command: that recordings name as what made them.

    Attributes:
        last: the newest recording, or None.
    """

    def __init__(self, say: Callable[[str], object], command: str = "contarm view") -> None:
        self._say, self._command = say, command
        self.last: Kept | None = None
        self._at_work: list[tuple[threading.Thread, subprocess.Popen[bytes], Kept]] = []

    def keep(self, run: Trajectory) -> None:
        """Write and draw a recording; returns at once.

        Raises:
            InputError: nothing can be written here.
        """
        folder = default_folder("view")
        check_output(folder)
        self.last = kept = Kept(folder)
        # A session of its own: Ctrl-C in the terminal is for this process alone. One thread, so that a core stays free.
        child = subprocess.Popen(
            [sys.executable, "-m", "contarm_sim.view.live.keeping"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, start_new_session=True,
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip
        thread = threading.Thread(target=self._tend, args=(child, run, kept), daemon=True)
        self._at_work.append((thread, child, kept))
        thread.start()

    def _tend(self, child: subprocess.Popen[bytes], run: Trajectory, kept: Kept) -> None:
        """Hand the recording over, and hear how far it is."""
        assert child.stdin is not None
        assert child.stdout is not None
        assert child.stderr is not None
        with suppress(BrokenPipeError), child.stdin:
            pickle.dump((run, kept.folder, self._command), child.stdin, protocol=5)
        for line in child.stdout:
            word, _, place = line.decode().strip().partition(" ")
            if word in (WRITTEN, DRAWN):
                kept.folder, kept.state = Path(place), word
                self._say(f"{word}: {place}")
        said = child.stderr.read().decode(errors="replace").strip().splitlines()
        if child.wait() != 0:
            kept.state = f"not whole: {said[-1] if said else f'the process ended with {child.returncode}'}"
            self._say(f"{kept.folder} is {kept.state}")

    @property
    def busy(self) -> bool:
        """Whether something is still being written or drawn."""
        self._at_work = [work for work in self._at_work if work[0].is_alive()]
        return bool(self._at_work)

    def finish(self) -> None:
        """Wait until all is drawn; Ctrl-C leaves out what is not, never numbers."""
        try:
            if self.busy:
                self._say("drawing what was recorded; Ctrl-C again leaves figures out")
            for thread, _, _ in self._at_work:
                thread.join()
        except KeyboardInterrupt:
            for thread, child, kept in self._at_work:
                while thread.is_alive() and kept.state == "":
                    thread.join(0.1)
                child.terminate()
            self._say("numbers are whole; figures are missing")


def line_of(keeper: Keeper) -> str:
    """Return in words, for the page, where the last recording is; "" if there is none."""
    last = keeper.last
    if last is None:
        return ""
    what = {"": "being written", WRITTEN: "written, figures are being drawn", DRAWN: "open report.html there"}
    return f"recorded: `{last.folder}` ({what.get(last.state, last.state)})"


def write(run: Trajectory, folder: Path, command: str, tell: Callable[[str, Path], object]) -> None:
    """Leave what `contarm run` leaves, without a film; numbers first."""
    from contarm_sim.view.report.run import RunReport

    job = RunReport(run)
    summary = job.told("steered by hand", command=command)
    with OutputFolder(folder) as opened:
        job.write(opened.folder)
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
    tell(WRITTEN, opened.target)
    job.draw(opened.target)
    job.write_page(opened.target, summary)
    tell(DRAWN, opened.target)


def main() -> None:
    """Keep the recording that comes on stdin, when nobody else needs the processor."""
    os.nice(5)
    run, folder, command = pickle.load(sys.stdin.buffer)
    write(run, folder, command, lambda word, place: print(word, place, flush=True))


if __name__ == "__main__":
    main()
