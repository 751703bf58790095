"""Encoder of single images to H.264, one unit of the stream an image, for logs that store them one by one."""

import os
import subprocess
import threading
from typing import NamedTuple

import imageio_ffmpeg
import numpy as np

from jointattn_mj.errors import VideoError

QUALITY = 26
"""Constant rate factor of x264."""
_DELIMITER = b"\x00\x00\x00\x01\x09"  # access unit delimiter (ITU-T H.264, 7.4.1.2.3): begins every image
_PARAMETERS = b"\x00\x00\x00\x01\x67"  # sequence parameter set: comes with key images


class Unit(NamedTuple):
    """One encoded image (Annex B of H.264)."""

    sample: bytes
    key: bool  # whether decoding can begin here


def can_encode() -> bool:
    """Whether there is an ffmpeg program with an H.264 encoder."""
    try:
        asked = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-encoders"]
        return b" libx264 " in subprocess.run(asked, capture_output=True, stdin=subprocess.DEVNULL).stdout
    except (OSError, RuntimeError):
        return False


class VideoEncoder:
    """Takes RGB images, uint8 (height, width, 3), and returns units in the same order, a few images later.

    Sizes are even. No image refers to a later one, and every second has a key image, to which a viewer can jump.
    """

    def __init__(self, height: int, width: int, rate: float):
        """Start ffmpeg.

        Args:
            height: Of the images, pixels.
            width: Of the images, pixels.
            rate: Images a second.

        Raises:
            VideoError: ffmpeg does not start.
        """
        arguments = (
            f"-hide_banner -loglevel error -f rawvideo -pixel_format rgb24 -video_size {width}x{height} "
            f"-framerate {rate:g} -i - -an -c:v libx264 -preset veryfast -tune zerolatency -crf {QUALITY} "
            f"-g {max(1, round(rate))} -threads 1 -pix_fmt yuv420p -x264-params aud=1:repeat-headers=1 "
            "-flush_packets 1 -f h264 -"
        )
        self._shape = (height, width, 3)
        try:
            self._program = subprocess.Popen(
                [imageio_ffmpeg.get_ffmpeg_exe(), *arguments.split()],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                start_new_session=True,  # a terminal's Ctrl-C is not for it: the last images would go
            )
        except (OSError, RuntimeError) as error:
            raise VideoError(f"ffmpeg does not start ({error}); install it with `apt-get install ffmpeg`") from error
        self._units: list[Unit] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def add(self, image: np.ndarray) -> None:
        """Encode one more image.

        Raises:
            VideoError: ffmpeg has given up.
        """
        if image.shape != self._shape or image.dtype != np.uint8:
            raise VideoError(f"expected uint8 images {self._shape}, came {image.dtype} {image.shape}")
        assert self._program.stdin is not None
        try:
            self._program.stdin.write(np.ascontiguousarray(image).data)
        except OSError as error:
            raise VideoError(f"ffmpeg stopped encoding ({error})") from error

    def take(self) -> list[Unit]:
        """The units that are ready and were not returned before, in the order of their images."""
        count = len(self._units)
        taken, self._units[:count] = self._units[:count], []
        return taken

    def finish(self) -> list[Unit]:
        """End the stream, and return the units that are left.

        Raises:
            VideoError: ffmpeg ended with an error.
        """
        assert self._program.stdin is not None
        try:
            self._program.stdin.close()
        except OSError as error:
            raise VideoError(f"ffmpeg stopped encoding ({error})") from error
        finally:
            code = self._program.wait()
            self._reader.join()
        if code != 0:
            raise VideoError(f"ffmpeg ended with code {code}")
        return self.take()

    def _read(self) -> None:
        """Cut the stream into units; runs in a thread until the stream ends."""
        assert self._program.stdout is not None
        kept = b""
        while piece := os.read(self._program.stdout.fileno(), 1 << 16):
            kept += piece
            while (end := kept.find(_DELIMITER, 1)) > 0:
                self._hand_out(kept[:end])
                kept = kept[end:]
        if kept:
            self._hand_out(kept)
        self._program.stdout.close()

    def _hand_out(self, sample: bytes) -> None:
        self._units.append(Unit(sample, _PARAMETERS in sample[:64]))
