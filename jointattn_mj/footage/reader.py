"""A video file of any rate as images 30 times a second, by its timestamps or, where it has none, by its rate.

A frame shows the newest image taken by then. Faster videos lose images, slower ones repeat some; repetitions are
marked, for they are no evidence of stillness.
"""

import math
import os
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.interlaced import deinterlaced, first_image_s, interlaced_images
from jointattn_mj.options import is_utf8, shown

RATE = 30
"""Frames a second, section 6.4.1."""
EARLY_S = 1 / (3 * RATE)
"""Time by which a frame may come before the image that it shows: containers round timestamps."""
LONGEST_HOLD_S = 10.0
"""Time between two images above which motion from one to the other is unknown, and which is a jump of the timestamps,
and left out, unless the file says that it is so long."""
LONGEST_GAP_S = 3600.0
"""Longest time between two images that is held where the file says that it is so long."""
MISSING_S = 1.0
"""Seconds of its declared length that a file may lack, for headers round."""
DECODERS = 2
"""Number of threads that decode. Each holds images of its own, and one of the largest has 100 MB."""
TEXT = int.from_bytes(b"ansi", "little")  # codec with which ffmpeg shows a text file
PROBED_S = 2.0
"""Seconds in which interlaced images are searched for."""
AHEAD_S = 10.0
"""Seconds that are searched after an image that was perhaps not read."""
FASTEST = 1000.0
"""Declared rate, images a second, from which it is the unit of a container's clock, and no rate."""


@dataclass(frozen=True)
class Still:
    """One frame."""

    image: np.ndarray  # (h, w, 3) uint8 BGR, pixels of the video
    number: int  # of the video's image, from 0
    fresh: bool  # whether it is another image than in the frame before
    cut: bool  # whether it is the first frame, or the first after a jump: motion since the frame before is unknown


