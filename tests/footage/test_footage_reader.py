"""Video files as thirty images a second: rates, timestamps, damage, and what is no video at all."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from clips import counted, encode, number_of

from jointattn_mj.errors import FootageError
from jointattn_mj.footage import reader
from jointattn_mj.footage.reader import LONGEST_HOLD_S, Footage

pytestmark = pytest.mark.integration


def shown(footage: Footage) -> list[int]:
    """What the frames show, by what is in the images; numbers and marks agree with it."""
    stills = list(footage)
    numbers = [number_of(still.image) for still in stills]
    fresh = [True, *(now != before for now, before in zip(numbers[1:], numbers, strict=False))]
    assert [still.fresh for still in stills] == fresh
    assert stills[0].cut
    return numbers


@pytest.mark.parametrize("name", ["a.mp4", "a.mkv", "a.avi", "a.webm", "a.ts", "a.gif", "a.mov"])
def test_thirty_a_second(tmp_path, name):
    """Every image once, though containers round their timestamps to a millisecond or a hundredth."""
    codecs = {".avi": ("-c:v", "mjpeg"), ".ts": ("-c:v", "mpeg2video"), ".gif": (), ".webm": ("-c:v", "libvpx")}
    arguments = codecs.get(name[1:], ("-c:v", "libx264"))
    footage = Footage(encode(tmp_path / name, counted(40), *(arguments or ("-f", "gif"))))
    assert shown(footage) == list(range(40))
    assert (footage.images, footage.timed, footage.jumps) == (40, True, 0)
    assert shown(footage) == list(range(40))  # and again


@pytest.mark.parametrize(
    ("rate", "expected"),
    [
        ("60", list(range(0, 60, 2))),
        ("15", [k // 2 for k in range(60)]),
        ("10", [k // 3 for k in range(90)]),
        ("30000/1001", list(range(40))),
    ],
)
def test_other_rates(tmp_path, rate, expected):
    frames = {"60": 60, "15": 30, "10": 30, "30000/1001": 40}[rate]
    assert shown(Footage(encode(tmp_path / "a.mp4", counted(frames), "-c:v", "libx264", rate=rate))) == expected


def test_25_a_second(tmp_path):
    """Five images in six frames, for two seconds."""
    numbers = shown(Footage(encode(tmp_path / "a.mp4", counted(50), "-c:v", "libx264", rate="25")))
    assert len(numbers) == 60
    assert np.unique(numbers).tolist() == list(range(50))
    assert np.abs(np.array(numbers) - np.arange(60) * 25 / 30).max() <= 1


@pytest.mark.parametrize("name", ["a.mp4", "a.mkv"])
def test_variable_rate(tmp_path, name):
    """Some images left out, as recorders of screens do: the others hold until the next one was taken."""
    kept = "select='not(mod(n,3))+not(mod(n,7))'"
    path = encode(tmp_path / name, counted(43), "-vf", kept, "-fps_mode", "vfr", "-c:v", "libx264")
    there = [n for n in range(43) if n % 3 == 0 or n % 7 == 0]
    assert shown(Footage(path))[:43] == [max(n for n in there if n <= frame) for frame in range(43)]


@pytest.mark.parametrize("name", ["a.mp4", "a.webm", "a.ts"])
def test_a_gap_in_a_variable_rate(tmp_path, name):
    """As browsers leave it where the page was hidden: the file says how long it is, so the last image holds."""
    codec = ("-c:v", "libvpx", "-deadline", "realtime") if name == "a.webm" else ("-c:v", "libx264")
    gap = ("-vf", f"setpts='PTS+gte(N,20)*{LONGEST_HOLD_S + 2}/TB'", "-fps_mode", "vfr")
    footage = Footage(encode(tmp_path / name, counted(40), *gap, *codec))
    stills = list(footage)
    after = 20 + round(30 * (LONGEST_HOLD_S + 2))
    numbers = [number_of(still.image) for still in stills]
    assert numbers[: after + 19] == [*range(20), *[19] * (after - 20), *range(20, 39)]
    assert [frame for frame, still in enumerate(stills) if still.cut] == [0, after]
    assert footage.jumps == 0


def test_odd_sizes_and_pixels_that_are_not_square(tmp_path):
    path = encode(tmp_path / "a.mp4", counted(5, 63, 47), "-vf", "setsar=4/3", "-pix_fmt", "yuv444p")
    footage = Footage(path)
    assert next(iter(footage)).image.shape == (47, 63, 3)
    assert footage.aspect == pytest.approx(4 / 3)


def test_no_timestamps(tmp_path):
    path = encode(tmp_path / "a.h264", counted(20), "-c:v", "libx264")
    footage = Footage(path)
    assert len(shown(footage)) == 24  # the container's 25 a second
    assert not footage.timed
    assert shown(Footage(path, fps=30)) == list(range(20))


def test_a_rate_of_ones_own(tmp_path):
    path = encode(tmp_path / "a.mp4", counted(20), "-c:v", "libx264")
    assert shown(Footage(path, fps=60)) == list(range(0, 20, 2))


class Capture:
    """Stands for OpenCV's: images with the timestamps that it is given, ms."""

    def __init__(self, stamps: list[float], fps: float = 30, broken: tuple[int, ...] = ()):
        self.stamps, self.fps, self.broken, self.at = stamps, fps, broken, -1

    def grab(self) -> bool:
        self.at += 1
        return self.at < len(self.stamps)

    def retrieve(self):
        return (False, None) if self.at in self.broken else (True, counted(64)[self.at])

    def get(self, what: int) -> float:
        stamp = self.stamps[self.at] if self.at >= 0 else 0
        return {reader.cv2.CAP_PROP_POS_MSEC: stamp, reader.cv2.CAP_PROP_FPS: self.fps}.get(what, 0)

    def release(self) -> None:
        pass


