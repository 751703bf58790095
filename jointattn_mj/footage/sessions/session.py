"""A session of chapter 6 before a recorded or present person: attention, motion cues, gate and learner are the same."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.colours import sought_objects
from jointattn_mj.footage.labels import label_table
from jointattn_mj.footage.picked import picked_tables
from jointattn_mj.footage.reader import Footage
from jointattn_mj.footage.sessions.config import FootageSessionConfig, VideoSessionConfig
from jointattn_mj.footage.sessions.frames import WideFrames
from jointattn_mj.footage.sessions.perceiver import WidePerception
from jointattn_mj.footage.sessions.source import FileSource, WideSource
from jointattn_mj.footage.sessions.summary import (
    NOT_KNOWN,
    CameraTimes,
    FootageSessionSummary,
    Told,
    summarise_footage,
)
from jointattn_mj.footage.sessions.truth import NO_OBJECT, UNKNOWN, CodedLooks
from jointattn_mj.footage.sessions.world import WideWorld
from jointattn_mj.footage.yunet import model_file
from jointattn_mj.gaze_following.agent import GazeFollower
from jointattn_mj.gaze_following.scoring import Judgement, Moment
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, FRAMES_PER_SECOND, SessionRun
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.io.weights import read_weights
from jointattn_mj.perception.percept import Perceiver
from jointattn_mj.scene.camera import direction_of, off_centre

FACELESS_S = 60.0
"""Seconds without a face after which the robot gives up before it has begun."""
MOST_MINUTES = 1e6
"""Length of a session that lasts as long as its video, or until somebody ends it."""
LOST_FRAMES = 60
"""Frames in which nothing is visible, after which the head goes back to where the face is, or straight ahead."""


@dataclass(frozen=True)
class CodedMoment(Moment):
    """What the person looks at, and where the robot saw the objects last.

    ``phase`` is None. ``target`` is None both where the person looks at no object and where that is not known.
    """

    known: bool  # whether it is known where the person looks
    clock_s: float  # by the clock of the video or camera

    @property
    def time_s(self) -> float:
        """By the clock of the video or camera, s."""
        return self.clock_s

    def nearest(self, head: np.ndarray) -> tuple[int, float]:
        """See ``Moment``; an object that was never seen is infinitely far."""
        off = [off_centre(direction, head) for direction in np.nan_to_num(self.directions, nan=np.inf)]
        index = int(np.argmin(off))
        return index, off[index]


class FootageSessionRun(SessionRun):
    """A session under way before a wide image.

    Attributes:
        begun: Whether the robot has learned the face.
        started_s: When it had, by the clock of the frames.
    """

    config: FootageSessionConfig  # type: ignore[assignment]
    frames: WideFrames  # type: ignore[assignment]

    def __init__(self, config: FootageSessionConfig):
        """Open the source.

        Raises:
            FootageError: It cannot be read.
            ExtraError: The network that finds faces is not installed.
            SeriesError, ConfigError: The coding cannot be read.
        """
        if config.detector == "yunet":
            model_file()
        self._directions = np.full((len(config.names), 2), np.nan)  # of the objects as perceived last, deg
        self._nothing = 0  # frames in a row without anything visible
        self.started_s = 0.0
        self.begun = False
        self._rgb = label_table(config.objects, {}, 1, config.pixels.colours)[1]
        super().__init__(config)  # type: ignore[arg-type]

    @property
    def wide(self) -> WideWorld:
        """The world, by its own type."""
        world: Any = self.world
        assert isinstance(world, WideWorld)
        return world

    def object_names(self) -> tuple[str, ...]:
        """See ``SessionRun``."""
        return self.config.names

    def session_minutes(self) -> float:
        """See ``SessionRun``."""
        return MOST_MINUTES if self.config.minutes is None else self.config.minutes

    def open_source(self, frames: int) -> WideSource:
        """Open the source of frames, after so many frames of it."""
        raise NotImplementedError

    def coded_looks(self) -> CodedLooks | None:
        """Where the person looks, if anybody has said it."""
        return None

    def success_by(self) -> str:
        """What success is held against."""
        return NOT_KNOWN

    def camera_times(self) -> CameraTimes | None:
        """How well this machine keeps up with a camera; None for a file."""
        return None

    def new_world(self, seed: np.random.SeedSequence) -> Any:
        """See ``SessionRun``."""
        return WideWorld(self.config.head, self.config.seed, self.open_source, self.coded_looks())

    def new_frames(self) -> Any:
        """See ``SessionRun``."""
        return WideFrames(self.config.names)

    def new_robot(self, perceiver: Perceiver, seed: np.random.SeedSequence) -> GazeFollower:
        """See ``SessionRun``."""
        return GazeFollower(self.config.robot, perceiver, len(self.config.names), seed)

    def new_perceiver(self, rng: np.random.Generator) -> WidePerception:
        """See ``SessionRun``."""
        table, _ = label_table(self.config.objects, {}, 1, self.config.pixels.colours)
        return WidePerception(self.config, table, self.wide)

    def picked(self) -> dict[str, np.ndarray]:
        """Colours of the objects that the user has picked, by name."""
        return {}

    def begin(self) -> None:
        """Before the first frame: look up what was picked, and learn the person's face.

        Raises:
            FootageError: There is no face for a minute, or nothing of what was picked.
            CheckpointError, ConfigError: ``start_from`` is no file of weights of such a robot.
        """
        picked = self.picked()
        if picked:
            table, self._rgb = label_table(self.config.objects, picked, 1, self.config.pixels.colours)
            self.perceiver.areas.take(table)
        if self.config.start_from is not None:
            self.robot.load(read_weights(self.config.start_from))
        else:
            self._learn_face()
        self.started_s = self.wide.wide_frame.time_s
        self.begun = True

    def colours(self) -> np.ndarray:
        """(n, 3) colours of the objects, 0..1; grey where an object is picked later."""
        return self._rgb

    @property
    def perceiver(self) -> WidePerception:
        """The robot's perception."""
        perceiver: Any = self.robot.perceiver
        assert isinstance(perceiver, WidePerception)
        return perceiver

    def _learn_face(self) -> None:
        """Look at the face, and learn its patterns; frames without a face do not count."""
        wanted, without, known = round(self.config.robot.familiarise.minutes * FRAMES_PER_MINUTE), 0, 0
        while known < wanted:
            command = self.robot.familiarise(self._observation, known)
            there = self.perceiver.fix.detected
            without = 0 if there else without + 1
            known += 1
            if without >= FACELESS_S * FRAMES_PER_SECOND:
                raise FootageError(self._no_face())
            aside = None if there else self.perceiver.face_direction()
            self.wide.step(command if aside is None else np.radians(aside))
            if self.wide.ended:
                raise FootageError(
                    f"{self.source_name()} was over after {known / FRAMES_PER_SECOND:.0f} s, before the robot had "
                    f"learned the face for {wanted / FRAMES_PER_SECOND:.0f} s; give a longer one, a smaller "
                    "`robot.familiarise.minutes`, or `start_from` an earlier session"
                )

    def source_name(self) -> str:
        """What frames come from, for messages."""
        raise NotImplementedError

    def _no_face(self) -> str:
        hint = (
            "; templates are made for rendered faces: for people take `detector='yunet'`"
            if self.config.detector == "templates"
            else ""
        )
        return (
            f"no face was found in {FACELESS_S:g} s of {self.source_name()}; light it from the front, let it be at "
            f"least 20 pixels high, and put camera and person opposite each other{hint}"
        )

    def step(self, watch: Any = None) -> None:
        """One frame; see ``SessionRun``. The session ends with its last frame."""
        super().step(watch)
        self._remember()
        if self.wide.ended:
            self.total = min(self.total, self.frame)

    def _remember(self) -> None:
        """Remember where objects are, and let a head that sees nothing go back to the face."""
        percept, robot = self.robot.percept, self.robot
        if percept is None:
            return
        self._nothing = 0 if percept.visible.any() else self._nothing + 1
        if self._nothing >= LOST_FRAMES and robot.shift is None:
            direction = self.perceiver.face_direction()
            robot.hold(np.array([0.0, self.config.head.mount_deg]) if direction is None else direction)
            self._nothing = 0

    def moment(self) -> CodedMoment:
        """See ``SessionRun``."""
        percept = self.robot.percept
        if percept is not None:
            head = np.degrees(self._observation.head_angles)
            for k in np.flatnonzero(percept.visible[:-1]).tolist():
                self._directions[k] = direction_of(percept.px[k], head)
        target = self.wide.looks_at()
        return CodedMoment(
            frame=self.frame,
            phase=None,
            target=None if target in (UNKNOWN, NO_OBJECT) else target,
            directions=self._directions.copy(),
            known=target != UNKNOWN,
            clock_s=self.wide.wide_frame.time_s,
        )

    def judge(self, launch: Moment, landing: Moment, head: np.ndarray) -> Judgement:
        """See ``SessionRun``; a moment at which nobody knows where the person looks decides nothing."""
        assert isinstance(launch, CodedMoment) and isinstance(landing, CodedMoment)
        nearest, distance = landing.nearest(head)
        return Judgement(
            at_launch=launch.nearest(head)[0] == launch.target if launch.known else None,
            at_landing=nearest == landing.target if landing.known else None,
            nearest=nearest,
            distance=distance,
        )

    def check(self) -> None:
        """See ``SessionRun``."""
        check_finite(self.weights())
        self.wide.check()

    def summary(self, wall_seconds: float) -> Any:
        """The session so far in numbers; ``wall_seconds`` is its computing time."""
        told = Told(
            minutes=self.frame / FRAMES_PER_MINUTE,
            success=self.success_by(),
            reach_deg=self.wide.lens.reach(),
            border_share=self.wide.at_border / max(1, self.wide.frames),
            images=self.perceiver.fresh_frames,
            camera=self.camera_times(),
        )
        return summarise_footage(self.frames, self.shifts, told, wall_seconds)

    def summary_of(self, values: Any) -> Any:
        """See ``SessionRun``."""
        return FootageSessionSummary.of(values)

    def draw(self, out: Any) -> None:
        """Draw success, where it is known, and the map of faces."""
        from jointattn_mj.gaze_following.figures import draw_som, draw_success  # slow to import

        if self.success_by() != NOT_KNOWN:
            draw_success(out / "success.png", self.shifts, self.started_s / 60 + self.frame / FRAMES_PER_MINUTE)
        draw_som(out / "som.png", self.robot.som)

    def go_on(self) -> None:
        """Name the source and the coded looks again, after a checkpoint was read."""
        self.wide.connect(self.open_source, self.coded_looks())


class VideoSessionRun(FootageSessionRun):
    """A session at a recorded table."""

    config: VideoSessionConfig

    def source_name(self) -> str:
        """See ``FootageSessionRun``."""
        return str(self.config.video_file)

    def open_source(self, frames: int) -> FileSource:
        """See ``FootageSessionRun``."""
        source = FileSource(Footage(self.config.video_file, self.config.fps))
        source.skip(frames)
        return source

    def coded_looks(self) -> CodedLooks | None:
        """See ``FootageSessionRun``."""
        path = self.config.coding or self.config.looks_at
        return None if path is None else CodedLooks.read(path, self.config.names)

    def success_by(self) -> str:
        """See ``FootageSessionRun``."""
        if self.config.coding is not None:
            return f"coding {self.config.coding.name}"
        return NOT_KNOWN if self.config.looks_at is None else f"looks coded without labels, {self.config.looks_at.name}"

    def picked(self) -> dict[str, np.ndarray]:
        """See ``FootageSessionRun``."""
        return picked_tables(Footage(self.config.video_file, self.config.fps), sought_objects(self.config.objects))
