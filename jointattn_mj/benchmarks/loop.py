"""Speed of a session, as ratios measured in one run: absolute times on shared machines mean little."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import mujoco
import numpy as np

from jointattn_mj.gaze_following.presets import PRESETS
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.options import Checked, Real, Whole
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.world import World

CARTPOLE_STEPS = 50
"""Steps of cartpole in a block; with software rendering each takes tens of milliseconds."""


@dataclass(frozen=True)
class BenchmarkOptions(Checked):
    """What is measured, and for how long."""

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
    """Speed of a session: medians over the blocks."""

    renderer: str
    """OpenGL renderer that made the images."""
    render_ms: float
    """Milliseconds to render an image, alone; the same images that the session rendered."""
    loop_ms_per_image: float
    """Milliseconds of a session from images, with everything, for each image that it rendered."""
    loop_to_render: float
    """Ratio of the two, block by block."""
    loop_times_real_time: float
    """Simulated seconds of a session from images in a second."""
    contingent_to_render: float
    """Ratio of a session of the preset cross_situational to rendering its images alone, block by block."""
    session_26_min_s: float
    """Seconds that 26 simulated minutes take at this pace."""
    state_times_real_time: float
    """Simulated seconds of a session from the state in a second."""
    cartpole_ms: float
    """Milliseconds of a step of dm_control's cartpole swingup, with pixels at 320x240."""
    loop_to_cartpole: float
    """Session from images for each rendered image, in steps of cartpole."""

    def rows(self) -> dict[str, float | str]:
        """The figures by name."""
        return asdict(self)


def as_text(rows: dict[str, Any]) -> str:
    """Figures as a table to read.

    Args:
        rows: Figures by name; None stands for what could not be measured.
    """
    return "\n".join(
        f"{name:32}{'not installed' if value is None else format(value, '' if isinstance(value, str) else '.3g')}"
        for name, value in rows.items()
    )


def run_benchmark(options: BenchmarkOptions) -> Benchmark:
    """Measure sessions from images and from the state, rendering alone, and cartpole, interleaved in blocks.

    Interleaved, a machine that changes its pace changes it for all of them.

    Args:
        options: Number and length of the blocks.

    Raises:
        GLError: No image can be rendered here.
    """
    minutes = options.blocks * options.seconds / 60
    loop = SessionRun(SessionConfig(minutes=minutes))
    robot = replace(PRESETS["cross_situational"], familiarise=loop.config.robot.familiarise)
    contingent = SessionRun(replace(loop.config, robot=robot))
    state = SessionRun(SessionConfig(minutes=minutes, perception="state"))
    scene = World.build(loop.config.world, np.random.SeedSequence(1))
    cartpole = _cartpole()
    for session in (loop, contingent, state):
        session.begin()
    _advance(state, 30)  # compiles
    block, times = round(options.seconds / FRAME_S), []
    try:
        for _ in range(options.blocks):
            (in_loop, alone, images), (in_contingent, its_alone, _) = (
                _beside_rendering(session, block, scene) for session in (loop, contingent)
            )
            in_state = _advance(state, block)
            times.append(
                (in_loop, images, alone, in_contingent / its_alone, in_state, _steps(cartpole, CARTPOLE_STEPS))
            )
        with loop.world.physics.contexts.gl.make_current() as context:
            renderer = context.call(_renderer_name)
    finally:
        for part in (loop, contingent, state, scene, cartpole):
            part.close()
    in_loop, images, rendering, contingent_to_render, in_state, steps = np.array(times, float).T
    per_image = in_loop / images
    return Benchmark(
        renderer=renderer,
        render_ms=1000 * float(np.median(rendering / images)),
        loop_ms_per_image=1000 * float(np.median(per_image)),
        loop_to_render=float(np.median(in_loop / rendering)),
        loop_times_real_time=float(np.median(options.seconds / in_loop)),
        contingent_to_render=float(np.median(contingent_to_render)),
        session_26_min_s=float(np.median(in_loop)) * 26 * 60 / options.seconds,
        state_times_real_time=float(np.median(options.seconds / in_state)),
        cartpole_ms=1000 * float(np.median(steps)) / CARTPOLE_STEPS,
        loop_to_cartpole=float(np.median(per_image / (steps / CARTPOLE_STEPS))),
    )


class Poses:
    """Poses of all bodies at each image that the robot took, so that the same images can be rendered again."""

    def __init__(self) -> None:
        self.poses: list[tuple[np.ndarray, np.ndarray]] = []
        self._rendered: int | None = None

    def note(self, session: SessionRun) -> None:
        """Keep the pose if an image was rendered; to be called at every frame of a session, before anything moves."""
        world = session.world
        if self._rendered is not None and world.rendered_frames > self._rendered:
            self.poses.append((world.data.qpos.copy(), world.data.mocap_pos.copy()))
        self._rendered = world.rendered_frames


def _beside_rendering(session: SessionRun, frames: int, scene: World) -> tuple[float, float, int]:
    """Seconds of so many frames of a session, seconds of rendering its images alone, and how many images they were."""
    taken = Poses()
    spent = _advance(session, frames, taken.note)
    return spent, _render(scene, taken), len(taken.poses)


def _advance(session: SessionRun, frames: int, watch: Callable[[SessionRun], None] | None = None) -> float:
    """Seconds that so many frames of a session take (fewer at its end)."""
    start = time.perf_counter()
    for _ in range(min(frames, session.total - session.frame)):
        session.step(watch)
    return time.perf_counter() - start


def _render(world: World, images: Poses) -> float:
    """Seconds that rendering alone takes; bodies are posed before each image, untimed."""
    spent = 0.0
    for qpos, positions in images.poses:
        world.data.qpos[:], world.data.mocap_pos[:] = qpos, positions
        mujoco.mj_fwdPosition(world.model, world.data)
        start = time.perf_counter()
        world.eye.render()
        spent += time.perf_counter() - start
    return spent


def _cartpole() -> Any:
    from dm_control import suite
    from dm_control.suite.wrappers import pixels

    environment = suite.load("cartpole", "swingup", task_kwargs={"random": 0})
    return pixels.Wrapper(environment, render_kwargs={"height": 240, "width": 320})


def _steps(environment: Any, count: int) -> float:
    action = np.zeros(environment.action_spec().shape)
    start = time.perf_counter()
    for _ in range(count):
        environment.step(action)
    return time.perf_counter() - start


def _renderer_name() -> str:
    from OpenGL import GL

    name = GL.glGetString(GL.GL_RENDERER)
    return name.decode() if name else "unknown"
