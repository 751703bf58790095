"""A video file written image by image: H.264 in a fragmented mp4, which plays even when it was cut short.

mediapy is imported where a file is begun: it brings matplotlib's windows and, where it is installed, IPython.
"""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType

import cv2
import imageio_ffmpeg
import numpy as np

from jointattn_mj.errors import VideoError
from jointattn_mj.guards.border import require_array

QUALITY = 26
"""Constant rate factor of x264; less is better and larger. 24 adds a sixth to the size, 28 takes a seventh off."""
CHEAP = "cabac=1:aq-mode=1:bframes=3:b-adapt=0:deblock=0,0"
"""What x264's preset ultrafast leaves out and a quick film needs: with it, half the size for a sixth more time."""
PLANES = (
    "split=3[all][left][right];[all]crop=iw:ih*2/3:0:0[y];[left]crop=iw/2:ih/3:0:ih*2/3[u];"
    "[right]crop=iw/2:ih/3:iw/2:ih*2/3[v];[y][u][v]mergeplanes=map1s=1:map2s=2:format=yuv420p"
)
"""ffmpeg's filter for an image of brightness (h, w) above two of colour (h/2, w/2) side by side."""
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
            quick: Encode in less than half of the time, to a file a fifth larger.

        Raises:
            VideoError: A quick film's height is no multiple of 4, or its width is odd.
        """
        import mediapy

        if quick and (height % 4 or width % 2):
            raise VideoError(
                f"a quick film's height must be a multiple of 4, and its width even; got {height} times {width} pixels"
            )
        how = (
            f"-vf {PLANES} -preset ultrafast -x264-params {CHEAP} -threads 1 -g {round(2 * rate)}" if quick
            else f"-preset veryfast -g {max(1, round(rate))}"
        )  # fmt: skip
        arguments = f"{how} {' '.join(FRAGMENTED)} -flush_packets 1"
        path = path.absolute()  # ffmpeg takes what stands before a colon in a bare name as a protocol
        self._planes = np.empty((height + height // 2, width), np.uint8) if quick else None
        self._writer = mediapy.VideoWriter(
            path, (height, width) if self._planes is None else self._planes.shape, fps=rate, crf=QUALITY,
            ffmpeg_args=arguments, input_format="gray" if quick else "rgb",
        )  # fmt: skip

    def __enter__(self) -> "Reel":
        """Start ffmpeg.

        Raises:
            VideoError: There is no ffmpeg program, or it does not start.
        """
        find_ffmpeg()
        try:
            with _signals_kept_from_children():
                self._writer.__enter__()
        except (OSError, RuntimeError) as error:
            raise VideoError(f"the video cannot be written to {self._writer.path} ({error}). {INSTALL}") from error
        return self

    def add(self, image: np.ndarray) -> None:
        """Write one image, uint8 (height, width, 3).

        Raises:
            ObservationError: A quick film is given something else.
            VideoError: ffmpeg has given up.
        """
        if self._planes is not None:
            rows, width = self._planes.shape
            require_array("image", image, (rows * 2 // 3, width, 3), "u")
            _split(image, self._planes)
            image = self._planes
        try:
            self._writer.add_image(image)
        except (OSError, RuntimeError) as error:
            raise VideoError(self._failure(error)) from error

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file; an error that is already under way comes first."""
        try:
            self._writer.close()
        except (OSError, RuntimeError) as trouble:
            if error is None:
                raise VideoError(self._failure(trouble)) from trouble

    def _failure(self, error: Exception) -> str:
        return (
            f"ffmpeg stopped writing {self._writer.path} ({error}); is the disk full? If this ffmpeg lacks H.264, "
            f"take another one. {INSTALL}"
        )


def _split(image: np.ndarray, planes: np.ndarray) -> None:
    """Write an image (h, w, 3) to ``planes`` (3h/2, w), as the filter ``PLANES`` takes it.

    OpenCV does that in a fifth of the time that ffmpeg takes for it, and half as much goes through the pipe.
    """
    height, width = image.shape[:2]
    together = cv2.cvtColor(image, cv2.COLOR_RGB2YUV_I420)
    planes[:height] = together[:height]
    u, v = together[height:].reshape(2, height // 2, width // 2)
    planes[height:, : width // 2], planes[height:, width // 2 :] = u, v


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


def find_ffmpeg() -> None:
    """Let mediapy use the system's ffmpeg, or where there is none the one that comes with imageio-ffmpeg.

    Raises:
        VideoError: There is neither.
    """
    import mediapy

    if mediapy.video_is_available():
        return
    with suppress(RuntimeError):
        mediapy.set_ffmpeg(os.fspath(imageio_ffmpeg.get_ffmpeg_exe()))
    if not mediapy.video_is_available():
        raise VideoError(f"a video needs the program ffmpeg, and none was found. {INSTALL}")
