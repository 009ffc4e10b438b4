"""The training script, for a few hundred steps."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "scripts" / "train.py"


def test_the_training_script_trains_saves_and_scores(tmp_path):
    pytest.importorskip("stable_baselines3", reason="the extra `train` is not installed")
    words = [sys.executable, str(SCRIPT), "--task", "reach", "--steps", "256", "--seeds", "2", "--out", "p.zip"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["learned", "baseline", "random"]
    assert (tmp_path / "p.zip").exists()
