"""A camera as the world of a session: the newest image every thirtieth of a second, by the clock of this machine.

A thread reads the camera all the time, so that an image never waits in a queue. A machine that falls behind leaves out
images, not time: the frames for which it was late show the last image again, and are counted.
"""

import os
import re
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.colours import sought_objects
from jointattn_mj.footage.picked import colours_at, require_apart
from jointattn_mj.footage.reader import RATE, Footage, check_utf8, quiet_and_local
from jointattn_mj.footage.sessions.config import CameraSessionConfig
from jointattn_mj.footage.sessions.latency import CameraCount
from jointattn_mj.footage.sessions.session import FootageSessionRun
from jointattn_mj.footage.sessions.source import WideFrame
from jointattn_mj.footage.sessions.summary import CameraTimes

FIRST_S, GONE_S = 10.0, 5.0
"""Seconds to wait for the first image of a camera, and for the next one."""
PAUSED_S = 1.0
"""Delay above which time is not made up for: somebody has paused, or the machine has slept."""


class CameraSource:
    """Reads a camera, or plays a video file as if it were one."""

    def __init__(self, config: CameraSessionConfig, count: CameraCount):
        """Open the camera, and wait for its first image.

        Args:
            config: Which camera.
            count: Counts images, of earlier cameras of the session too, whose clock goes on; it is changed.

        Raises:
            FootageError: There is no such camera, or it gives no image.
        """
        self.aspect = 1.0
        self._name, self._count = config.camera, count
        self._new = threading.Condition()
        self._image: np.ndarray | None = None
        self._number, self._taken_s, self._fresh = count.images - 1, 0.0, False
        self._ended, self._closed = False, False
        self._lost = count.images_lost  # when a frame was taken last
        self._open_s = count.seconds  # of the cameras before this one
        self._images = self._of_file(Path(config.camera)) if _is_file(config.camera) else self._of_device(config)
        self._shown = -1
        self._due_s: float = 0.0
        self._kept_s: float = 0.0
        self._opened_s = time.monotonic()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        with self._new:
            self._new.wait_for(lambda: self._image is not None or self._ended, FIRST_S)
        if self._image is None:
            self.close()
            raise FootageError(f"camera {self._name} gives no image; does another program use it?")
        self._due_s = time.monotonic()
        self._kept: np.ndarray = self._image
        self._kept_s = self._taken_s

    def next(self) -> WideFrame | None:
        """The wide image of the next frame, when it is due; None when a file is over.

        Raises:
            FootageError: The camera gives no more images.
        """
        cut = self._shown < 0  # nobody knows for how long there was no camera
        self._due_s += 1 / RATE
        now = time.monotonic()
        if now - self._due_s > PAUSED_S:
            self._due_s, cut = now, True
            with self._new:
                self._count.images_lost = self._lost  # nobody was to look at those meanwhile
        late = now > self._due_s + 1 / RATE
        if not late:
            time.sleep(max(0.0, self._due_s - now))
        with self._new:
            if self._ended and not self._fresh:
                return None
            if time.monotonic() - self._taken_s > GONE_S:
                raise FootageError(f"camera {self._name} has given no image for {GONE_S:g} s; was it unplugged?")
            if late and self._shown >= 0:
                self._count.frames_lost += 1
            else:
                assert self._image is not None
                self._kept, self._shown, self._fresh = self._image, self._number, False
                self._kept_s = self._taken_s
            self._lost = self._count.images_lost
            seconds = self._open_s + self._kept_s - self._opened_s
            return WideFrame(self._kept, self._shown, seconds, cut, self._kept_s)

    def close(self) -> None:
        """Stop reading, and let go of the camera."""
        if not self._closed:
            self._closed = True
            self._thread.join(2.0)

    def _read(self) -> None:
        """Take up images as they come; runs in a thread of its own."""
        for image in self._images:
            taken = time.monotonic()
            with self._new:
                self._count.images += 1
                self._count.seconds = self._open_s + taken - self._opened_s
                self._count.images_lost += self._fresh
                self._image, self._number, self._taken_s, self._fresh = image, self._number + 1, taken, True
                self._new.notify_all()
            if self._closed:
                break
        with self._new:
            self._ended = True
            self._new.notify_all()

    def _of_device(self, config: CameraSessionConfig) -> Iterator[np.ndarray]:
        """Images of a device.

        Raises:
            FootageError: It cannot be opened.
        """
        name = config.camera
        check_utf8(name)
        given: int | str = int(name) if re.fullmatch(r"\d{1,3}", name) else name
        with quiet_and_local():
            capture = cv2.VideoCapture(given) if isinstance(given, int) else cv2.VideoCapture(given, cv2.CAP_V4L2)
        if not capture.isOpened():
            raise FootageError(f"camera {name} cannot be opened; {_there()}")
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, config.size[0])
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, config.size[1])
        capture.set(cv2.CAP_PROP_FPS, RATE)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)

        def images() -> Iterator[np.ndarray]:
            try:
                while not self._closed:
                    there, image = capture.read()
                    if not there:
                        return
                    yield image
            finally:
                capture.release()

        return images()

    def _of_file(self, path: Path) -> Iterator[np.ndarray]:
        """Images of a file at the times at which they were taken."""
        footage = Footage(path)
        self.aspect = footage.aspect

        def images() -> Iterator[np.ndarray]:
            began_s: float = time.monotonic()
            for frame, still in enumerate(footage):
                if not still.fresh:
                    continue
                time.sleep(max(0.0, began_s + frame / RATE - time.monotonic()))
                yield still.image

        return images()


