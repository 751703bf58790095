"""``jointattn perceive``: what is found in clips of a known truth, whatever was done to them, and what comes out."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from clips import DETECTOR, Clip, counted, encode
from shell import Outcome, refused

from jointattn_mj.errors import CheckpointError
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.overlay import HEIGHT, WIDTH
from jointattn_mj.footage.run import run_perceive
from jointattn_mj.footage.summary import summarise
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.perception.som import SOMConfig
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")
FRAMES = 120
NAMES = ("red", "yellow", "blue", "green", "face")


@pytest.fixture(scope="module")
def clip() -> Clip:
    """Somebody else than the caregiver with whom everything was tuned."""
    return Clip.rendered("amara", FRAMES, seed=3)


def config_of(video: Path, **options) -> PerceiveConfig:
    options = {"objects": NAMES[:-1], "detector": DETECTOR, **options}
    return PerceiveConfig(video, som=SOMConfig(updates=200), **options)


def perceive(video: Path, **options) -> tuple[dict, dict[str, np.ndarray]]:
    """The summary, and the columns of the percepts, without tables and figures."""
    viewing = Viewing(config_of(video, **options))
    viewing.prepare()
    fresh, px, moves = [], [], []
    for still in viewing.footage:
        viewing.see(still)
        fresh.append(still.fresh)
        px.append(viewing.watcher.percept.px.copy())
        moves.append(viewing.watcher.percept.moves.copy())
    columns = {"fresh": np.array(fresh)}
    for k, name in enumerate(NAMES):
        columns |= {f"{name}_x_px": np.array(px)[:, k, 0], f"{name}_y_px": np.array(px)[:, k, 1]}
        columns[f"{name}_moves"] = np.array(moves)[:, k]
    return summarise(viewing, False, 0.0, None), columns


def off(found: dict[str, np.ndarray], name: str, locations: np.ndarray) -> np.ndarray:
    """How far off a candidate was seen, (n, 2) px of the robot's image; the face less ``below``."""
    wrong = np.stack([found[f"{name}_x_px"], found[f"{name}_y_px"]], axis=1) - locations
    return wrong - below(found, locations) if name == "face" else wrong


def below(found: dict[str, np.ndarray], locations: np.ndarray) -> np.ndarray:
    """Where the face was seen from the centre of the head, (2,) px, in the median: a few pixels below it, since a
    face is centred between brow and chin."""
    return np.nanmedian(np.stack([found["face_x_px"], found["face_y_px"]], axis=1) - locations, axis=0)


def rates(found: dict[str, np.ndarray], moving: np.ndarray) -> tuple[float, float, float, float]:
    """Hits and false alarms of motion: face, then objects."""
    said = np.column_stack([found[f"{name}_moves"] for name in NAMES]).astype(bool)
    face, objects = (said[:, 4], moving[:, 4]), (said[:, :4], moving[:, :4])
    return tuple(float(flags[really == want].mean()) for flags, really in (face, objects) for want in (True, False))


FINDS = ("--detector", DETECTOR)


def face_height(out: Path, frame: int) -> float:
    """Height of the face in a frame, smoothed as the program does, about: the median of those before it."""
    table = pq.read_table(out / "people.parquet")
    before = np.abs(table["frame"].to_numpy() - frame) < 15
    return float(np.median(table["height_px"].to_numpy()[before]))


NOISE = np.random.default_rng(5).normal(0, 1, (FRAMES, 240, 320, 3)).astype(np.float32)
CASES = {
    # what is done to the clip: noise (grey values), ffmpeg's arguments, file; then most error of objects, px, and most
    # false alarms of the face's motion
    "lossless": (0, ("-c:v", "ffv1"), "a.mkv", 0.8, 0.08),
    "noise": (6, ("-c:v", "ffv1"), "a.mkv", 0.8, 0.2),
    "mpeg4": (2, ("-c:v", "mpeg4", "-q:v", "8"), "a.avi", 0.9, 0.12),
    "large": (3, ("-vf", "scale=640:480", "-c:v", "libx264", "-crf", "26"), "a.mp4", 0.8, 0.08),
    "odd": (0, ("-vf", "scale=515:387", "-pix_fmt", "yuv444p", "-c:v", "libx264"), "a.mp4", 1.0, 0.08),
}


