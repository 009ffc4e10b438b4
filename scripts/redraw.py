"""Runs what README and docs show, and writes what comes out in its place; draws their figures again.

    python scripts/redraw.py                  everything
    python scripts/redraw.py figures          the figures alone
    python scripts/redraw.py tutorial drives  the blocks whose page or command contains one of these words

Nothing is rewritten that differs only in times. Changes show in `git diff`: read them before committing.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from blocks import ROOT, blocks, pages

IMAGES = ROOT / "docs" / "images"
FIGURES = {
    "fan": "fan", "sag": "sag", "error-map": "error_maps", "possibility": "possibility",
    "controllers": "controllers", "stiffness": "stiffness", "errors-by-bend": "errors_by_bend",
}  # fmt: skip
"""Figures of `contarm figures`, and their files in docs/images."""

OF_SEVERAL = {"slices": "slices", "elbow": "family"}
"""The same of two sections."""


def say(text: str) -> None:
    """Tell how far it is."""
    print(f"redraw: {text}", file=sys.stderr, flush=True)


def contarm(*words: str | Path, folder: Path) -> None:
    """Run a command that draws.

    Raises:
        subprocess.CalledProcessError: it failed.
    """
    subprocess.run([sys.executable, "-m", "contarm_sim", *map(str, words)], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)  # fmt: skip


def redraw_text(words: list[str]) -> None:
    """Run every block that a word picks, and put its output in place."""
    for page in pages():
        for block in sorted(blocks(page), key=lambda block: block.span, reverse=True):
            name = f"{page.relative_to(ROOT)}: {block.code.strip().splitlines()[0]}"
            if words and not any(word in name for word in words):
                continue
            say(name)
            with tempfile.TemporaryDirectory() as folder:
                printed = block.run(Path(folder))
            if not block.same(printed):
                say("  changed")
                text = page.read_text()
                if text[slice(*block.span)] != block.shown:
                    sys.exit(f"redraw: {page} was edited meanwhile; run this again")
                page.write_text(text[: block.span[0]] + printed + text[block.span[1] :])


def redraw_figures() -> None:
    """Draw docs/images again; `view.png`, a picture of a browser's window, stays."""
    say("figures")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for figures, given in ((FIGURES, ()), (OF_SEVERAL, ("--preset", "two"))):
            out = f"drawn-{len(figures)}"
            contarm("figures", *figures, *given, "--figures", "png", "--out", out, folder=folder)
            for name, file in figures.items():
                (folder / out / f"{name}.png").replace(IMAGES / f"{file}.png")
        contarm("trust", "--out", "trust", folder=folder)
        (folder / "trust" / "trust.png").replace(IMAGES / "trust.png")
        _sweeps(folder)
        fit = f"import runpy; runpy.run_path({str(ROOT / 'examples' / 'fit_recording.py')!r})['found'].report('fit')"
        subprocess.run([sys.executable, "-c", fit], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        (folder / "fit" / "parameters.png").replace(IMAGES / "fit.png")
        contarm("run", "--no-video", "--out", "spiral", folder=folder)
        contarm("render", "spiral", "--out", "spiral.gif", "--size", "480p", "--speed", "2", folder=folder)
        telling = ("--size", "1280x640", "--time", "9.5", "--no-plots")
        contarm("render", "spiral", "--out", "social.png", *telling, folder=folder)
        hanging = ("--gravity", "0", "0", "9.81", "--payload", "0.05")
        sampled = ("--uncertain", ROOT / "examples" / "uncertain.toml")
        contarm("run", *hanging, *sampled, "--no-video", "--out", "sampled", folder=folder)
        for name in ("uncertainty.png", "causes.png"):
            (folder / "sampled" / name).replace(IMAGES / name)
        still = ("--size", "480p", "--time", "9.5", "--no-captions")
        contarm("render", "sampled", "--out", "sampled.png", *still, folder=folder)
        contarm("run", "--preset", "two", "--path", "circle", "--no-video", "--out", "two", folder=folder)
        contarm("render", "two", "--out", "two-sections.gif", "--size", "480p", "--speed", "2", folder=folder)
        for name in ("spiral.gif", "social.png", "two-sections.gif", "sampled.png"):
            (folder / name).replace(IMAGES / name)
    for script in ("drawings.py", "hysteresis.py", "replays.py", "contacts.py", "demos.py"):
        subprocess.run([sys.executable, ROOT / "scripts" / script], check=True)


def _sweeps(folder: Path) -> None:
    """Draw the validity chart, and the example of `contarm sweep --help`."""
    for name, figure, file in (("validity", "validity", "validity"), ("soft", "heat_map", "sweep")):
        contarm("sweep", name, folder=folder)
        contarm("sweep-report", f"runs/sweep-{name}", "--out", f"report-{name}", folder=folder)
        (folder / f"report-{name}" / f"{figure}.png").replace(IMAGES / f"{file}.png")


def main() -> None:
    """Redraw all, or what the arguments name."""
    words = sys.argv[1:]
    if not words or "figures" in words:
        redraw_figures()
    if words != ["figures"]:
        redraw_text([word for word in words if word != "figures"])


if __name__ == "__main__":
    main()
