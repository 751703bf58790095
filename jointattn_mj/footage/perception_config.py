"""Options of perceiving real people through a camera, the same for a video that is watched and for a session."""

from dataclasses import dataclass, field

from jointattn_mj.footage.areas import AreaConfig
from jointattn_mj.footage.people import PeopleConfig
from jointattn_mj.footage.rest import RestConfig
from jointattn_mj.footage.shots import ShotConfig
from jointattn_mj.options import Checked
from jointattn_mj.perception.motion import MotionConfig
from jointattn_mj.perception.objects import ColourConfig
from jointattn_mj.perception.pixels import PixelConfig

FOR_CAMERAS = MotionConfig(frames_back=3, face_px=0.08)
"""Motion detection for cameras, which have noise that renderings lack.

With noise of 6 grey values, the still faces of two rendered people seemed to move in 14 and 4 % of the images (41 and
13 % with the defaults for renderings). Their turning faces moved in 92 and 89 % (97 and 93)."""

LARGE = ColourConfig(reach_px=32)
"""Objects in footage may be nearer, and so larger, than those on the robot's table."""


@dataclass(frozen=True, kw_only=True)
class FootagePerceptionConfig(Checked):
    """How people, objects and motion are found in the images of a camera."""

    pixels: PixelConfig = field(default_factory=lambda: PixelConfig(motion=FOR_CAMERAS, colours=LARGE))
    """How images are perceived. Sizes are pixels of the robot's image; pixels.faces is for the detector templates."""
    people: PeopleConfig = field(default_factory=PeopleConfig)
    """How the detector yunet finds, follows and tells apart people."""
    shots: ShotConfig = field(default_factory=ShotConfig)
    """How cuts and a moving camera are noticed."""
    areas: AreaConfig = field(default_factory=AreaConfig)
    """What counts as an object."""
    rest: RestConfig = field(default_factory=RestConfig)
    """What counts as motion, of people who never quite rest."""
