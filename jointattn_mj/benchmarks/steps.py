"""How much longer a turn of a life from images takes than its image, and than a turn at the symbolic table."""

import time
from dataclasses import asdict, dataclass

import numpy as np

from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedRun
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.scene.looker import Pose, TableWorld

STEPS = 1000
"""In a block."""


@dataclass(frozen=True)
class StepsBenchmark:
    """Medians over the blocks."""

    turn_image_ms: float
    """Rendering alone, an image: the same ones that the life rendered."""
    turn_ms: float
    """A turn of a life from images, with everything."""
    turn_to_image: float
    """The ratio of the two, block by block."""
    symbolic_turn_us: float
    """A turn of the same mind at the symbolic table."""

    def rows(self) -> dict[str, float | str]:
        """The figures by name."""
        return asdict(self)


class _Noted(RenderedRun):
    """Notes how bodies stood in each image."""

    poses: list[Pose]

    def see(self) -> None:
        """See ``RenderedRun``."""
        super().see()
        self.poses.append(self.stage.world.pose())


def run_steps_benchmark(blocks: int) -> StepsBenchmark:
    """Measure lives and images in turns.

    Raises:
        GLError: No image can be rendered here.
    """
    preset, n_steps, times = PRESETS["thesis"], (blocks + 1) * STEPS, []
    run = _Noted(preset.world, RenderedConfig(), preset.agent, 0, n_steps)
    symbolic = TableRun(preset.world, preset.agent, 0, n_steps)
    world = run.stage.world
    try:
        for block in range(blocks + 1):
            run.poses = []
            measured = _seconds(run), _render(world, run.poses), _seconds(symbolic)
            if block:  # the first compiles
                times.append(measured)
            world.stand(run.poses[-1])
    finally:
        run.close()
    in_run, images, at_table = np.array(times).T
    return StepsBenchmark(
        turn_image_ms=1000 * float(np.median(images)) / STEPS,
        turn_ms=1000 * float(np.median(in_run)) / STEPS,
        turn_to_image=float(np.median(in_run / images)),
        symbolic_turn_us=1e6 * float(np.median(at_table)) / STEPS,
    )


def _seconds(run: DevelopmentRun) -> float:
    start = time.perf_counter()
    run.advance(STEPS)
    return time.perf_counter() - start


def _render(world: TableWorld, poses: list[Pose]) -> float:
    """Seconds for rendering alone; bodies are put into their places before each image, untimed."""
    spent = 0.0
    for pose in poses:
        world.stand(pose)
        start = time.perf_counter()
        world.eye.render()
        spent += time.perf_counter() - start
    return spent
