"""Videos of all kinds for ``perceive``: odd ones that it must read, others that it must refuse, and damaged ones."""

import os
import random
import re
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import imageio_ffmpeg

from tools.reliability.inputs.damage import damaged, write
from tools.reliability.malformed import Input, anything, refused
from tools.shell import Outcome

KIND, DAMAGED = "odd videos", "damaged videos"
SECONDS = 1.0
"""Length of the video from which all others are made."""
ROUNDED = 0.25
"""Seconds by which the length of a video of a few images may differ: of an image, and of the clocks of containers."""
H264 = ("-c:v", "libx264", "-pix_fmt", "yuv420p")
WHOLE_EVERY = 10
"""One video of so many goes through the whole command, with tables and figures; the others are iterated over."""
WATCH = """
import sys
from jointattn_mj import perceive
from jointattn_mj.errors import JointAttnError
try:
    frames = sum(1 for _ in perceive({path!r}, max_minutes=0.1))
except JointAttnError as error:
    print(f"{{type(error).__name__}}: {{' '.join(str(error).split())}}", file=sys.stderr)  # as the command does
    sys.exit(2)
print(f"{{frames / 30:.1f}} s watched")
"""
ODD: dict[str, tuple[tuple[str, ...], float]] = {
    # file: ffmpeg's arguments for its output, and the seconds of video that are in it
    "avi mpeg4.avi": (("-c:v", "mpeg4"), SECONDS),
    "mjpeg.avi": (("-c:v", "mjpeg", "-pix_fmt", "yuvj420p"), SECONDS),
    "vp8.webm": (("-c:v", "libvpx", "-deadline", "realtime"), SECONDS),
    "mpeg2.ts": (("-c:v", "mpeg2video"), SECONDS),
    "mpeg1.mpg": (("-c:v", "mpeg1video"), SECONDS),
    "flv.flv": (("-c:v", "flv"), SECONDS),
    "wmv.wmv": (("-c:v", "wmv2"), SECONDS),
    "prores 10 bits.mov": (("-c:v", "prores_ks"), SECONDS),
    "h264 10 bits.mp4": (("-c:v", "libx264", "-pix_fmt", "yuv420p10le"), SECONDS),
    "h264 444.mp4": (("-c:v", "libx264", "-pix_fmt", "yuv444p"), SECONDS),
    "grey.mp4": (("-c:v", "libx264", "-pix_fmt", "gray"), SECONDS),
    "alpha.mov": (("-c:v", "qtrle", "-pix_fmt", "argb"), SECONDS),
    "raw.avi": (("-c:v", "rawvideo", "-pix_fmt", "bgr24"), SECONDS),
    "raw.nut": (("-c:v", "rawvideo"), SECONDS),
    "raw stream.h264": ((*H264, "-f", "h264"), SECONDS),
    "animated.gif": (("-vf", "fps=10"), SECONDS),
    "animated.webp": (("-c:v", "libwebp", "-vf", "fps=10"), SECONDS),
    "animated.png": (("-f", "apng", "-vf", "fps=10"), SECONDS),
    "one image.mp4": ((*H264, "-frames:v", "1"), 1 / 30),
    "two images.mp4": ((*H264, "-frames:v", "2"), 2 / 30),
    "odd size.mkv": (("-vf", "scale=321:241", "-c:v", "ffv1"), SECONDS),
    "odd size.mp4": (("-vf", "scale=163:77", "-c:v", "libx264", "-pix_fmt", "yuv444p"), SECONDS),
    "tiny.mkv": (("-vf", "scale=2:2", "-c:v", "ffv1"), SECONDS),
    "one pixel.mkv": (("-vf", "scale=1:1", "-c:v", "ffv1", "-pix_fmt", "bgr0"), SECONDS),
    "one row.mkv": (("-vf", "scale=320:1", "-c:v", "ffv1", "-pix_fmt", "bgr0"), SECONDS),
    "one column.avi": (("-vf", "scale=1:240", "-c:v", "rawvideo", "-pix_fmt", "bgr24"), SECONDS),
    "wide.mp4": ((*H264, "-vf", "scale=3840:64", "-frames:v", "6"), 0.2),
    "large.mp4": ((*H264, "-vf", "scale=4096:3072", "-frames:v", "3"), 0.1),
    "pixels not square.mp4": ((*H264, "-vf", "setsar=2/1"), SECONDS),
    "pixels absurd.mkv": (("-c:v", "ffv1", "-vf", "setsar=1000/1"), SECONDS),
    "rate 5.mp4": ((*H264, "-vf", "fps=5"), SECONDS),  # with -r 5, ffmpeg writes seven images
    "rate 59.94.mp4": ((*H264, "-r", "60000/1001"), SECONDS),
    "rate 240.mp4": ((*H264, "-r", "240"), SECONDS),
    "rate varies.mkv": ((*H264, "-vf", "setpts='N*(1+mod(N,5))/90/TB'", "-fps_mode", "vfr"), 1.5),
    "interlaced top.mp4": ((*H264, "-flags", "+ildct+ilme", "-x264-params", "tff=1"), SECONDS),
    "interlaced bottom.ts": (("-c:v", "mpeg2video", "-flags", "+ildct+ilme", "-field_order", "bb"), SECONDS),
    "late begin.mkv": ((*H264, "-output_ts_offset", "7"), SECONDS),
    "early begin.mkv": ((*H264, "-output_ts_offset", "-0.5"), SECONDS),
    "in pieces.mp4": ((*H264, "-movflags", "frag_keyframe+empty_moov"), SECONDS),
    "key images alone.mp4": ((*H264, "-g", "1"), SECONDS),
    "a:colon.mp4": (H264, SECONDS),
    "file:scheme.mp4": (H264, SECONDS),
    "two words  .mp4": (H264, SECONDS),
    "-dash.mp4": (H264, SECONDS),
    "-i.mp4": (H264, SECONDS),
    "%05d.mp4": (H264, SECONDS),
    "a'quote\".mp4": (H264, SECONDS),
    "a\nline.mp4": (H264, SECONDS),
    "a\\b.mp4": (H264, SECONDS),
    "Über ñ 視頻 🎥.mp4": (H264, SECONDS),
    "no suffix": ((*H264, "-f", "mp4"), SECONDS),
    "wrong suffix.txt": ((*H264, "-f", "mp4"), SECONDS),
    "wrong suffix.jpg": ((*H264, "-f", "mp4"), SECONDS),
    "wrong suffix.avi": ((*H264, "-f", "matroska"), SECONDS),
    "wrong suffix.mp4": (("-c:v", "mpeg4", "-f", "avi"), SECONDS),
    "MP4.MP4": ((*H264, "-f", "mp4"), SECONDS),
    f"{'long' * 60}.mp4": (H264, SECONDS),
}
WITH_SOUND: dict[str, tuple[tuple[str, ...], float]] = {
    "with sound.mp4": ((*H264, "-c:a", "aac"), SECONDS),
    "sound before.mkv": ((*H264, "-c:a", "aac"), SECONDS),
}
UNREADABLE = ("animated.webp",)
"""Of which the decoders here may not be capable."""
NOT_VIDEOS = ("sound.m4a", "sound.mp3", "sound.wav")
ROTATIONS = (90, 180, 270)


