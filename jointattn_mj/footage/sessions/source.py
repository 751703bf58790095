"""Where wide images come from: one every thirtieth of a second, from a file or (``camera``) from a device."""

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple, Protocol

import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.reader import Footage, Still


class WideFrame(NamedTuple):
    """What a camera shows in one frame of a session."""

    image: np.ndarray  # (h, w, 3) uint8 BGR
    number: int  # of the image, from 0
    time_s: float  # by the clock of the file, or since the camera was opened
    cut: bool  # whether motion since the frame before is unknown
    taken_s: float | None = None  # by the monotonic clock of this machine; None for a file


class WideSource(Protocol):
    """A file or a camera."""

    @property
    def aspect(self) -> float:
        """Width of a pixel over its height."""

    def next(self) -> WideFrame | None:
        """The wide image of the next frame; None when there are no more."""

    def close(self) -> None:
        """Let go of file or device."""


class FileSource:
    """A video file, read from its beginning.

    Attributes:
        footage: The file.
    """

    def __init__(self, footage: Footage):
        """Read ``footage`` from now on."""
        self.footage = footage
        self._stills: Iterator[Still] = iter(footage)
        self._frame = 0

    @property
    def aspect(self) -> float:
        """Width of a pixel over its height."""
        return self.footage.aspect

    def skip(self, frames: int) -> None:
        """Leave out frames: only reading from the beginning gives the same images again.

        Raises:
            FootageError: The file has not so many.
        """
        skipped = sum(1 for _ in islice(self._stills, frames))
        if skipped < frames:
            raise FootageError(
                f"{self.footage.path} had at least {frames} frames when the session began, and has {skipped} now; give "
                "the same file"
            )
        self._frame += frames

    def next(self) -> WideFrame | None:
        """The wide image of the next frame; None when the file is over."""
        still = next(self._stills, None)
        if still is None:
            return None
        self._frame += 1
        return WideFrame(still.image, still.number, self.footage.time_of(self._frame - 1), still.cut)

    def close(self) -> None:
        """Close the file."""
        close = getattr(self._stills, "close", None)
        if close is not None:
            close()
