"""How fast everything is, as ratios measured in one run: absolute times of shared machines mean little."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import mujoco
import numpy as np

from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.world import World

CARTPOLE_STEPS = 50
"""Steps of cartpole in a block; with software GL each takes tens of milliseconds."""


@dataclass(frozen=True)
class BenchmarkOptions(Checked):
    """How long to measure."""

    what: Literal["scene", "steps", "contingency", "all"] = "scene"
    """What to measure. scene: a session from images, rendering alone, a session from the state, cartpole. steps: steps
    of chapter 5 from images, rendering these alone, and steps at the symbolic table. contingency: the detector beside
    recomputation in numpy, whole runs at the table, compiling, transfer entropy beside pyinform."""
    blocks: Annotated[int, Whole("[1, 100000]")] = 8
    """Number of repetitions of each measurement; medians are reported."""
    seconds: Annotated[float, Real("[1, 1e6]")] = 30.0
    """Simulated seconds in a block of a session."""
    out: Path | None = None
    """Also write the figures to this JSON file."""

    OLD_CHOICES: ClassVar = {"what": {"turns": "steps"}}


@dataclass(frozen=True)
class Benchmark:
    """Medians over the blocks."""

    renderer: str
    render_ms: float
    """Rendering alone, an image: the same ones that the loop rendered."""
    loop_ms_per_image: float
    """Closed loop from pixels: everything in it, divided by the images that were rendered for it."""
    loop_to_render: float
    """The ratio of the two, block by block."""
    loop_times_real_time: float
    session_26_min_s: float
    """What 26 simulated minutes take at this pace."""
    truth_times_real_time: float
    cartpole_ms: float
    """dm_control's own cartpole swingup, a step with pixels at 320x240."""
    loop_to_cartpole: float
    """Closed loop per rendered image, in cartpole steps."""

    def rows(self) -> dict[str, float | str]:
        """The figures by name."""
        return asdict(self)


def as_text(rows: dict[str, Any]) -> str:
    """A table of figures to read."""
    return "\n".join(
        f"{name:32}{'not installed' if value is None else format(value, '' if isinstance(value, str) else '.3g')}"
        for name, value in rows.items()
    )


def run_benchmark(options: BenchmarkOptions) -> Benchmark:
    """Measure in turns, so that a machine that changes its pace changes it for all.

    Raises:
        GLError: No image can be rendered here.
    """
    minutes = options.blocks * options.seconds / 60
    loop = SessionRun(SessionConfig(minutes=minutes))
    truth = SessionRun(SessionConfig(minutes=minutes, perception="state"))
    scene = World.build(loop.config.world, np.random.SeedSequence(1))
    cartpole = _cartpole()
    loop.begin()
    truth.begin()
    _live(truth, 30)  # compiles
    block, times = round(options.seconds / FRAME_S), []
    try:
        for _ in range(options.blocks):
            visible = Poses()
            in_loop = _live(loop, block, visible.note)
            alone, in_truth = _render(scene, visible), _live(truth, block)
            times.append((in_loop, len(visible.poses), alone, in_truth, _steps(cartpole, CARTPOLE_STEPS)))
        with loop.world.physics.contexts.gl.make_current() as context:
            renderer = context.call(_renderer_name)
    finally:
        loop.close()
        truth.close()
        scene.close()
        cartpole.close()
    in_loop, images, rendering, in_truth, steps = np.array(times, float).T
    per_image = in_loop / images
    return Benchmark(
        renderer=renderer,
        render_ms=1000 * float(np.median(rendering / images)),
        loop_ms_per_image=1000 * float(np.median(per_image)),
        loop_to_render=float(np.median(in_loop / rendering)),
        loop_times_real_time=float(np.median(options.seconds / in_loop)),
        session_26_min_s=float(np.median(in_loop)) * 26 * 60 / options.seconds,
        truth_times_real_time=float(np.median(options.seconds / in_truth)),
        cartpole_ms=1000 * float(np.median(steps)) / CARTPOLE_STEPS,
        loop_to_cartpole=float(np.median(per_image / (steps / CARTPOLE_STEPS))),
    )


class Poses:
    """How everything stood whenever the robot looked, so that the very same images can be rendered again."""

    def __init__(self) -> None:
        self.poses: list[tuple[np.ndarray, np.ndarray]] = []
        self._rendered: int | None = None

    def note(self, session: SessionRun) -> None:
        """Called at every frame of a session, before anything moves."""
        world = session.world
        if self._rendered is not None and world.rendered_frames > self._rendered:
            self.poses.append((world.data.qpos.copy(), world.data.mocap_pos.copy()))
        self._rendered = world.rendered_frames


def _live(session: SessionRun, frames: int, watch: Callable[[SessionRun], None] | None = None) -> float:
    """Seconds for so many frames of a session (fewer at its end)."""
    start = time.perf_counter()
    for _ in range(min(frames, session.total - session.frame)):
        session.step(watch)
    return time.perf_counter() - start


def _render(world: World, visible: Poses) -> float:
    """Seconds for rendering alone; things are put into their places before each image, untimed."""
    spent = 0.0
    for qpos, locations in visible.poses:
        world.data.qpos[:], world.data.mocap_pos[:] = qpos, locations
        mujoco.mj_fwdPosition(world.model, world.data)
        start = time.perf_counter()
        world.eye.look()
        spent += time.perf_counter() - start
    return spent


def _cartpole():
    from dm_control import suite
    from dm_control.suite.wrappers import pixels

    environment = suite.load("cartpole", "swingup", task_kwargs={"random": 0})
    return pixels.Wrapper(environment, render_kwargs={"height": 240, "width": 320})


def _steps(environment, count: int) -> float:
    action = np.zeros(environment.action_spec().shape)
    start = time.perf_counter()
    for _ in range(count):
        environment.step(action)
    return time.perf_counter() - start


def _renderer_name() -> str:
    from OpenGL import GL

    name = GL.glGetString(GL.GL_RENDERER)
    return name.decode() if name else "unknown"
