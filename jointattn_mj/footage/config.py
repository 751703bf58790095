"""Options of watching a video: what is perceived and attended to, and where the results go."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import tyro

from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.colours import candidate_names, object_colours
from jointattn_mj.footage.frame_map import Fit
from jointattn_mj.footage.interest import FaceRule
from jointattn_mj.footage.looks.coding import AWAY, PARTNER, UNSEEN, UNSURE
from jointattn_mj.footage.looks.config import LooksConfig
from jointattn_mj.footage.perception_config import FootagePerceptionConfig
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.gaze_following.gate import GazeConfig
from jointattn_mj.options import Checked, Real, Seed, Whole
from jointattn_mj.perception.objects import MOST_COLOURS, colour_table
from jointattn_mj.perception.som import SOMConfig


@dataclass(frozen=True)
class PerceiveConfig(FootagePerceptionConfig):
    """Everything that decides what is perceived and attended to."""

    video: tyro.conf.Positional[Path]
    """Video of people at a table, in any format that OpenCV's ffmpeg reads."""
    objects: Annotated[tuple[str, ...], tyro.conf.arg(aliases=("--object",))] = ("yellow", "blue", "green")
    """Objects to look for. By colour: yellow, blue, green, magenta, cyan, violet, lime, azure, red, orange, or a name
    of your own with a colour, cup=#2b3ac0; colours must be saturated, and their hues 8 degrees apart or more. As picked
    in the video, by time and pixel, cup@12.5s:420,310: the object is known by all of its colours, whatever they are.
    Skin is red and orange, so these two are not looked for unless asked."""
    areas_each: Annotated[int, Whole("[1, 9]")] = 1
    """Areas that are followed of each object, where there are several of one colour: cup, cup_2, ..."""
    detector: Literal["yunet", "templates"] = "yunet"
    """What finds faces: YuNet, for people, needs the extra footage; templates are the robot's own of chapter 6, for one
    rendered face at most, and tell no people apart."""
    face: str = "largest"
    """Face of interest where there are several: the largest, a person by number as in people.parquet, or whatever face
    is in a region, x0,y0,x1,y1 in pixels of the video."""
    looks: bool = False
    """Code at which object the person of interest looks, learned from the video itself: looks.parquet, and the tier
    "looks at" of events.csv. Objects must be moved now and then, and the camera must be still. The largest other face
    is called partner."""
    labels: Path | None = None
    """Codings of a person, as for check, of some minutes of this video: with looks, learning takes them for granted.
    They help most where little is moved."""
    max_minutes: Annotated[float, Real("(0, 1e6]")] | None = None
    """Minutes of the video to watch; all of it if not given."""
    fps: Annotated[float, Real("[0.01, 1000]")] | None = None
    """Images a second, for a file whose timestamps are wrong or missing; they are ignored then."""
    fit: Fit = "whole"
    """How the video is fitted into the robot's image of 320x240: all of it with black bars, or its middle, which fills
    the image."""
    scale: Annotated[float, Real("[0.001, 10]")] | None = None
    """Pixels of the robot's image for one of the video. If not given, the video fits the image; with the detector
    templates it is smaller where the face would exceed them. YuNet looks at the video's own pixels."""
    face_follow: Annotated[float, Real("(0, 1]")] = 0.4
    """Weight of each frame in the remembered location of the face, around which it is searched for. The caregiver of
    chapter 6 turns the head in one location (0.02). A face that swayed by 25 pixels in 5 s was followed to a pixel
    with 0.4, and to ten with 0.1."""
    shift_frames: Annotated[int, Whole("[0, 10000]")] = GazeConfig.shift_frames
    """Frames that a shift of attention takes, like a turn of the robot's head; 0 shifts at once."""
    seed: Seed = 0
    """Seed of all random draws: of attention, and of the map of faces."""
    attention: AttentionConfig = field(default_factory=AttentionConfig)
    """What attention is drawn to, and when (6.3.2)."""
    som: SOMConfig = field(default_factory=SOMConfig)
    """Self-organising map of faces (6.3.3, 6.4.1)."""
    coding: LooksConfig = field(default_factory=LooksConfig)
    """How looks are coded, with looks."""

    ADVANCED: ClassVar[Sequence[str]] = ("face_follow", "fps", "shift_frames")

    def __post_init__(self) -> None:
        super().__post_init__()
        FaceRule.parsed(self.face)
        if self.face != "largest" and self.detector != "yunet":
            raise ConfigError(f"face {self.face}: only the detector yunet tells faces apart; got {self.detector}")
        names, rgb = object_colours(self.objects)
        if names:
            colour_table(rgb, self.pixels.colours)
        candidates = candidate_names(self.objects, self.areas_each)
        if self.looks and {AWAY, PARTNER, UNSURE, UNSEEN} & set(candidates):
            raise ConfigError(f"objects: with looks none may be called {AWAY}, {PARTNER}, {UNSURE} or {UNSEEN}")
        if len(candidates) > MOST_COLOURS or len(set(candidates)) < len(candidates):
            raise ConfigError(f"objects: at most {MOST_COLOURS} candidates, each with its own name; got {candidates}")


@dataclass(frozen=True)
class PerceiveOptions(Checked):
    """Where the results go, and how much of them."""

    out: Path
    """Folder for the results. It is made when missing, and refused when it holds another run."""
    resume: bool = False
    """Continue from the checkpoint in the folder, to the same final result."""
    overlay: bool = True
    """Write a video with everything that is perceived drawn on it. It takes most of the time."""
    blur_faces: bool = False
    """Make all faces unrecognisable in the overlay and in fixations.png, and leave out som.png, which shows the face.
    A face that the detector misses is not blurred: look before you show it to anybody."""
    overlay_every: Annotated[int, Whole("[1, 1e6]")] = 1
    """Write one image of that video for so many frames: 1 is 30 a second."""
    checkpoint_minutes: Annotated[float, Real("(0, 1e6]")] = 2.0
    """Minutes of the video between checkpoints: at most so much is lost by a kill."""
    check: Path | None = None
    """Codings of a person, in any form that ``jointattn measure`` reads: where the person of interest looks. Kappa with
    its interval goes to summary.json. Needs looks; with resume, a viewing that has ended is compared, too."""
    page: bool = True
    """With looks, make page/report.html: timelines, and who follows whom, as ``jointattn recordings`` does."""
