"""A session of chapter 6: robot and caregiver interact for some minutes, and every frame and gaze shift is logged.

A session can be stored at any frame and continued from there. ``run`` gives it a folder, checkpoints and results.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower, GazeShift, RobotConfig
from jointattn_mj.gaze_following.scoring import Judgement, Moment, WorldMoment, judge
from jointattn_mj.gaze_following.shifts import Shifts, shift_row
from jointattn_mj.gaze_following.summary import SessionSummary, summarise
from jointattn_mj.gaze_following.tables import FrameTable
from jointattn_mj.gaze_following.undecided import pass_by
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.io.weights import read_weights
from jointattn_mj.options import Checked, Real, Seed
from jointattn_mj.perception.percept import Perceiver
from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
from jointattn_mj.perception.state import StateConfig, StatePerception
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.world import World, WorldConfig, WorldObservation

FRAMES_PER_SECOND = round(1 / FRAME_S)
FRAMES_PER_MINUTE = 60 * FRAMES_PER_SECOND


@dataclass(frozen=True)
class SessionConfig(Checked):
    """Everything that decides what happens in a session."""

    minutes: Annotated[float, Real("(0, 1e9]")] = 26.0
    """Simulated minutes; "each session lasted approximately 26 minutes" (6.4.3)."""
    seed: Seed = 0
    """Seed of all random draws. Every component draws from a stream of its own."""
    perception: Literal["pixels", "state"] = "pixels"
    """Perceive rendered images, or the simulator's state with the errors that were measured on images. The state is
    much faster."""
    success: Literal["either", "launch", "landing"] = "either"
    """Count a gaze shift as success by the caregiver's target at launch, at landing, or either. All are logged."""
    start_from: Path | None = None
    """Begin with what the robot of an earlier session had learned: its weights.npz."""
    world: WorldConfig = field(default_factory=WorldConfig)
    """Scene, caregiver, and the robot's body."""
    robot: RobotConfig = field(default_factory=RobotConfig)
    """The robot's attention, learning and gaze control."""
    pixels: PixelConfig = field(default_factory=PixelConfig)
    """How the robot perceives images."""
    state: StateConfig = field(default_factory=StateConfig)
    """Errors of perception with ``perception state``."""

    @property
    def most_minutes(self) -> float:
        """Longest that the session can last, minutes."""
        return self.minutes

    RENAMED: ClassVar = {"truth": "state"}
    OLD_CHOICES: ClassVar = {"perception": {"truth": "state"}}