@dataclass(frozen=True)
class Video:
    """A file, and what should come of it."""

    kind: str
    what: str
    path: str
    result: Callable[[Outcome], str]
    needed: bool = False

    def given(self, whole: Path | None) -> Input:
        """As an input: to the command, which leaves its results in ``whole``, or to be iterated over."""
        command = ("perceive", self.path, "--no-overlay", "--max-minutes", "0.1", "--out", str(whole))
        if whole is not None:
            return Input(self.kind, self.what, command, result=self.result, needed=self.needed)
        source = WATCH.format(path=self.path)
        return Input(self.kind, self.what, source=source, result=self.result, needed=self.needed)


def inputs(chance: random.Random, many: int, folder: Path, film: Path) -> Iterator[Input]:
    """Videos for ``perceive``, odd ones first.

    Args:
        chance: Of the damage.
        many: How many.
        folder: Where they are made.
        film: A video of ``SECONDS``.
    """
    made = [*_odd(folder, film), *_no_videos(folder, film)]
    sources = [Path(video.path) for video in made if video.needed and Path(video.path).stat().st_size < 1 << 20]
    for number in range(max(0, many - len(made))):
        source = chance.choice(sources)
        what, raw = damaged(source.read_bytes(), chance)
        path = write(folder / f"damaged{number}" / source.name, raw)
        made.append(Video(DAMAGED, f"{source.name}, {what}", str(path), anything))
    for number, video in enumerate(made[:many]):
        yield video.given(None if number % WHOLE_EVERY else folder / "out" / str(number))


def watched(seconds: float) -> Callable[[Outcome], str]:
    """A result will do if so many seconds were watched."""

    def wrong(outcome: Outcome) -> str:
        found = re.search(r"(\d+\.\d) s watched", outcome.out)
        if found is None:
            return f"does not say how much was watched: {outcome.out[-200:]}"
        return "" if abs(float(found[1]) - seconds) <= ROUNDED else f"{found[0]}, and {seconds:.2f} s are there"

    return wrong


