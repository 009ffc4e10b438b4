"""Filming a run, overlays, plots and captions included, over bare `Renderer.render` and the same encoder."""

import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from contarm_sim import paths
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.view.rendering.draw import ArmRenderer
from contarm_sim.view.rendering.encode import encoder, encoding
from contarm_sim.view.rendering.film import Look, frame_indices
from contarm_sim.view.rendering.video import Shot, write_video

REPEATS = 3


def _bare(shot: Shot, path: Path) -> None:
    """Pose, render and encode, with nothing drawn over the arm."""
    look, samples = shot.look, shot.samples
    with ExitStack() as stack:
        renderer = stack.enter_context(
            ArmRenderer(shot.samples.arm, look.width, look.height, look.camera, look.quality)
        )
        add = stack.enter_context(encoding(encoder(), path, (look.height, look.width), shot.fps))
        for i in frame_indices(samples, shot.fps):
            renderer._pose(samples.qpos[i])
            renderer._renderer.update_scene(renderer._data, look.camera)
            add(renderer._renderer.render())


def main() -> None:
    """Print the ratio, best of interleaved repeats."""
    arm = Arm()
    path = paths.named("spiral", arm.length, 4.0, turns=1.0)
    samples = simulate(arm, Reference.from_path(path, arm))
    shot, ours, bare = Shot(samples, Look()), [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(REPEATS):
            for times, job in ((bare, _bare), (ours, write_video)):
                start = time.perf_counter()
                job(shot, Path(folder) / "film.mp4")
                times.append(time.perf_counter() - start)
    frames = len(frame_indices(samples, shot.fps))
    ratio = min(ours) / min(bare)
    spread = np.divide(ours, bare)
    print(
        f"720p draft: {frames / min(ours):.1f} frames/s; over bare render and encode {ratio:.2f} "
        f"({spread.min():.2f} to {spread.max():.2f})"
    )


main()
