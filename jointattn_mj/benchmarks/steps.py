"""Speed of development from images: a step beside rendering its image, and beside a step at the symbolic table."""

import time

import numpy as np

from jointattn_mj.benchmarks.figures import Figures
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedRun
from jointattn_mj.development.rendered.senses import CentralView
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.scene.looker import Pose, TableWorld

STEPS = 1000
"""Steps in a block."""


class _PosedRun(RenderedRun):
    """A run that keeps the poses of all bodies at each image."""

    poses: list[Pose]

    def read(self, view: CentralView) -> None:
        """See ``RenderedRun``."""
        super().read(view)
        self.poses.append(self.stage.world.pose())


def run_steps_benchmark(blocks: int) -> Figures:
    """Measure runs from images, rendering alone, and runs at the symbolic table, interleaved in blocks.

    A second run from images, of the same seed, draws their centre only.

    Args:
        blocks: Their number; one more, in which functions are compiled, is not counted.

    Returns:
        step_image_ms: milliseconds to render an image, alone; the same images that the run rendered. step_ms: of a step
        from images, with everything. step_to_image: ratio of the two, block by block. centre_step_to_image: the same
        for a step of which only the centre is drawn. table_step_us: microseconds of a step of the same agent at the
        symbolic table.

    Raises:
        GLError: No image can be rendered here.
    """
    preset, n_steps, times = PRESETS["thesis"], (blocks + 1) * STEPS, []
    run = _PosedRun(preset.world, RenderedConfig(), preset.agent, 0, n_steps)
    narrow = _PosedRun(preset.world, RenderedConfig(draws="centre"), preset.agent, 0, n_steps)
    symbolic = TableRun(preset.world, preset.agent, 0, n_steps)
    world = run.stage.world
    try:
        for block in range(blocks + 1):
            run.poses, narrow.poses = [], []
            measured = _seconds(run), _render(world, run.poses), _seconds(narrow), _seconds(symbolic)
            if block:  # the first compiles
                times.append(measured)
            world.stand(run.poses[-1])
    finally:
        run.close()
        narrow.close()
    in_run, images, in_narrow, at_table = np.array(times).T
    figures = Figures()
    figures.add("step_image_ms", 1000 * images / STEPS)
    figures.add("step_ms", 1000 * in_run / STEPS)
    figures.add("step_to_image", in_run / images)
    figures.add("centre_step_to_image", in_narrow / images)
    figures.add("table_step_us", 1e6 * at_table / STEPS)
    return figures


def _seconds(run: DevelopmentRun) -> float:
    start = time.perf_counter()
    run.advance(STEPS)
    return time.perf_counter() - start


def _render(world: TableWorld, poses: list[Pose]) -> float:
    """Seconds that rendering alone takes; bodies are posed before each image, untimed."""
    spent = 0.0
    for pose in poses:
        world.stand(pose)
        start = time.perf_counter()
        world.eye.render()
        spent += time.perf_counter() - start
    return spent