class Footage:
    """A video file; iterating reads it from its beginning.

    Attributes:
        path: The file.
        fps: Images a second, as given or declared; 0 if neither.
        aspect: Width of a pixel over its height.
        declared_s: Length that the file declares, from its beginning, s, or None.
        images: Number of images that the last iteration has read so far.
        seconds: Time of the last of them, s.
        jumps: Number of jumps in the timestamps so far.
        timed: Whether the iteration goes by timestamps.
        interlaced: Whether the video is interlaced, so that every other line is filled in.
        start_s: Time of the first image in the file, s, whose sound may begin earlier.
    """

    def __init__(self, path: Path, fps: float | None = None):
        """Open a file.

        Args:
            path: The file.
            fps: Images a second, in place of timestamps.

        Raises:
            FootageError: There is no such file, or it is no video.
        """
        self.path, self._given = path, fps
        capture = self._open()
        declared = capture.get(cv2.CAP_PROP_FPS)
        self.fps = fps or (declared if 0 < declared < FASTEST else 0.0)
        count, rate = capture.get(cv2.CAP_PROP_FRAME_COUNT), fps or declared
        self.declared_s = count / rate if 0 < count < 1e9 and rate > 0 else None
        self.aspect = _pixel_aspect(capture)
        capture.release()
        self.interlaced = interlaced_images(path, 0.0, PROBED_S)
        self.start_s = 0.0 if fps is not None else first_image_s(path)
        self.images, self.seconds, self.jumps, self.timed = 0, 0.0, 0, fps is None

    def __repr__(self) -> str:
        """In one line: file, rate and length."""
        rate = f"{self.fps:g} images a second" if self.fps else "unknown rate"
        length = f"{self.declared_s:.1f} s" if self.declared_s is not None else "unknown length"
        return f"Footage({self.path}: {rate}, {length})"

    def time_of(self, frame: int) -> float:
        """Time of a frame in the file, s, as players and coding programs count it."""
        return self.start_s + frame / RATE

    def frame_at(self, time_s: float) -> int:
        """Number of the first frame from a time of the file on."""
        return max(0, math.ceil((time_s - self.start_s) * RATE - 1e-4))

    def __iter__(self) -> Iterator[Still]:
        """The frames at 0 s, 1/30 s, 2/30 s and so on.

        Raises:
            FootageError: No image can be decoded, or there are neither timestamps nor a rate.
        """
        with ExitStack() as stack:
            capture = _capture(stack.enter_context(deinterlaced(self.path))) if self.interlaced else self._open()
            stack.callback(capture.release)
            yield from self._stills(capture)

    def _stills(self, capture: cv2.VideoCapture) -> Iterator[Still]:
        frame, held, shown, cut = 0, None, -1, True
        for image, jumped in self._images(capture):
            while held is not None and frame / RATE + EARLY_S < self.seconds:
                yield Still(held, self.images - 2, shown != self.images - 2, cut)
                frame, shown, cut = frame + 1, self.images - 2, False
            held, cut = image, cut or jumped
        if held is None:
            raise FootageError(
                f"{self.path} holds no image that can be decoded; is it damaged, or its codec unknown here? "
                f"A copy may do: ffmpeg -i {self.path.name} -c:v libx264 copy.mp4"
            )
        last, end = self.images - 1, self.seconds + (1 / self.fps if self.fps else 1 / RATE)
        while frame == 0 or frame / RATE + EARLY_S < end:
            yield Still(held, last, shown != last, cut)
            frame, shown, cut = frame + 1, last, False

    def _images(self, capture: cv2.VideoCapture) -> Iterator[tuple[np.ndarray, bool]]:
        """Every image, and whether the timestamps jumped before it; updates the attributes."""
        self.images, self.seconds, self.jumps, self.timed = 0, 0.0, 0, self._given is None
        start = last = 0.0
        before, sure_s = None, -math.inf
        while capture.grab():
            there, image = capture.retrieve()
            if not there or image is None or not image.size:
                continue
            stamp, jumped = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000, False
            lost = self.jumps > 0 or stamp < self.seconds - PROBED_S  # no timestamp says where in the file this is
            if not self.interlaced and (stamp > sure_s or (lost and sure_s < math.inf)) and _same(image, before):
                sure_s = self._check_read(stamp, lost)
            before = image
            if self.images == 0:
                start = last = stamp
            elif self.images == 1 and stamp == start:
                self.timed = False
            if not self.timed or not math.isfinite(stamp):
                self.seconds += self._interval() if self.images else 0.0
            else:
                jumped = abs(stamp - last) > LONGEST_HOLD_S
                if jumped and not self._is_gap(stamp - last, stamp - start):
                    start += stamp - last - (1 / self.fps if self.fps else 1 / RATE)
                    self.jumps += 1
                last, self.seconds = stamp, max(self.seconds, stamp - start)
            self.images += 1
            yield image, jumped

    def _check_read(self, stamp: float, lost: bool) -> float:
        """Time until which repeated images are known to have been read, s; called for an image equal to the last one.

        OpenCV leaves out interlaced images without a word.

        Args:
            stamp: Timestamp of the image, s.
            lost: Whether timestamps do not say where in the file it is, so that all of the file is searched.

        Raises:
            FootageError: Images near it are interlaced.
        """
        part = (0.0, 1e6) if lost else (max(0.0, stamp - PROBED_S), PROBED_S + AHEAD_S)
        if interlaced_images(self.path, *part):
            raise FootageError(
                f"{self.path} is interlaced from about {stamp:.0f} s on, but not from its beginning, so it cannot be "
                f"read; make a copy that is not: ffmpeg -i {self.path.name} -vf yadif -c:v libx264 copy.mp4"
            )
        return math.inf if lost else stamp + AHEAD_S

    def _is_gap(self, seconds: float, since_start_s: float) -> bool:
        """Whether no image was taken for a while, as in a recording of variable rate, rather than the clock jumped.

        Args:
            seconds: Time between two images.
            since_start_s: Time of the latter since the first image.
        """
        within = self.declared_s is not None and since_start_s < self.declared_s + MISSING_S
        return within and not self.jumps and 0 < seconds < LONGEST_GAP_S

    def _interval(self) -> float:
        if not self.fps:
            raise FootageError(
                f"{self.path} says neither when its images were taken nor how many a second; say it with `fps`"
            )
        return 1 / self.fps

    def _open(self) -> cv2.VideoCapture:
        if not self.path.is_file():
            what = "is a folder" if self.path.is_dir() else "is no file" if self.path.exists() else "does not exist"
            raise FootageError(f"{self.path} {what}; give a video file")
        try:
            with self.path.open("rb") as file:
                empty = not file.read(1)
        except OSError as error:
            raise FootageError(f"cannot read {self.path}: {error.strerror}") from error
        if empty:
            raise FootageError(f"{self.path} is empty; give a video file")
        name = os.fspath(self.path.absolute())  # a bare name with a colon would be that of a protocol
        check_utf8(name)
        capture = _capture(name)
        if not capture.isOpened() or int(capture.get(cv2.CAP_PROP_FOURCC)) == TEXT:
            capture.release()
            raise FootageError(
                f"{self.path} is no video that can be read here: another kind of file, sound alone, or a recording "
                "that was cut off before its index was written"
            )
        return capture