@needs_gl
@pytest.mark.parametrize("case", CASES)
def test_found_where_it_is(clip, tmp_path, case):
    noise, arguments, name, object_px, alarms = CASES[case]
    images = np.clip(clip.images + noise * NOISE, 0, 255).astype(np.uint8) if noise else clip.images
    summary, found = perceive(encode(tmp_path / name, images, *arguments))
    assert summary["frames"] == FRAMES
    assert summary["notes"] == []
    assert summary["detected"]["face"] >= 0.97
    assert min(summary["detected"].values()) >= 0.97
    aside, down = below(found, clip.locations[:, 4])
    assert abs(aside) < 1 and 4 < down < 9
    assert np.sqrt(np.nanmean(off(found, "face", clip.locations[:, 4]) ** 2)) < 2  # it nods
    for number, label in enumerate(NAMES[:-1]):
        wrong = np.linalg.norm(off(found, label, clip.locations[:, number]), axis=1)
        assert np.nanmedian(wrong) < object_px, label
    face_hits, face_alarms, object_hits, object_alarms = rates(found, clip.moving)
    assert face_hits > 0.9
    assert face_alarms < alarms
    assert object_hits > 0.6
    assert object_alarms < 0.04


@needs_gl
def test_a_face_too_large_makes_the_image_smaller(clip, tmp_path):
    """A camera twice as near: the middle of the clip, enlarged."""
    near = np.array([cv2.resize(image[30:150, 80:240], (640, 480)) for image in clip.images[:90]])
    video = encode(tmp_path / "a.mp4", near, "-c:v", "libx264")
    summary, found = perceive(video, detector="templates")
    assert 0.2 < summary["mapping"]["scale_x"] < 0.33  # rather than a half
    assert 110 < summary["mapping"]["cascade_face_side_in_video_px"] < 170
    assert summary["detected"]["face"] > 0.95
    mapping = summary["mapping"]
    truth = (clip.locations[:90, 4] - (80, 30) + 0.5) * 4 - 0.5
    truth = (truth + 0.5) * (mapping["scale_x"], mapping["scale_y"]) - 0.5 + (mapping["left"], mapping["top"])
    assert np.sqrt(np.nanmean(off(found, "face", truth) ** 2)) < 1.5
    given, _ = perceive(video, scale=0.5, detector="templates")
    assert given["mapping"]["scale_x"] == 0.5


@needs_gl
def test_somebody_who_sways_is_followed(clip, tmp_path):
    """Twenty pixels to either side, as people at tables do and the caregiver does not."""
    shifts = 20 * np.sin(np.arange(FRAMES) / 30 * 2 * np.pi / 5)
    moved = [
        cv2.warpAffine(image, np.float32([[1, 0, x], [0, 1, 0]]), (320, 240), borderMode=cv2.BORDER_REPLICATE)
        for image, x in zip(clip.images, shifts, strict=True)
    ]
    _, found = perceive(encode(tmp_path / "a.mkv", np.array(moved)))
    locations = clip.locations[:, 4] + np.column_stack([shifts, np.zeros(FRAMES)])
    assert np.nanpercentile(np.abs(off(found, "face", locations)[:, 0]), 95) < 4  # down it goes when the head nods


@needs_gl
def test_a_slower_video(clip, tmp_path):
    """Ten images a second: every one is perceived once, and holds for three frames."""
    summary, found = perceive(encode(tmp_path / "a.mp4", clip.images[::3], "-c:v", "libx264", rate="10"))
    assert summary["frames"] == FRAMES
    assert found["fresh"].sum() == FRAMES // 3
    assert any("fewer than 15" in note for note in summary["notes"])
    wrong = np.linalg.norm(off(found, "green", clip.locations[:, 3]), axis=1)
    assert np.nanmedian(wrong) < 1.5
    for start in range(0, FRAMES, 3):
        assert len(set(found["green_x_px"][start : start + 3])) == 1


