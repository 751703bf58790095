"""What OpenCV does not tell of a file: whether its images are interlaced, a file without them, and when it begins.

A camcorder takes the even and the odd lines of an image one after the other. For such an image OpenCV's ``retrieve``
leaves its buffer as it was and reports success. The program ffmpeg detects them, and fills in every other line.
"""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import imageio_ffmpeg

from jointattn_mj.errors import FootageError

FILTER = "yadif=deint=interlaced"
"""Filter of ffmpeg: one image for each; images that are not interlaced stay as they are."""
WITHOUT_CHARACTER_SETS = {"GCONV_PATH": "/nonexistent"}
"""A static build of ffmpeg, such as 7.0.2 of imageio-ffmpeg 0.7, crashes at every MPEG transport stream, as camcorders
write them, where it loads this system's tables of characters, for the names of channels. Nothing here reads names."""
LATEST_S = 3600.0
"""Latest begin of a video in its file; a later one is a clock of its own."""


def interlaced_images(path: Path, start_s: float, seconds: float) -> bool:
    """Whether any image in a part of a video is interlaced.

    Args:
        path: The file.
        start_s: Begin of the part, s.
        seconds: Its length.

    Raises:
        FootageError: There is no ffmpeg program to ask, or it crashes.
    """
    select = r"select=not(eq(interlace_type\,PROGRESSIVE))"
    part = ["-ss", str(start_s)] if start_s > 0 else []
    command = _command([*part, "-t", str(seconds)], path, select, "-frames:v", "1", "-f", "framecrc", "-")
    with _running(command) as program:
        assert program.stdout is not None
        if any(not line.startswith(b"#") for line in program.stdout):
            return True
        if (code := program.wait()) < 0:
            raise FootageError(
                f"the program ffmpeg crashed at {path} (signal {-code}); name another in the environment variable "
                "IMAGEIO_FFMPEG_EXE"
            )
        return False


def first_image_s(path: Path) -> float:
    """Time of a video's first image after the beginning of the file, s: of its sound, perhaps; 0 if unknown.

    Players and coding programs count time from there.

    Args:
        path: The file.

    Raises:
        FootageError: There is no ffmpeg program to ask.
    """
    sound = ["-map", "0:a?", "-c:a", "copy"]  # ffmpeg counts from the first stream that is asked for
    video = ["-fps_mode", "passthrough", "-frames:v", "1", "-flush_packets", "1", "-f", "framecrc", "-"]
    base = stamp = None
    with _running(_command([], path, "null", *sound, *video)) as program:
        assert program.stdout is not None
        for said in program.stdout:
            line = said.decode("ascii", "replace")
            if line.startswith("#tb 0:"):
                base = line.split(":")[1]
            elif line.startswith("0,"):
                stamp = line.split(",")[2]
                break
    try:
        seconds = float(stamp or 0) * float(Fraction((base or "0").strip()))
    except (ValueError, ZeroDivisionError):
        return 0.0
    return seconds if 0 < seconds < LATEST_S else 0.0


@contextmanager
def deinterlaced(path: Path) -> Iterator[str]:
    """Within the block, a name that ffmpeg opens as the video of the file without interlaced images.

    Raises:
        FootageError: There is no ffmpeg program.
    """
    command = _command([], path, FILTER, "-fps_mode", "passthrough", "-c:v", "rawvideo", "-f", "nut", "-")
    with _running(command) as program:
        assert program.stdout is not None
        yield f"pipe:{program.stdout.fileno()}"


@contextmanager
def _running(command: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program that ends with the block; Ctrl-C does not reach it."""
    try:
        program = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            env=os.environ | WITHOUT_CHARACTER_SETS,
        )
    except OSError as error:
        raise FootageError(f"the program ffmpeg does not start ({error}); pip install imageio-ffmpeg") from error
    with program:
        try:
            yield program
        finally:
            program.kill()


def _command(before: list[str], path: Path, filters: str, *after: str) -> list[str]:
    """Command line of ffmpeg that applies a filter to the images of a file.

    Args:
        before: Arguments before the input.
        path: The input.
        filters: Filter, in ffmpeg's words.
        after: Arguments that say what is written where.
    """
    try:
        program = imageio_ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise FootageError(f"there is no program ffmpeg ({error}); pip install imageio-ffmpeg") from error
    local = ["-v", "error", "-protocol_whitelist", "file,pipe", *before, "-i", os.fspath(path.absolute())]
    return [program, *local, "-map", "0:v:0", "-vf", filters, *after]