def check_utf8(name: str) -> None:
    """Refuse the name of a file or device that OpenCV dies of.

    Raises:
        FootageError: It is not UTF-8.
    """
    if not is_utf8(name):
        raise FootageError(f"{shown(name)} is not UTF-8, and OpenCV cannot open it; give it another name")


def _capture(name: str) -> cv2.VideoCapture:
    """OpenCV's reader of a file, or of a pipe."""
    with quiet_and_local():
        return cv2.VideoCapture(name, cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, DECODERS])


def _same(image: np.ndarray, before: np.ndarray | None) -> bool:
    """Whether two images are equal; most are told apart by a few of their rows."""
    if before is None or image.shape != before.shape:
        return False
    return np.array_equal(image[::16], before[::16]) and np.array_equal(image, before)


@contextmanager
def quiet_and_local() -> Iterator[None]:
    """Keep OpenCV and its ffmpeg from writing to stderr, and from opening anything but files and pipes.

    For all that this package opens, cameras too: the first time that OpenCV thinks of ffmpeg in a process, it reads
    what that may say, and never again. Where code of others was first, what that chose stays. Of threads that open
    something at once, the last that is done puts back what was there before the first.
    """
    with _GUARD:
        _BEFORE.append(_BEFORE[0] if _BEFORE else _hush())
    try:
        yield
    finally:
        with _GUARD:
            before = _BEFORE.pop()
            if not _BEFORE:
                _put_back(*before)


_GUARD = threading.Lock()
_BEFORE: list[tuple[int, dict[str, str | None]]] = []
"""For each that opens something now, how things were before the first."""


def _hush() -> tuple[int, dict[str, str | None]]:
    """See ``quiet_and_local``; OpenCV's level of messages and the variables of the environment as they were."""
    before = {name: os.environ.get(name) for name in ("OPENCV_FFMPEG_LOGLEVEL", "OPENCV_FFMPEG_CAPTURE_OPTIONS")}
    level: int = cv2.utils.logging.getLogLevel()
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    os.environ["OPENCV_FFMPEG_CAPTURE_OPTIONS"] = "protocol_whitelist;file,pipe"
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    return level, before


def _put_back(level: int, variables: dict[str, str | None]) -> None:
    cv2.utils.logging.setLogLevel(level)
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def _pixel_aspect(capture: cv2.VideoCapture) -> float:
    """Width over height of a pixel as shown; 1 where the file says nothing sensible."""
    wide, high = capture.get(cv2.CAP_PROP_SAR_NUM), capture.get(cv2.CAP_PROP_SAR_DEN)
    aspect = wide / high if wide > 0 and high > 0 else 1.0
    if not 0.1 < aspect < 10:
        return 1.0
    lying = round(capture.get(cv2.CAP_PROP_ORIENTATION_META)) % 180 == 90  # images come upright, the ratio does not
    return 1 / aspect if lying else aspect
