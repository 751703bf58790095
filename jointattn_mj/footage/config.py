"""Options of watching a video: what is perceived and attended to, and where the results go."""

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
"""Motion detection for cameras, which have noise that renderings lack.

With noise of 6 grey values, the still faces of two rendered people seemed to move in 14 and 4 % of the images (41 and
13 % with the defaults for renderings). Their turning faces moved in 92 and 89 % (97 and 93)."""


@dataclass(frozen=True)
class PerceiveConfig(Checked):
    """Everything that decides what is perceived and attended to."""

    video: tyro.conf.Positional[Path]
    """Video of a person at a table, from a camera that stands still, in any format that OpenCV's ffmpeg reads."""
    objects: tuple[str, ...] = ("red", "yellow", "blue", "green")
    """Objects to look for, by colour: red, yellow, blue, green, magenta, cyan, orange, violet, lime, azure, or a name
    of your own with a colour picked from the image, cup=#c03a2b. Colours must be saturated, and their hues 8 degrees
    apart or more. --pixels.colours says how near a colour must be."""
    max_minutes: Annotated[float, Real("(0, 1e6]")] | None = None
    """Minutes of the video to watch; all of it if not given."""
    fps: Annotated[float, Real("[0.01, 1000]")] | None = None
    """Images a second, for a file whose timestamps are wrong or missing; they are ignored then."""
    fit: Fit = "whole"
    """How the video is fitted into the robot's image of 320x240: all of it with black bars, or its middle, which fills
    the image."""
    scale: Annotated[float, Real("[0.001, 10]")] | None = None
    """Pixels of the robot's image for one of the video. If not given, the video fits the image, and is smaller where
    the face would exceed the robot's templates."""
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
    pixels: PixelConfig = field(default_factory=lambda: PixelConfig(motion=FOR_CAMERAS))
    """How images are perceived. Sizes are pixels of the robot's image."""
    som: SOMConfig = field(default_factory=SOMConfig)
    """Self-organising map of faces (6.3.3, 6.4.1)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        colour_table(object_colours(self.objects)[1], self.pixels.colours)


@dataclass(frozen=True)
class PerceiveOptions(Checked):
    """Where the results go, and how much of them."""

    out: Path
    """Folder for the results. It is made when missing, and refused when it holds another run."""
    resume: bool = False
    """Continue from the checkpoint in the folder, to the same final result."""
    overlay: bool = True
    """Write a video with everything that is perceived drawn on it. It takes most of the time."""
    overlay_every: Annotated[int, Whole("[1, 1e6]")] = 1
    """Write one image of that video for so many frames: 1 is 30 a second."""
    checkpoint_minutes: Annotated[float, Real("(0, 1e6]")] = 2.0
    """Minutes of the video between checkpoints: at most so much is lost by a kill."""