@needs_gl
def test_grey(clip, tmp_path):
    """No colour, no objects, and it says why; the face is there."""
    video = encode(tmp_path / "a.mp4", clip.images, "-pix_fmt", "gray", "-c:v", "libx264")
    summary, _ = perceive(video)
    assert [summary["detected"][name] for name in NAMES[:-1]] == [0] * 4
    assert summary["detected"]["face"] > 0.95
    assert len(summary["notes"]) == 1 and "grey" in summary["notes"][0]
    assert summary["by_candidate"]["face"]["fixations"] == summary["fixations"] == 1


@needs_gl
def test_files(jointattn, clip, tmp_path):
    """Whole command line: everything is there, fits together, and can be looked at."""
    video, out = encode(tmp_path / "a.mp4", clip.images, "-c:v", "libx264"), tmp_path / "out"
    outcome = jointattn(
        "perceive", video, "--out", out, "--objects", "red", "sun=#ebd300", "blue", "green", "--seed", 2, *FINDS
    )
    assert (outcome.code, outcome.err) == (0, "")
    assert "sun 100%" in outcome.out and str(out) in outcome.out
    assert {path.name for path in out.iterdir()} == {
        "config.yaml", "summary.json", "percepts.parquet", "fixations.parquet", "fixations.png", "faces.parquet",
        "som.png", "overlay.mp4", "checkpoint.bin", "events.csv", "checks.csv",
        *(("people.parquet",) if DETECTOR == "yunet" else ()),
    }  # fmt: skip
    assert yaml.safe_load((out / "config.yaml").read_text())["config"]["seed"] == 2
    summary = json.loads((out / "summary.json").read_text())
    assert summary["complete"] and summary["frames"] == FRAMES
    percepts, fixations = (pq.read_table(out / f"{name}.parquet") for name in ("percepts", "fixations"))
    assert percepts.num_rows == FRAMES
    assert fixations.num_rows == summary["fixations"] >= 2
    attended = percepts["attended"].to_pylist()
    for row in fixations.to_pylist():
        first, last = round(row["start_s"] * 30), round(row["end_s"] * 30)
        assert set(attended[first:last]) == {row["candidate"]}
        assert row["video_x_px"] == pytest.approx(row["x_px"], abs=1e-6)
    faces = pq.read_table(out / "faces.parquet")
    assert faces.num_rows == summary["face_patterns"] == FRAMES // 3
    shown = cv2.VideoCapture(str(out / "overlay.mp4"))
    assert (shown.get(cv2.CAP_PROP_FRAME_WIDTH), shown.get(cv2.CAP_PROP_FRAME_HEIGHT)) == (WIDTH, HEIGHT)
    images = [shown.read()[1] for _ in range(FRAMES)]
    assert all(image is not None for image in images) and not shown.read()[0]
    row = fixations.to_pylist()[0]
    middle = round((row["start_s"] + row["end_s"]) * 15)
    x, y = (round(2 * percepts[f"{row['candidate']}_{axis}_px"][middle].as_py()) for axis in "xy")
    radius = 39  # the white ring around what is attended
    if row["candidate"] == "face":
        radius = 48 if DETECTOR == "templates" else round(3 * 0.55 * face_height(out, middle))
    ring = images[middle][44 + y - radius - 3 : 44 + y - radius + 4, 16 + x]
    assert ring.min(axis=1).max() > 180
    for name in ("fixations.png", "som.png"):
        assert cv2.imread(str(out / name)).std() > 20
    again = jointattn("perceive", video, "--out", out, *FINDS)
    refused(again, 2, "already holds a run", "--resume")


