"""What decides how a video is perceived, and where the results go."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from jointattn_mj.footage.colours import object_colours
from jointattn_mj.footage.frame_map import Fit
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.gaze_following.gate import GazeConfig
from jointattn_mj.options import Checked, Real, Seed, Whole
from jointattn_mj.perception.motion import MotionConfig
from jointattn_mj.perception.objects import colour_table
from jointattn_mj.perception.pixels import PixelConfig
from jointattn_mj.perception.som import SOMConfig

FOR_CAMERAS = MotionConfig(frames_back=3, face_px=0.08)
"""Cameras have noise, and renderings none. With noise of 6 grey values the still faces of two rendered people seemed to
move in 14 and 4 % of the images (41 and 13 % with the defaults for renderings), and their turning ones in 92 and 89 %
(97 and 93)."""


@dataclass(frozen=True)
class PerceiveConfig(Checked):
    """Everything that decides what is perceived and attended to."""

    video: tyro.conf.Positional[Path]
    """Video file of a person at a table, from a camera that stands still; any format that OpenCV's ffmpeg reads."""
    objects: tuple[str, ...] = ("red", "yellow", "blue", "green")
    """Things that interest the robot, by colour: names that it knows (red, yellow, blue, green, magenta, cyan, orange,
    violet, lime, azure), or names of your own with a colour as picked from the image, cup=#c03a2b. Saturated colours
    only, hues 8 degrees apart or more; --pixels.colours says how near a colour must be."""
    max_minutes: Annotated[float, Real("(0, 1e6]")] | None = None
    """Minutes of the video to watch; all of it if not given."""
    fps: Annotated[float, Real("[0.01, 1000]")] | None = None
    """Images a second, where the file's timestamps are wrong or missing; they are not looked at then."""
    fit: Fit = "whole"
    """How the video comes into the robot's image of 320x240: the whole of it with black bars, or its middle, which
    fills it."""
    scale: Annotated[float, Real("[0.001, 10]")] | None = None
    """Pixels of the robot's image for one of the video. If not given, so that it fits, and less where the face would
    be larger than the robot's templates."""
    face_follow: Annotated[float, Real("(0, 1]")] = 0.4
    """Share of each look in the remembered place of the face, where it is searched for. The caregiver of chapter 6
    turns her head in one place (0.02). Faces that swayed by 25 pixels in 5 s were followed to a pixel, with 0.1 to
    ten."""
    shift_frames: Annotated[int, Whole("[0, 10000]")] = GazeConfig.shift_frames
    """Frames that a shift of attention takes, as a turn of the robot's head would; 0 shifts at once."""
    seed: Seed = 0
    """All randomness comes from it: the draws of attention, the map of faces."""
    attention: AttentionConfig = field(default_factory=AttentionConfig)
    """Where and when to look (6.3.2)."""
    pixels: PixelConfig = field(default_factory=lambda: PixelConfig(motion=FOR_CAMERAS))
    """How images are perceived; sizes are pixels of the robot's image."""
    som: SOMConfig = field(default_factory=SOMConfig)
    """The map of faces (6.3.3, 6.4.1)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        colour_table(object_colours(self.objects)[1], self.pixels.colours)


@dataclass(frozen=True)
class PerceiveOptions(Checked):
    """Where the results go, and how much of them."""

    out: Path
    """Folder for the results; made when missing, refused when it holds another run."""
    resume: bool = False
    """Go on from the checkpoint in the folder, to the same final result."""
    overlay: bool = True
    """Leave a video with everything that is perceived drawn on it; it takes most of the time."""
    overlay_every: Annotated[int, Whole("[1, 1e6]")] = 1
    """Frames for one image of that video: 1 is 30 a second."""
    checkpoint_minutes: Annotated[float, Real("(0, 1e6]")] = 2.0
    """Minutes of the video between checkpoints: at most so much is lost by a kill."""