def _odd(folder: Path, film: Path) -> Iterator[Video]:
    """Videos that must be read, each in a folder of its own."""
    sound = ("-f", "lavfi", "-t", "1", "-i", "sine")
    for number, (name, (arguments, seconds)) in enumerate((ODD | WITH_SOUND).items()):
        path = folder / f"odd{number}" / name
        path.parent.mkdir(parents=True)
        late = ("-itsoffset", "0.4") if name.startswith("sound before") else ()
        _ffmpeg(
            *late,
            "-i",
            str(film),
            *(sound if name in WITH_SOUND else ()),
            *arguments,
            *_form(path, arguments),
            path=path,
        )
        yield Video(KIND, name, str(path), watched(seconds), needed=name not in UNREADABLE)
    for degrees in ROTATIONS:
        path = folder / f"turned{degrees}" / "turned.mp4"
        path.parent.mkdir()
        _ffmpeg("-display_rotation", str(degrees), "-i", str(film), "-c", "copy", path=path)
        yield Video(KIND, f"turned by {degrees}", str(path), watched(SECONDS), needed=True)
    link = folder / "link" / "link.mp4"
    link.parent.mkdir()
    link.symlink_to(film)
    yield Video(KIND, "a link", str(link), watched(SECONDS), needed=True)


def _form(path: Path, arguments: tuple[str, ...]) -> tuple[str, ...]:
    """Argument for the container, where nothing else says it; ffmpeg takes some names for patterns."""
    forms = {".mkv": "matroska", ".ts": "mpegts", ".mpg": "mpeg", ".wmv": "asf", ".MP4": "mp4"}
    return () if "-f" in arguments else ("-f", forms.get(path.suffix, path.suffix[1:]))


def _no_videos(folder: Path, film: Path) -> Iterator[Video]:
    """What is no video, or has no image; and images, which may be taken for short videos."""
    place = folder / "none"
    place.mkdir()
    for name in NOT_VIDEOS:
        _ffmpeg("-f", "lavfi", "-i", "sine", "-t", "1", path=place / name)
        yield Video(KIND, name, str(place / name), refused)
    for name in ("still.png", "still.jpg", "still.bmp", "still.tiff"):
        _ffmpeg("-i", str(film), "-frames:v", "1", path=place / name)
        yield Video(KIND, name, str(place / name), watched(1 / 30))
    _ffmpeg("-i", str(film), "-frames:v", "0", *H264, "-movflags", "+empty_moov", path=place / "no image.mp4")
    os.mkfifo(place / "fifo.mp4")
    (place / "folder.mp4").mkdir()
    (place / "broken link.mp4").symlink_to(place / "nowhere.mp4")
    (place / "circle.mp4").symlink_to(place / "circle.mp4")
    raw = film.read_bytes()
    write(place / "no index.mp4", raw[: raw.rindex(b"moov") - 4])
    header = raw.index(b"avc1", raw.index(b"stsd")) + 28
    write(place / "says huge.mp4", raw[:header] + b"\xff\xff\xff\xff" + raw[header + 4 :])
    write(place / "script.mp4", b"#!/bin/sh\necho no\n")
    write(place / "zeros.mp4", bytes(100_000))
    write(place / "subtitles.srt", b"1\n00:00:00,000 --> 00:00:01,000\nno\n")
    write(place / "page.html", b"<html><video src='film.mp4'></video></html>")
    write(place / "huge.ppm", b"P6 60000 60000 255\n" + bytes(1000))
    write(place / "huge.y4m", b"YUV4MPEG2 W65000 H65000 F30:1\nFRAME\n" + bytes(1000))
    named = [name for name in sorted(os.listdir(place)) if name not in NOT_VIDEOS and "still" not in name]
    for name in named:
        yield Video(KIND, name, str(place / name), anything if name == "says huge.mp4" else refused)
    for name in (
        "/dev/null",
        "/dev/zero",
        "/proc/self/mem",
        "",
        "http://127.0.0.1:9/a.mp4",
        "concat:a|b",
        "pipe:0",
        "-",
    ):
        yield Video(KIND, f"named {name!r}", name, refused)


def _ffmpeg(*arguments: str, path: Path) -> None:
    program = imageio_ffmpeg.get_ffmpeg_exe()
    subprocess.run(
        [program, "-v", "error", "-y", *arguments, os.path.join(".", path.name)], cwd=path.parent, check=True
    )
