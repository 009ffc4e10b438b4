"""Filming a run, overlays, plots and captions included, over MuJoCo's bare `Renderer.render` and the same encoder.

Bare is the scene as `contarm build` writes it, at as many samples a pixel and, as here, without a shadow map: posed,
gathered, drawn and encoded; MuJoCo's own capsules and cylinders, nothing over the arm. And with MuJoCo's defaults.
"""

import tempfile
import time
from functools import partial
from pathlib import Path

import mujoco
import numpy as np

from contarm_sim import paths
from contarm_sim.mjcf import scene_spec
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.view.rendering.encode import encoder, encoding
from contarm_sim.view.rendering.gl import choose_backend
from contarm_sim.view.rendering.look import Look, frame_indices
from contarm_sim.view.rendering.video import Shot, write_video

REPEATS = 3


def _bare(shot: Shot, path: Path, shadow: bool = False) -> None:
    """Pose, render and encode, with nothing of this project's drawing."""
    look, samples = shot.look, shot.samples
    choose_backend()
    model = scene_spec(samples.arm).compile()
    model.light_castshadow[:] &= shadow
    data = mujoco.MjData(model)
    with (
        mujoco.Renderer(model, look.height, look.width) as renderer,
        encoding(encoder(), path, (look.height, look.width), shot.fps) as add,
    ):
        for i in frame_indices(samples, shot.fps):
            data.qpos[:] = samples.qpos[i]
            for update in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_camlight, mujoco.mj_tendon):
                update(model, data)
            renderer.update_scene(data, look.camera)
            add(renderer.render())


def main() -> None:
    """Print the ratio, best of interleaved repeats."""
    arm = Arm()
    path = paths.named("spiral", arm.length, 4.0, turns=1.0)
    samples = simulate(arm, Reference.from_path(path, arm))
    shot, ours, bare, default = Shot(samples, Look()), [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(REPEATS):
            for times, job in ((bare, _bare), (ours, write_video), (default, partial(_bare, shadow=True))):
                start = time.perf_counter()
                job(shot, Path(folder) / "film.mp4")
                times.append(time.perf_counter() - start)
    frames = len(frame_indices(samples, shot.fps))
    ratio = min(ours) / min(bare)
    spread = np.divide(ours, bare)
    print(
        f"720p: {frames / min(ours):.1f} frames/s; over bare render and encode {ratio:.2f} "
        f"({spread.min():.2f} to {spread.max():.2f}), with a shadow map {min(ours) / min(default):.2f}"
    )


main()
