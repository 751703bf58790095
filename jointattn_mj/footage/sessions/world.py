"""A wide image as the world of a session: the image at a pose of the head, the time, and the coded look or none."""

from collections.abc import Callable
from typing import Any

import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.sessions.head import DigitalHead
from jointattn_mj.footage.sessions.lens import HeadConfig, Lens
from jointattn_mj.footage.sessions.source import WideFrame, WideSource
from jointattn_mj.footage.sessions.truth import UNKNOWN, CodedLooks
from jointattn_mj.guards.finite import check_finite
from jointattn_mj.scene.sensor import Sensor

Open = Callable[[int], WideSource]
"""Opens the source, after so many frames of it."""


class WideWorld:
    """A world that is seen through a camera which stands still. A step is a thirtieth of a second.

    Attributes:
        frames: Number of steps so far.
        rendered_frames: How many images of the robot were cut out.
        at_border: Number of steps in which the head was asked beyond what it can reach.
        cuts: Number of frames so far that begin anew, so that motion since the frame before is unknown.
        ended: Whether there are no more frames; the last one stays.
        watch: Is called before each step. It is not kept when the world is pickled.
    """

    def __init__(self, config: HeadConfig, seed: int, source: Open, coded: CodedLooks | None = None):
        """Make a world; the first frame is read when it is first needed.

        Args:
            config: The digital head.
            seed: Of the noise that is added.
            source: Opens the source of frames.
            coded: Where the person looks, if anybody has said it.
        """
        self.config = config
        self.frames = self.rendered_frames = self.at_border = self.cuts = 0
        self.ended = False
        self._head = DigitalHead()
        self._sensor = Sensor(noise=config.noise, seed=seed)
        self.connect(source, coded)

    def connect(self, source: Open, coded: CodedLooks | None) -> None:
        """Name source and coded looks, which a pickled world has lost; for the arguments see the constructor."""
        self._open, self.coded = source, coded
        self._source: WideSource | None = None
        self._wide_frame: WideFrame | None = None
        self._lens: Lens | None = None
        self._image: np.ndarray | None = None
        self.watch: Callable[[], object] = lambda: None

    def __repr__(self) -> str:
        return f"WideWorld({self.frames} frames, head at {np.degrees(self.head_angles()).round(1).tolist()} deg)"

    @property
    def wide_frame(self) -> WideFrame:
        """The wide image now.

        Raises:
            FootageError: There is none.
        """
        if self._wide_frame is None:
            self._source = self._open(self.frames - self.ended)  # the last frame stays
            self._wide_frame = self._source.next()
            if self._wide_frame is None:
                raise FootageError("there is no frame where the session should go on; give the same video again")
            self.cuts += self._wide_frame.cut
        return self._wide_frame

    @property
    def source(self) -> WideSource | None:
        """Where frames come from; None before the first one."""
        return self._source

    @property
    def lens(self) -> Lens:
        """Geometry of the wide image now.

        Raises:
            FootageError: The wide image leaves the head no room to turn.
        """
        height, width = self.wide_frame.image.shape[:2]
        if self._lens is None or (self._lens.width, self._lens.height) != (width, height):
            assert self._source is not None
            self._lens = Lens(width, height, self.config, self._source.aspect)
        return self._lens

    def step(self, command: np.ndarray) -> None:
        """Go on by one frame, in which the head follows ``command`` (2,), pan and tilt, rad."""
        self.watch()
        wanted = np.degrees(command)
        limited = self.lens.limited(wanted)
        self.at_border += bool(np.abs(limited - wanted).max() > 1e-6)
        self._head.step(np.radians(limited))
        assert self._source is not None
        wide_frame = self._source.next()
        self.frames += 1
        self._image = None
        if wide_frame is None:
            self.ended = True
        else:
            self._wide_frame = wide_frame
            self.cuts += wide_frame.cut

    def image(self) -> np.ndarray:
        """The robot's image now, uint8 (240, 320, 3) RGB; made at the first call in a frame."""
        if self._image is None:
            self._image = self.lens.crop(self.wide_frame.image, np.degrees(self._head.angles))
            self._sensor.expose(self._image, self.frames)
            self.rendered_frames += 1
        return self._image

    def head_angles(self) -> np.ndarray:
        """Pan and tilt of the digital head, (2,), rad; a new array."""
        return self._head.angles

    def head_moves(self) -> bool:
        """Whether the head turns."""
        return self._head.moves

    def looks_at(self) -> int:
        """Number of the object at which the person looks, NO_OBJECT, or UNKNOWN; the robot is not told."""
        return UNKNOWN if self.coded is None else self.coded.at(self.wide_frame.time_s)

    def check(self) -> None:
        """Raises NotFiniteError: The head's angles are no finite numbers."""
        check_finite({"the head's angles": self._head.angles})

    def close(self) -> None:
        """Let go of the source."""
        if self._source is not None:
            self._source.close()
            self._source = None

    def __getstate__(self) -> dict[str, Any]:
        """What the future depends on; the source is opened again."""
        kept = ("config", "frames", "rendered_frames", "at_border", "cuts", "ended", "_head", "_sensor")
        return {name: getattr(self, name) for name in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a world, without a source until ``connect`` names one."""
        self.__dict__.update(state)
        self.connect(_not_connected, None)


def _not_connected(frames: int) -> WideSource:
    raise FootageError("this world has no source of frames; resume the session that it belongs to")
