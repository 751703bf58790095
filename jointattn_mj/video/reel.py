"""A video file written image by image: H.264 in a fragmented mp4, which plays even when it was cut short."""

import os
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any

import cv2
import imageio_ffmpeg
import numpy as np

from jointattn_mj.errors import VideoError

QUALITY = 26
"""Constant rate factor of x264; less is better and larger. 24 adds a sixth to the size, 28 takes a seventh off."""
CHEAP = "cabac=1:aq-mode=1:bframes=3:b-adapt=0:deblock=0,0"
"""What x264's preset ultrafast leaves out and a quick film needs: with it, half the size for a sixth more time."""
FRAGMENTED = ("-movflags", "frag_keyframe+empty_moov+default_base_moof")
"""ffmpeg's arguments for an mp4 that plays even when it was cut short."""
INSTALL = "Install ffmpeg (`apt-get install ffmpeg`, or `pip install imageio-ffmpeg`), or run without the video."


class Reel:
    """Writes RGB images to an mp4: ``with Reel(path, height, width, rate) as reel: reel.add(image)``.

    If the process is killed, all but the last second or two plays, or three of a quick one.
    """

    def __init__(self, path: Path, height: int, width: int, rate: float, quick: bool = False):
        """Prepare a file.

        Args:
            path: The mp4.
            height: Of the images, pixels.
            width: Of the images, pixels.
            rate: Images a second.
            quick: Encode in a third of the time, to a file about twice as large. Sides are even numbers of pixels.
        """
        self._path = path.absolute()  # ffmpeg takes what stands before a colon in a bare name as a protocol
        self._shape, self._rate = (height, width, 3), rate
        self._quick = quick
        self._program: Any = None

    def __enter__(self) -> "Reel":
        """Start ffmpeg.

        Raises:
            VideoError: There is no ffmpeg program, or it does not start.
        """
        height, width, _ = self._shape
        even = height % 2 == width % 2 == 0
        how = (
            f"-preset ultrafast -x264-params {CHEAP} -threads 1 -g {round(2 * self._rate)}" if self._quick
            else f"-preset veryfast -g {max(1, round(self._rate))}"
        )  # fmt: skip
        arguments = (
            f"-v error -f rawvideo -pix_fmt {'yuv420p' if self._quick else 'rgb24'} -s {width}x{height} "
            f"-r {self._rate} -i - -an -vcodec h264 -pix_fmt {'yuv420p' if even else 'yuv444p'} -crf {QUALITY} {how} "
            f"{' '.join(FRAGMENTED)} -flush_packets 1 -y"
        )
        command = [find_ffmpeg(), *arguments.split(), os.fspath(self._path)]
        try:
            with _signals_kept_from_children():
                self._program = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        except OSError as error:
            raise VideoError(f"the video cannot be written to {self._path} ({error}). {INSTALL}") from error
        return self

    def add(self, image: np.ndarray) -> None:
        """Write one image, uint8 (height, width, 3).

        Raises:
            VideoError: It is no such image, or ffmpeg has given up.
        """
        if image.shape != self._shape or image.dtype != np.uint8:
            raise VideoError(f"expected uint8 images {self._shape}, got {image.dtype} {image.shape}")
        try:
            self._program.stdin.write((_planes(image) if self._quick else np.ascontiguousarray(image)).data)
        except OSError as error:
            raise VideoError(self._failure(self._program)) from error

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file; an error that is already under way comes first."""
        program, self._program = self._program, None
        if program is None:
            return
        failure = self._failure(program)
        if program.returncode and error is None:
            raise VideoError(failure)

    def _failure(self, program: Any) -> str:
        """Let ffmpeg end, and say why it failed if it did."""
        with suppress(BrokenPipeError):
            program.stdin.close()
        said = " ".join(program.stderr.read().decode(errors="replace").split())
        code = program.wait()
        return (
            f"ffmpeg stopped writing {self._path} ({said or f'code {code}'}); is the disk full? If this ffmpeg lacks "
            f"H.264, take another one. {INSTALL}"
        )


def _planes(image: np.ndarray) -> np.ndarray:
    """Brightness, then both chromas at half the size: (3 h / 2, w) uint8 of an RGB image (h, w, 3).

    Takes a third of ffmpeg's time for the same, and sends it half as many bytes.
    """
    height, width, _ = image.shape
    planes: np.ndarray = cv2.cvtColor(image, cv2.COLOR_RGB2YUV_I420)  # its chroma is that of every fourth pixel
    half = cv2.cvtColor(cv2.resize(image, (width // 2, height // 2), interpolation=cv2.INTER_AREA), cv2.COLOR_RGB2YCrCb)
    chroma = planes[height:].reshape(2, height // 2, width // 2)
    for plane, channel in zip(chroma, (2, 1), strict=True):
        scale = 224 / 255  # from 16 to 240, as video has it (ITU-R BT.601)
        cv2.convertScaleAbs(cv2.extractChannel(half, channel), dst=plane, alpha=scale, beta=128 * (1 - scale))
    return planes


@contextmanager
def _signals_kept_from_children() -> Iterator[None]:
    """Block Ctrl-C and SIGTERM for programs started here; both often go to all, and the last images would be lost.

    Ours end when there is nothing more to read.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    kept = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, kept)


def find_ffmpeg() -> str:
    """The ffmpeg program: the system's, or where there is none the one that comes with imageio-ffmpeg.

    Raises:
        VideoError: There is neither.
    """
    try:
        return shutil.which("ffmpeg") or os.fspath(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError as error:
        raise VideoError(f"a video needs the program ffmpeg, and none was found. {INSTALL}") from error
