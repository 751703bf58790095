"""Speed of a session, as ratios measured in one run: absolute times on shared machines mean little."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from dm_control.mujoco.engine import Camera

from jointattn_mj.benchmarks.figures import Figures
from jointattn_mj.benchmarks.options import BenchmarkOptions
from jointattn_mj.gaze_following.agent import FamiliariseConfig
from jointattn_mj.gaze_following.presets import PRESETS
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.world import World

CARTPOLE_STEPS = 50
"""Steps of cartpole in a block; with software rendering each takes tens of milliseconds."""


def run_benchmark(options: BenchmarkOptions) -> Figures:
    """Measure sessions from images and from the state, rendering alone, and cartpole, interleaved in blocks.

    Interleaved, a machine that changes its pace changes it for all of them.

    Args:
        options: Number and length of the blocks.

    Returns:
        renderer: OpenGL renderer that made the images. render_ms: milliseconds to render an image, alone; the same
        images that the session rendered. render_to_dm_control: that time beside dm_control's for these images.
        loop_ms_per_image: of a session from images, with everything, for each image that it rendered. loop_to_render:
        ratio of the two, block by block. contingent_to_render: the same ratio of a session of the preset
        cross_situational. changes_to_render: of a session that draws only what has changed, beside rendering all of the
        same images. loop_times_real_time: simulated seconds of a session from images in a second. session_26_min_s:
        seconds that 26 simulated minutes take at this pace. familiarise_s: seconds in which the robot gets to know the
        face, before a session. state_times_real_time: simulated seconds of a session from the state in a second.
        closed_form_times_real_time: the same without the physics (``world.dynamics closed_form``). cartpole_ms: a step
        of dm_control's cartpole swingup, with pixels at 320x240. loop_to_cartpole: session from images for each
        rendered image, in steps of cartpole.

    Raises:
        GLError: No image can be rendered here.
    """
    minutes = options.blocks * options.seconds / 60
    loop = SessionRun(SessionConfig(minutes=minutes))
    robot = replace(PRESETS["cross_situational"], familiarise=loop.config.robot.familiarise)
    contingent = SessionRun(replace(loop.config, robot=robot))
    changes = SessionRun(replace(loop.config, world=replace(loop.config.world, draws="changes")))
    state = SessionRun(SessionConfig(minutes=minutes, perception="state"))
    closed = SessionRun(replace(state.config, world=replace(state.config.world, dynamics="closed_form")))
    scene = World.build(loop.config.world, np.random.SeedSequence(1))
    usual = Camera(scene.physics, IMAGE_HEIGHT, IMAGE_WIDTH, "robot/eye")
    cartpole = _cartpole()
    _compile(loop.config)
    start = time.perf_counter()
    loop.begin()
    familiarised = time.perf_counter() - start
    contingent.begin()
    changes.begin()
    for session in (state, closed):
        session.begin()
        _advance(session, 30)  # compiles
    block, times = round(options.seconds / FRAME_S), []
    try:
        for _ in range(options.blocks):
            (in_loop, alone, taken), *others = (
                _beside_rendering(session, block, scene) for session in (loop, contingent, changes)
            )
            ratios = [
                alone / _render(scene, taken, usual.render),
                *(spent / its_alone for spent, its_alone, _ in others),
            ]
            without_images = [_advance(session, block) for session in (state, closed)]
            steps = _steps(cartpole, CARTPOLE_STEPS)
            times.append((in_loop, len(taken.poses), alone, *ratios, *without_images, steps))
        with loop.world.physics.contexts.gl.make_current() as context:
            renderer = context.call(_renderer_name)
    finally:
        for part in (loop, contingent, changes, state, closed, scene, cartpole):
            part.close()
    in_loop, images, rendering, *ratios, in_state, in_closed_form, in_cartpole = np.array(times, float).T
    render_to_dm_control, contingent_to_render, changes_to_render = ratios
    per_image, figures = in_loop / images, Figures()
    figures.add("renderer", renderer)
    figures.add("render_ms", 1000 * rendering / images)
    figures.add("render_to_dm_control", render_to_dm_control)
    figures.add("loop_ms_per_image", 1000 * per_image)
    figures.add("loop_to_render", in_loop / rendering)
    figures.add("contingent_to_render", contingent_to_render)
    figures.add("changes_to_render", changes_to_render)
    figures.add("loop_times_real_time", options.seconds / in_loop)
    figures.add("session_26_min_s", in_loop * 26 * 60 / options.seconds)
    figures.add("familiarise_s", familiarised)
    figures.add("state_times_real_time", options.seconds / in_state)
    figures.add("closed_form_times_real_time", options.seconds / in_closed_form)
    figures.add("cartpole_ms", 1000 * in_cartpole / CARTPOLE_STEPS)
    figures.add("loop_to_cartpole", per_image / (in_cartpole / CARTPOLE_STEPS))
    return figures


def _compile(config: SessionConfig) -> None:
    """Compile what a session from images needs, with a session that is thrown away."""
    short = SessionRun(replace(config, minutes=0.02, robot=replace(config.robot, familiarise=FamiliariseConfig(0.02))))
    try:
        short.begin()
        _advance(short, 30)
    finally:
        short.close()


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


def _advance(session: SessionRun, frames: int, watch: Callable[[SessionRun], None] | None = None) -> float:
    """Seconds that so many frames of a session take (fewer at its end)."""
    start = time.perf_counter()
    end = min(session.frame + frames, session.total)
    while session.frame < end:
        session.advance(end - session.frame, watch)
    return time.perf_counter() - start


def _beside_rendering(session: SessionRun, frames: int, scene: World) -> tuple[float, float, Poses]:
    """Seconds that so many frames of a session take, seconds that its images take alone, and these."""
    taken = Poses()
    spent = _advance(session, frames, taken.note)
    return spent, _render(scene, taken, scene.eye.render), taken


def _render(world: World, images: Poses, render: Callable[[], object]) -> float:
    """Seconds that rendering alone takes; bodies are posed before each image, untimed."""
    spent = 0.0
    for qpos, positions in images.poses:
        world.data.qpos[:], world.data.mocap_pos[:] = qpos, positions
        mujoco.mj_fwdPosition(world.model, world.data)
        start = time.perf_counter()
        render()
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