def footage_of(monkeypatch, tmp_path, capture) -> Footage:
    monkeypatch.setattr(Footage, "_open", lambda self: type(capture)(capture.stamps, capture.fps, capture.broken))
    return Footage(tmp_path / "any.mp4")


def test_timestamps_that_go_back(monkeypatch, tmp_path):
    """Time never does."""
    footage = footage_of(monkeypatch, tmp_path, Capture([33, 0, 67, 100, 133]))
    numbers = shown(footage)
    assert numbers == sorted(numbers)
    assert footage.seconds == pytest.approx(0.1)


@pytest.mark.parametrize("leap", [1000 * LONGEST_HOLD_S + 100, 9.5e7, -9.5e7])
def test_timestamps_that_jump(monkeypatch, tmp_path, leap):
    """A day in between, or the clock of a transport stream that starts anew: left out, and no motion across it."""
    stamps = [1000 / 30 * k + (leap if k >= 5 else 0) for k in range(10)]
    footage = footage_of(monkeypatch, tmp_path, Capture(stamps))
    stills = list(footage)
    assert [number_of(still.image) for still in stills] == list(range(10))
    assert [still.cut for still in stills] == [k in (0, 5) for k in range(10)]
    assert footage.jumps == 1


def test_images_that_cannot_be_decoded(monkeypatch, tmp_path):
    """The one before holds."""
    numbers = shown(footage_of(monkeypatch, tmp_path, Capture([1000 / 30 * k for k in range(8)], broken=(3, 4))))
    assert numbers == [0, 1, 2, 2, 2, 5, 6, 7]
    with pytest.raises(FootageError, match="no image that can be decoded"):
        list(footage_of(monkeypatch, tmp_path, Capture([0, 33], broken=(0, 1))))
    with pytest.raises(FootageError, match="no image that can be decoded"):
        list(footage_of(monkeypatch, tmp_path, Capture([])))


@pytest.mark.parametrize("fps", [0, float("nan"), -1, 90_000])
def test_neither_timestamps_nor_a_rate(monkeypatch, tmp_path, fps):
    with pytest.raises(FootageError, match="`fps`"):
        list(footage_of(monkeypatch, tmp_path, Capture([0, 0, 0], fps=fps)))
    numbers = shown(footage_of(monkeypatch, tmp_path, Capture([0, 33, 67], fps=fps)))  # timestamps are enough
    assert numbers == [0, 1, 2]


