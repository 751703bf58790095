"""How much longer a turn of a life from pictures takes than its picture, and than a turn at the symbolic table."""

import time
from dataclasses import asdict, dataclass

import numpy as np

from jointattn_mj.development.loop import Life
from jointattn_mj.development.rendered.run import RenderedConfig, RenderedLife
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableLife
from jointattn_mj.scene.looker import Pose, TurnWorld

TURNS = 1000
"""In a block."""


@dataclass(frozen=True)
class TurnsBenchmark:
    """Medians over the blocks."""

    turn_picture_ms: float
    """Rendering alone, a picture: the same ones that the life rendered."""
    turn_ms: float
    """A turn of a life from pictures, with everything."""
    turn_to_picture: float
    """The ratio of the two, block by block."""
    symbolic_turn_us: float
    """A turn of the same mind at the symbolic table."""

    def rows(self) -> dict[str, float | str]:
        """The figures by name."""
        return asdict(self)


class _Noted(RenderedLife):
    """Notes how bodies stood in each picture."""

    poses: list[Pose]

    def see(self) -> None:
        """See ``RenderedLife``."""
        super().see()
        self.poses.append(self.stage.world.pose())


def run_turns_benchmark(blocks: int) -> TurnsBenchmark:
    """Measure lives and pictures in turns.

    Raises:
        GLError: No picture can be rendered here.
    """
    preset, turns, times = PRESETS["thesis"], (blocks + 1) * TURNS, []
    life = _Noted(preset.world, RenderedConfig(), preset.mind, 0, turns)
    symbolic = TableLife(preset.world, preset.mind, 0, turns)
    world = life.stage.world
    try:
        for block in range(blocks + 1):
            life.poses = []
            measured = _seconds(life), _render(world, life.poses), _seconds(symbolic)
            if block:  # the first compiles
                times.append(measured)
            world.stand(life.poses[-1])
    finally:
        life.close()
    in_life, pictures, at_table = np.array(times).T
    return TurnsBenchmark(
        turn_picture_ms=1000 * float(np.median(pictures)) / TURNS,
        turn_ms=1000 * float(np.median(in_life)) / TURNS,
        turn_to_picture=float(np.median(in_life / pictures)),
        symbolic_turn_us=1e6 * float(np.median(at_table)) / TURNS,
    )


def _seconds(life: Life) -> float:
    start = time.perf_counter()
    life.live(TURNS)
    return time.perf_counter() - start


def _render(world: TurnWorld, poses: list[Pose]) -> float:
    """Seconds for rendering alone; bodies are put into their places before each picture, untimed."""
    spent = 0.0
    for pose in poses:
        world.stand(pose)
        start = time.perf_counter()
        world.eye.look()
        spent += time.perf_counter() - start
    return spent