@needs_gl
def test_the_same_again(clip, tmp_path):
    video = encode(tmp_path / "a.mkv", clip.images[:45])
    for name in ("one", "two"):
        run_perceive(config_of(video, seed=4), PerceiveOptions(tmp_path / name, overlay=False))
    for name in ("percepts.parquet", "fixations.parquet", "faces.parquet", "fixations.png", "som.png"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes(), name


def test_what_cannot_be_perceived(jointattn, tmp_path):
    """Refused in one line, and the folder stays free."""
    (tmp_path / "notes.mp4").write_text("no video")
    out = tmp_path / "out"
    refused(jointattn("perceive", tmp_path / "notes.mp4", "--out", out, *FINDS), 2, "notes.mp4", "no video")
    refused(jointattn("perceive", tmp_path / "missing.mp4", "--out", out, *FINDS), 2, "missing.mp4", "does not exist")
    video = encode(tmp_path / "a.mp4", counted(10), "-c:v", "libx264")
    refused(jointattn("perceive", video, "--out", out, "--objects", "mauve"), 2, "mauve")
    refused(jointattn("perceive", video, "--out", out, "--fps", 0), 2, "fps")
    refused(jointattn("perceive", video), 2, "--out")
    nowhere = {"PATH": str(tmp_path), "IMAGEIO_FFMPEG_EXE": str(tmp_path / "ffmpeg")}
    refused(jointattn("perceive", video, "--out", out, *FINDS, env=nowhere), 1, "ffmpeg")
    assert not out.exists()
    full = jointattn("perceive", video, "--out", out, "--no-overlay", *FINDS, file_limit=3000)
    refused(full, 2, str(out), "free space")


def test_nothing_to_see(tmp_path):
    """No face, no known colour: all the files but those of faces, and notes that say so."""
    video = encode(tmp_path / "a.mp4", counted(45), "-c:v", "libx264")
    summary = run_perceive(config_of(video), PerceiveOptions(tmp_path / "out", overlay=False))
    assert summary["detected"] == dict.fromkeys(NAMES, 0)
    assert summary["fixations"] == 0
    percepts = pq.read_table(tmp_path / "out" / "percepts.parquet")
    assert percepts["attended"].to_pylist() == [None] * 45
    assert any("no face" in note for note in summary["notes"])
    assert not (tmp_path / "out" / "som.png").exists()
    assert (tmp_path / "out" / "fixations.png").stat().st_size > 5000


def test_only_the_first_minutes(tmp_path):
    video = encode(tmp_path / "a.mp4", counted(60), "-c:v", "libx264")
    out = PerceiveOptions(tmp_path / "out", overlay=False)
    summary = run_perceive(config_of(video, max_minutes=1 / 60), out)
    assert (summary["frames"], summary["complete"]) == (30, False)
    assert pq.read_table(tmp_path / "out" / "percepts.parquet").num_rows == 30
    assert not any("cut off" in note for note in summary["notes"])
    assert perceive(video, max_minutes=1)[0]["complete"]


def long_video(tmp_path: Path) -> Path:
    return encode(tmp_path / "a.mkv", np.concatenate([counted(60)] * 60))


def started(video: Path, out: Path, *options: str) -> subprocess.Popen:
    """``jointattn perceive`` in a process group of its own, which has begun to watch."""
    arguments = ["--out", str(out), "--scale", "1", "--som.updates", "10", *FINDS, *options]
    process = subprocess.Popen(
        [sys.executable, "-m", "jointattn_mj.cli.main", "perceive", str(video), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    part = out / "log" / "video_000000000000.mp4"
    while not part.exists() or part.stat().st_size < 3000:
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    return process


def shown_frames(path: Path) -> int:
    shown = cv2.VideoCapture(str(path))
    return sum(iter(shown.grab, False))


def test_stopped_from_outside(tmp_path):
    """What was watched is there, whole, and the rest is not missing anywhere; it can be gone on with."""
    video, out = long_video(tmp_path), tmp_path / "out"
    with started(video, out) as process:
        os.killpg(process.pid, signal.SIGINT)
        said, err = process.communicate(timeout=60)
    refused(Outcome(process.returncode, said, err), 130, "stopped", str(out), "--resume")
    summary = json.loads((out / "summary.json").read_text())
    assert not summary["complete"] and "stopped after" in summary["notes"][0]
    frames = pq.read_table(out / "percepts.parquet").num_rows
    assert 0 < frames == summary["frames"] < 3600
    assert not [path for path in out.iterdir() if path.name.startswith(".")]
    assert shown_frames(out / "overlay.mp4") == frames
    options = PerceiveOptions(out, resume=True, overlay=False)
    with pytest.raises(CheckpointError, match="`overlay_every=1`"):
        run_perceive(PerceiveConfig(video, scale=1, som=SOMConfig(updates=10), detector=DETECTOR), options)


KILLED = """
import os, signal, sys
from jointattn_mj.cli import main as cli
from jointattn_mj.footage import viewing
at, see = int(sys.argv[1]), viewing.Viewing.see
def killing(self, still):
    if self.frames == at:
        os.kill(os.getpid(), signal.SIGKILL)
    return see(self, still)
viewing.Viewing.see = killing
cli.main(sys.argv[2:])
"""
"""``jointattn``, but it is killed before it sees a frame."""
FILES = (
    "config.yaml", "percepts.parquet", "fixations.parquet", "faces.parquet", "fixations.png", "som.png", "events.csv",
    "looks.parquet",
)  # fmt: skip


@needs_gl
def test_killed_and_resumed(jointattn, clip, tmp_path):
    """Killed twice, before and after a checkpoint: the same bytes as of a viewing that nothing disturbs."""
    video = encode(tmp_path / "a.mp4", clip.images, "-c:v", "libx264")
    options = [
        "perceive",
        str(video),
        *FINDS,
        "--looks",
        "--no-page",
        "--seed",
        "3",
        "--som.updates",
        "200",
        "--checkpoint-minutes",
        str(40 / 1800),
    ]
    straight, out = tmp_path / "straight", tmp_path / "on"
    assert jointattn(*options, "--out", straight).code == 0
    for at, more in ((20, ()), (70, ("--resume",))):
        killed = subprocess.run([sys.executable, "-c", KILLED, str(at), *options, "--out", str(out), *more])
        assert killed.returncode == -signal.SIGKILL
        assert not (out / "summary.json").exists()
    refused(jointattn(*options, "--out", out), 2, "already holds a run", "--resume")
    outcome = jointattn(*options, "--out", out, "--resume")
    assert (outcome.code, outcome.err) == (0, "")
    assert {path.name for path in out.iterdir()} == {path.name for path in straight.iterdir()}
    for name in FILES:
        assert (out / name).read_bytes() == (straight / name).read_bytes(), name
    summaries = [json.loads((folder / "summary.json").read_text()) for folder in (straight, out)]
    assert summaries[0] | {"wall_seconds": 0} == summaries[1] | {"wall_seconds": 0}
    films = [cv2.VideoCapture(str(folder / "overlay.mp4")) for folder in (straight, out)]
    for _ in range(FRAMES):
        first, second = (film.read()[1] for film in films)
        np.testing.assert_array_equal(first, second)
    assert not films[0].read()[0] and not films[1].read()[0]
    again = jointattn(*options, "--out", out, "--resume")  # its results once more
    assert (again.code, again.err) == (0, "")
    assert json.loads((out / "summary.json").read_text()) == summaries[1]


def test_another_video_under_the_same_name(tmp_path):
    video, out = encode(tmp_path / "a.mkv", counted(60)), tmp_path / "out"
    config = PerceiveConfig(video, scale=1, detector=DETECTOR)

    def stop(viewing) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_perceive(config, PerceiveOptions(out, overlay=False), stop)
    encode(video, counted(64))
    with pytest.raises(CheckpointError, match=r"a\.mkv had \d+ bytes"):
        run_perceive(config, PerceiveOptions(out, overlay=False, resume=True))


def interlaced(path: Path, images: np.ndarray) -> Path:
    """As a camcorder writes it."""
    return encode(path, images, "-c:v", "libx264", "-flags", "+ildct+ilme", "-x264-params", "tff=1")


@needs_gl
def test_interlaced(clip, tmp_path):
    """Found where it is, as in the same images progressive; and it says what was done."""
    summary, found = perceive(interlaced(tmp_path / "a.mp4", clip.images))
    assert summary["frames"] == FRAMES
    assert len(summary["notes"]) == 1 and "interlaced" in summary["notes"][0]
    assert min(summary["detected"].values()) >= 0.97
    assert np.sqrt(np.nanmean(off(found, "face", clip.locations[:, 4]) ** 2)) < 2
    for number, label in enumerate(NAMES[:-1]):
        wrong = np.linalg.norm(off(found, label, clip.locations[:, number]), axis=1)
        assert np.nanmedian(wrong) < 1.5, label