def test_the_unit_of_a_clock_is_no_rate(monkeypatch, tmp_path):
    """A Matroska file of irregular images declares 1000 a second; the last one is shown for a frame."""
    footage = footage_of(monkeypatch, tmp_path, Capture([0, 97, 225], fps=1000))
    assert footage.fps == 0
    assert shown(footage) == [0, 0, 0, 1, 1, 1, 1, 2]


def no_videos(folder: Path) -> list[str]:
    """Names of what is no video that can be read; all of it is in the folder, but what is missing."""
    video = encode(folder / "whole.mp4", counted(30), "-c:v", "libx264").read_bytes()
    contents = {
        "empty.mp4": b"", "text.mp4": b"hello\n" * 100, "notes.txt": b"hello\n" * 100, "noise.avi": os.urandom(9000),
        "cut.mp4": video[: len(video) // 2],
    }  # fmt: skip
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    (folder / "folder.mp4").mkdir()
    os.mkfifo(folder / "pipe.mp4")
    return [*contents, "folder.mp4", "pipe.mp4", "missing.mp4", "http://localhost/a.mp4"]


def test_no_video(tmp_path):
    """Named, with the file, in one line."""
    for name in no_videos(tmp_path):
        with pytest.raises(FootageError, match=name.split("/")[-1]) as error:
            Footage(tmp_path / name)
        assert "\n" not in str(error.value)


REFUSED = """
import sys
from pathlib import Path
import numpy as np
from jointattn_mj.errors import FootageError
from jointattn_mj.footage.reader import Footage
from jointattn_mj.footage.sessions.camera import CameraSource
from jointattn_mj.footage.sessions.config import CameraSessionConfig
from jointattn_mj.footage.sessions.latency import CameraCount
from jointattn_mj.video.reel import Reel
first, folder, *names = sys.argv[1:]
if first == "film":
    with Reel(Path(folder, "film.mp4"), 48, 64, 10) as reel:
        reel.add(np.zeros((48, 64, 3), np.uint8))
    list(Footage(Path(folder, "film.mp4")))
if first == "camera":
    try:
        CameraSource(CameraSessionConfig(camera="99"), CameraCount())
    except FootageError:
        print("refused")
for name in names:
    try:
        Footage(Path(folder, name))
    except FootageError:
        print("refused")
"""


@pytest.mark.parametrize("first", ["nothing", "film", "camera"])
def test_nothing_else_is_said(tmp_path, first):
    """On stderr, whatever this package did before; in a process of its own, whose ffmpeg no test has set."""
    names = no_videos(tmp_path)
    command = [sys.executable, "-c", REFUSED, first, str(tmp_path), *names]
    process = subprocess.run(command, check=True, capture_output=True, text=True)
    assert process.stdout.count("refused") == len(names) + (first == "camera")
    assert process.stderr == ""


def test_cut_off(tmp_path):
    """A Matroska file plays up to where it ends."""
    whole = encode(tmp_path / "whole.mkv", np.random.default_rng(0).integers(0, 255, (60, 48, 64, 3), np.uint8))
    (tmp_path / "cut.mkv").write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    footage = Footage(tmp_path / "cut.mkv")
    assert 20 <= len(list(footage)) <= 40
    assert footage.declared_s == pytest.approx(2)


def test_environment_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.delenv("OPENCV_FFMPEG_LOGLEVEL", raising=False)
    monkeypatch.setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", "mine")
    Footage(encode(tmp_path / "a.mp4", counted(3), "-c:v", "libx264"))
    assert "OPENCV_FFMPEG_LOGLEVEL" not in os.environ
    assert os.environ["OPENCV_FFMPEG_CAPTURE_OPTIONS"] == "mine"


@pytest.mark.parametrize("name", ["12:30:05.mp4", "a:b.mp4", "file:a.mp4", "-x.mp4", "%d.mp4"])
def test_names(tmp_path, monkeypatch, name):
    """In the working directory, where ffmpeg would take what stands before a colon as a protocol."""
    encode(tmp_path / name, counted(9), "-c:v", "libx264")
    monkeypatch.chdir(tmp_path)
    assert shown(Footage(Path(name))) == list(range(9))


def test_a_name_that_is_not_utf8(tmp_path):
    """OpenCV dies of it."""
    path = tmp_path / os.fsdecode(b"a\xff.mp4")
    path.write_bytes(b"anything")
    with pytest.raises(FootageError, match="is not UTF-8"):
        Footage(path)


def interlaced(path: Path, images: np.ndarray, *arguments: str) -> Path:
    """As a camcorder writes it."""
    codec = ("mpeg2video", "-q:v", "2") if path.suffix == ".mpg" else ("libx264", "-x264-params", "tff=1")
    return encode(path, images, "-c:v", *codec, "-flags", "+ildct+ilme", *arguments)


@pytest.mark.parametrize("name", ["a.mp4", "a.mpg"])
def test_interlaced(tmp_path, name):
    """Every image once, with its contents; again when it is read again, and with nothing left open."""
    footage = Footage(interlaced(tmp_path / name, counted(40)))
    assert footage.interlaced
    before = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0
    for _ in range(2):
        numbers = [number_of(still.image) for still in footage]
        np.testing.assert_allclose(numbers, range(40), atol=1)
    assert next(iter(footage)).image.shape == (48, 64, 3)
    assert (len(os.listdir("/proc/self/fd")) if before else 0) == before
    assert not Footage(encode(tmp_path / "b.mp4", counted(5), "-c:v", "libx264")).interlaced


@pytest.mark.parametrize("offset", ["5.4667", "0", "90000"])
def test_interlaced_from_somewhere_on(tmp_path, offset):
    """What OpenCV leaves out in silence is noticed; images that really are the same are not."""
    still = np.tile(counted(20)[-1:], (100, 1, 1, 1))
    first = encode(tmp_path / "first.ts", np.concatenate([counted(64), still]), "-c:v", "libx264")
    assert not Footage(first).interlaced
    assert len(list(Footage(first))) == 164
    second = interlaced(tmp_path / "second.ts", counted(60), "-output_ts_offset", offset)
    (tmp_path / "both.ts").write_bytes(first.read_bytes() + second.read_bytes())
    footage = Footage(tmp_path / "both.ts")
    assert not footage.interlaced
    with pytest.raises(FootageError, match=r"interlaced from about .* -vf yadif"):
        list(footage)


def test_an_ffmpeg_that_crashes(tmp_path, monkeypatch):
    path = encode(tmp_path / "a.mp4", counted(5), "-c:v", "libx264")
    crashing = tmp_path / "ffmpeg"
    crashing.write_text("#!/bin/sh\nkill -SEGV $$\n")
    crashing.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(crashing))
    with pytest.raises(FootageError, match=r"crashed at .* IMAGEIO_FFMPEG_EXE"):
        Footage(path)


def test_no_ffmpeg_to_ask(tmp_path, monkeypatch):
    path = encode(tmp_path / "a.mp4", counted(5), "-c:v", "libx264")
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(tmp_path / "nowhere"))
    with pytest.raises(FootageError, match="ffmpeg"):
        Footage(path)


def test_threads_that_open_something_at_once_leave_all_as_it_was(monkeypatch):
    def surroundings():
        names = ("OPENCV_FFMPEG_LOGLEVEL", "OPENCV_FFMPEG_CAPTURE_OPTIONS")
        return [os.environ.get(name) for name in names], reader.cv2.utils.logging.getLogLevel()

    monkeypatch.delenv("OPENCV_FFMPEG_LOGLEVEL", raising=False)
    monkeypatch.setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", "threads;1")
    before, (first, second) = surroundings(), (reader.quiet_and_local() for _ in range(2))
    first.__enter__()
    quiet = surroundings()
    second.__enter__()
    first.__exit__(None, None, None)
    assert surroundings() == quiet != before
    second.__exit__(None, None, None)
    assert surroundings() == before
