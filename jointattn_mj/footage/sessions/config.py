"""Options of a session of chapter 6 before recorded or present people."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import tyro

from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.colours import candidate_names, object_colours, sought_objects
from jointattn_mj.footage.interest import FaceRule
from jointattn_mj.footage.perception_config import FootagePerceptionConfig
from jointattn_mj.footage.sessions.lens import HeadConfig
from jointattn_mj.gaze_following.agent import RobotConfig
from jointattn_mj.options import Real, Seed, Whole
from jointattn_mj.perception.objects import MOST_COLOURS, colour_table


@dataclass(frozen=True)
class FootageSessionConfig(FootagePerceptionConfig):
    """What decides a session before a person, whether recorded or present."""

    objects: Annotated[tuple[str, ...], tyro.conf.arg(aliases=("--object",))] = ("yellow", "blue", "green")
    """Objects on the table, as for jointattn perceive: known colours (yellow, blue, green, magenta, cyan, violet, lime,
    azure, red, orange), a name with a colour, cup=#2b3ac0, or as picked by time and pixel, cup@12.5s:420,310."""
    detector: Literal["yunet", "templates"] = "yunet"
    """What finds faces: YuNet, for people, needs the extra footage; templates are the robot's own of chapter 6, for one
    rendered face at most."""
    face: str = "largest"
    """Face of interest where there are several, with YuNet: the largest, a person by number in the order in which they
    are first seen, or whatever face is in a region, x0,y0,x1,y1 in pixels of the wide image."""
    minutes: Annotated[float, Real("(0, 1e6]")] | None = None
    """Minutes of the session, after those in which the robot learns the person's face (--robot.familiarise.minutes);
    all of a video if not given. Before a camera until it is ended."""
    success: Literal["either", "launch", "landing"] = "either"
    """Count a gaze shift as success by where the person looks at launch, at landing, or either. All are logged."""
    seed: Seed = 0
    """Seed of all random draws. Every component draws from a stream of its own."""
    start_from: Path | None = None
    """Begin with what the robot of an earlier session had learned: its weights.npz. It then learns no faces first."""
    face_follow: Annotated[float, Real("(0, 1]")] = 0.4
    """Weight of each frame in the remembered location of the face. The caregiver of chapter 6 stays in one location
    (0.02); people sway."""
    head: HeadConfig = field(default_factory=HeadConfig)
    """Digital pan and tilt."""
    robot: RobotConfig = field(default_factory=RobotConfig)
    """The robot's attention, learning and gaze control."""

    ADVANCED: ClassVar[Sequence[str]] = ("face_follow", "success")

    def __post_init__(self) -> None:
        super().__post_init__()
        FaceRule.parsed(self.face)
        if self.face != "largest" and self.detector != "yunet":
            raise ConfigError(f"face {self.face}: only the detector yunet tells faces apart; got {self.detector}")
        names, rgb = object_colours(self.objects)
        if names:
            colour_table(rgb, self.pixels.colours)
        if len(sought_objects(self.objects)) > MOST_COLOURS:
            raise ConfigError(f"objects: at most {MOST_COLOURS}; got {len(self.objects)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Of the objects."""
        return candidate_names(self.objects)

    @property
    def most_minutes(self) -> float:
        """Longest that the session can last, minutes; an hour where nobody knows."""
        return 60.0 if self.minutes is None else self.minutes


@dataclass(frozen=True)
class VideoSessionConfig(FootageSessionConfig):
    """What decides a session at a recorded table."""

    video_file: Path = Path("table.mp4")
    """Video of a person at a table, from a camera that stands still, opposite the person."""
    coding: Path | None = None
    """Where the person looks, as coded by hand: a file that jointattn measure reads (ELAN, BORIS, Datavyu, a table);
    codes are the names of the objects. Success is counted by it; the robot is not told."""
    looks_at: Path | None = None
    """The same as coded without labels: the folder of a run of jointattn perceive --looks with this video."""
    fps: Annotated[float, Real("[0.01, 1000]")] | None = None
    """Images a second, for a file whose timestamps are wrong or missing; they are ignored then."""

    ADVANCED: ClassVar[Sequence[str]] = ("fps",)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.coding is not None and self.looks_at is not None:
            raise ConfigError("coding and looks_at both say where the person looks; give one of the two")


@dataclass(frozen=True)
class CameraSessionConfig(FootageSessionConfig):
    """What decides a session with a person who is there."""

    camera: str = "0"
    """The camera: a number from 0, a device such as /dev/video2, or a video file, which is played as if it were one."""
    size: tuple[Annotated[int, Whole("[160, 8192]")], Annotated[int, Whole("[120, 8192]")]] = (1280, 720)
    """Width and height of images that the camera is asked for; it may give others."""