class SessionRun:
    """A session under way, one frame at a time.

    Its parts can be exchanged: override ``new_world``, ``new_perceiver`` or ``new_robot``.

    Attributes:
        config: What decides the session.
        names: Names of the candidates for attention: the objects and, last, the face.
        world: Scene, caregiver, and the robot's body.
        robot: The robot's attention, learning and gaze control.
        total: Frames that the session has; ``frame``: the number of the next one.
        shifts: Table of gaze shifts; ``frames``: table of frames.
    """

    def __init__(self, config: SessionConfig):
        self.config = config
        world, perceiver, robot = np.random.SeedSequence(config.seed).spawn(3)
        self.names = (*self.object_names(), "face")
        self.world = self.new_world(world)
        self.robot = self.new_robot(self.new_perceiver(np.random.default_rng(perceiver)), robot)
        self.total = max(1, round(self.session_minutes() * FRAMES_PER_MINUTE))
        self.frame = 0
        self.shifts = Shifts(self.names)
        self.frames = self.new_frames()
        self._launch: Moment | None = None
        self._observation = self.new_observation()

    def object_names(self) -> tuple[str, ...]:
        """Names of the objects."""
        return tuple(item.name for item in self.config.world.scene.objects)

    def session_minutes(self) -> float:
        """Longest that the session lasts."""
        return self.config.minutes

    def new_frames(self) -> FrameTable:
        """Make the table of frames."""
        state = self.config.state
        return FrameTable(self.names[:-1], state.face_moves_above_deg_s, state.object_moves_above_m_s)

    def new_world(self, seed: np.random.SeedSequence) -> World:
        """Make scene, caregiver and the robot's body."""
        return World.build(self.config.world, seed)

    def new_observation(self) -> WorldObservation:
        """Make what the robot may know of ``self.world``."""
        return WorldObservation(self.world)

    def new_robot(self, perceiver: Perceiver, seed: np.random.SeedSequence) -> GazeFollower:
        """Make the robot that learns; its body is part of the world."""
        return GazeFollower(self.config.robot, perceiver, len(self.config.world.scene.objects), seed)

    def new_perceiver(self, rng: np.random.Generator) -> Perceiver:
        """Make what turns observations into percepts; ``self.world`` exists already."""
        if self.config.perception == "state":
            return StatePerception(self.config.state, self.world, rng)
        rgb = np.array([item.rgb for item in self.config.world.scene.objects])
        return PixelPerception(self.config.pixels, rgb, face_at=self.config.robot.face_at)

    def begin(self) -> None:
        """Before the first frame: learn the patterns of the face, or load what an earlier robot learned.

        Raises:
            CheckpointError: ``config.start_from`` is no file of weights.
            ConfigError: Its weights do not fit this robot.
        """
        if self.config.start_from is not None:
            self.robot.load(read_weights(self.config.start_from))
            return
        for frame in range(round(self.config.robot.familiarise.minutes * FRAMES_PER_MINUTE)):
            self.world.step(self.robot.familiarise(self._observation, frame))

    def step(self, watch: Callable[["SessionRun"], object] | None = None) -> None:
        """Simulate one frame; ``watch`` is called when the robot has perceived and decided, before anything moves."""
        world, robot = self.world, self.robot
        rendered, turning = world.rendered_frames, robot.shift is not None
        head = world.head_angles()
        command = robot.act(self._observation)
        if robot.landed is not None and self._launch is not None:
            self._record_landing(robot.landed, self._launch, np.degrees(head))
        if robot.shift is not None and (robot.landed is not None or not turning):
            self._launch = self.moment()
        self.frames.add(world, robot, world.rendered_frames > rendered, head)
        if watch is not None:
            watch(self)
        world.step(command)
        self.frame += 1

    def advance(self, most: int, watch: Callable[["SessionRun"], object] | None = None) -> None:
        """Simulate a frame as ``step`` does; without ``watch`` also more, ``most`` at most, if nothing is decided."""
        usual = getattr(self.step, "__func__", None) is SessionRun.step  # in no subclass, nor in this session, replaced
        if watch is not None or not usual or not pass_by(self, min(most, self.total - self.frame)):
            self.step(watch)

    def finish(self) -> None:
        """Simulate all frames that are left."""
        while self.frame < self.total:
            self.advance(self.total - self.frame)

    def moment(self) -> Moment:
        """What success may be held against now."""
        return WorldMoment(self.world, self.frame)

    def judge(self, launch: Moment, landing: Moment, head: np.ndarray) -> Judgement:
        """Score a gaze shift from the face to an object; see ``scoring.judge``."""
        return judge(launch, landing, head)

    def _record_landing(self, shift: GazeShift, launch: Moment, head: np.ndarray) -> None:
        landing = self.moment()
        judgement = success = None
        if shift.source == self.robot.face:
            judgement = self.judge(launch, landing, head)
            success = judgement.success(self.config.success)
        radius = self.config.robot.gaze.centre_radius_deg
        self.shifts.append(
            shift_row(shift, launch, landing, head, self.robot.iterations, self.names, judgement, success, radius)
        )

    def attach(self, folder: Path) -> None:
        """Keep frames and shifts in files in ``folder`` from now on, and not in memory (see ``RowStore``)."""
        self.frames.rows.attach(folder)
        self.shifts.rows.attach(folder)

    def weights(self) -> dict[str, np.ndarray]:
        """What the robot has learned, as named arrays."""
        return self.robot.weights()

    def check(self) -> None:
        """Check that all numbers are finite, as before every checkpoint and before results are written.

        Raises:
            NotFiniteError: What was learned, or the simulation, is NaN or infinite.
        """
        check_finite(self.weights())
        self.world.check()

    def summary(self, wall_seconds: float) -> SessionSummary:
        """The session so far in numbers; ``wall_seconds`` is its computing time."""
        return summarise(self.frames, self.shifts, self.config.minutes, wall_seconds)

    def summary_of(self, values: Mapping[str, Any]) -> SessionSummary:
        """The summary that ``summary.json`` holds."""
        return SessionSummary.of(values)

    def draw(self, out: Path) -> None:
        """Draw the figures of a session that has ended into the folder ``out``."""
        from jointattn_mj.gaze_following.figures import draw_som, draw_success  # slow to import

        draw_success(out / "success.png", self.shifts, self.config.minutes)
        draw_som(out / "som.png", self.robot.som)

    def go_on(self) -> None:
        """Take up again what a checkpoint does not hold."""

    def close(self) -> None:
        """Free what rendering needed."""
        self.world.close()
