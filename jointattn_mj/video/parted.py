"""A video in parts, each from one checkpoint of a run to the next: a killed run goes on after the last whole part.

A part's name has the number of the frame with which it begins.
"""

import os
import shutil
import subprocess
from pathlib import Path
from types import TracebackType

import imageio_ffmpeg
import numpy as np

from jointattn_mj.errors import OutputError, VideoError
from jointattn_mj.io.files import write_whole
from jointattn_mj.video.reel import FRAGMENTED, Reel


class PartedReel:
    """Writes RGB images to parts in a folder: ``with PartedReel(...) as reel: reel.add(image, frame)``."""

    def __init__(self, folder: Path, height: int, width: int, rate: float, frame: int):
        """Keep the parts that begin before ``frame``, and delete later ones.

        Args:
            folder: Where the parts are; made when missing.
            height: Of the images, pixels.
            width: Of the images, pixels.
            rate: Images a second.
            frame: The run's next frame, as its last checkpoint says.

        Raises:
            OutputError: The folder cannot be used.
        """
        self._folder, self._shape = folder, (height, width, rate)
        self._reel: Reel | None = None
        try:
            folder.mkdir(exist_ok=True)
            for part in self._parts():
                if part >= self._path(frame):
                    part.unlink()
        except OSError as error:
            raise OutputError(f"cannot write to {folder}: {error.strerror}; choose another folder") from error

    def add(self, image: np.ndarray, frame: int) -> None:
        """Write the image of a frame, uint8 (height, width, 3).

        Raises:
            VideoError: There is no ffmpeg program, or it has given up.
        """
        if self._reel is None:
            self._reel = Reel(self._path(frame), *self._shape).__enter__()
        self._reel.add(image)

    def cut(self) -> None:
        """Finish a part; the next image begins another.

        Raises:
            VideoError: ffmpeg has given up.
        """
        self._end(None, None, None)

    def join(self, path: Path) -> None:
        """Write all finished parts as one video; the parts stay.

        Raises:
            OutputError: The file cannot be written.
            VideoError: ffmpeg cannot read a part.
        """
        parts = self._parts()
        if len(parts) == 1:
            write_whole(path, lambda temporary: shutil.copyfile(parts[0], temporary))
        else:
            write_whole(path, lambda temporary: _concatenate(parts, temporary))

    def _parts(self) -> list[Path]:
        return sorted(self._folder.glob("video_*.mp4"))

    def _path(self, frame: int) -> Path:
        return self._folder / f"video_{frame:012d}.mp4"

    def _end(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        reel, self._reel = self._reel, None
        if reel is not None:
            reel.__exit__(kind, error, traceback)

    def __enter__(self) -> "PartedReel":
        return self

    __exit__ = _end


def _concatenate(parts: list[Path], path: Path) -> None:
    """Write one video of several, without encoding anything again."""
    names = parts[0].with_name("parts.txt")
    names.write_text("".join(f"file '{part.name}'\n" for part in parts))
    arguments = f"-v error -y -f concat -i LIST -c copy {' '.join(FRAGMENTED)} OUT".split()
    paths = {"LIST": os.fspath(names.absolute()), "OUT": os.fspath(path)}
    command = [imageio_ffmpeg.get_ffmpeg_exe(), *(paths.get(word, word) for word in arguments)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, start_new_session=True)
    if done.returncode != 0:
        said = " ".join(done.stderr.decode(errors="replace").split())
        raise VideoError(f"ffmpeg cannot put {path} together ({said}); is the disk full?")
