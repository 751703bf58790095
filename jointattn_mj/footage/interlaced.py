"""Interlaced images, which OpenCV cannot convert: are there any in a file, and the file without them.

A camcorder takes the even and the odd lines of an image one after the other. For such an image OpenCV's ``retrieve``
leaves its buffer as it was, and says that all is well. The program ffmpeg knows them, and fills in each other line.
"""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import imageio_ffmpeg

from jointattn_mj.errors import FootageError

FILTER = "yadif=deint=interlaced"
"""One image for each; those that are not interlaced stay as they are."""


def interlaced_images(path: Path, start_s: float, seconds: float) -> bool:
    """Whether any image in ``seconds`` from ``start_s`` on is interlaced.

    Raises:
        FootageError: There is no ffmpeg program to ask.
    """
    select = r"select=not(eq(interlace_type\,PROGRESSIVE))"
    part = ["-ss", str(start_s)] if start_s > 0 else []
    command = _command([*part, "-t", str(seconds)], path, select, "-frames:v", "1", "-f", "framecrc", "-")
    with _running(command) as program:
        assert program.stdout is not None
        return any(not line.startswith(b"#") for line in program.stdout)


@contextmanager
def deinterlaced(path: Path) -> Iterator[str]:
    """The video of a file without interlaced images, as a name that ffmpeg opens while the block runs.

    Raises:
        FootageError: There is no ffmpeg program.
    """
    command = _command([], path, FILTER, "-fps_mode", "passthrough", "-c:v", "rawvideo", "-f", "nut", "-")
    with _running(command) as program:
        assert program.stdout is not None
        yield f"pipe:{program.stdout.fileno()}"


@contextmanager
def _running(command: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """A program that ends with the block, and hears no Ctrl-C."""
    try:
        program = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
        )
    except OSError as error:
        raise FootageError(f"the program ffmpeg does not start ({error}); pip install imageio-ffmpeg") from error
    with program:
        try:
            yield program
        finally:
            program.kill()


def _command(before: list[str], path: Path, filters: str, *after: str) -> list[str]:
    """The command line of ffmpeg that sends the images of a file through a filter."""
    try:
        program = imageio_ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise FootageError(f"there is no program ffmpeg ({error}); pip install imageio-ffmpeg") from error
    local = ["-v", "error", "-protocol_whitelist", "file,pipe", *before, "-i", os.fspath(path.absolute())]
    return [program, *local, "-map", "0:v:0", "-vf", filters, *after]