class CameraSessionRun(FootageSessionRun):
    """A session with a person who is there."""

    config: CameraSessionConfig

    def __init__(self, config: CameraSessionConfig):
        """Prepare; for errors see ``FootageSessionRun``. The camera is opened when its first image is needed."""
        self.count = CameraCount()
        super().__init__(config)

    def source_name(self) -> str:
        """See ``FootageSessionRun``."""
        return f"camera {self.config.camera}"

    def open_source(self, frames: int) -> CameraSource:
        """See ``FootageSessionRun``."""
        return CameraSource(self.config, self.count)

    def camera_times(self) -> CameraTimes:
        """See ``FootageSessionRun``."""
        latency, seconds = self.perceiver.latency, self.count.seconds
        return CameraTimes(
            images=self.count.images,
            images_a_second=self.count.images / seconds if seconds > 0 else None,
            images_lost=self.count.images_lost,
            frames_lost=self.count.frames_lost,
            latency_median_ms=latency.quantile(0.5),
            latency_percentile_95_ms=latency.quantile(0.95),
        )

    def picked(self) -> dict[str, np.ndarray]:
        """See ``FootageSessionRun``: objects are picked in the image at their time after the camera was opened."""
        waiting = sorted(
            (wanted.picked[0], wanted.name, wanted) for wanted in sought_objects(self.config.objects) if wanted.picked
        )
        tables = {}
        for seconds, name, wanted in waiting:
            while self.wide.wide_frame.time_s < seconds and not self.wide.ended:
                self.wide.step(np.zeros(2))
            if self.wide.wide_frame.time_s < seconds:
                raise FootageError(f"object {name} was picked at {seconds:g} s, and the camera's images end before")
            tables[name] = colours_at(self.wide.wide_frame.image, wanted)
        require_apart(tables)
        return tables


def _is_file(name: str) -> bool:
    """Whether a camera's name is that of a video file rather than a device."""
    return not re.fullmatch(r"\d{1,3}", name) and not name.startswith("/dev/")


def _there() -> str:
    """Which cameras there seem to be."""
    names = sorted(name.removeprefix("video") for name in os.listdir("/dev") if re.fullmatch(r"video\d+", name))
    if names:
        return f"this machine has {', '.join(names)}; some of a camera's devices give no images"
    return "this machine has none (/dev/video* is missing); a video file can stand in for one"
