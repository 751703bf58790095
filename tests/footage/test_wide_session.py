"""Sessions before a recorded or present person: ``session --world video`` and ``--world camera``."""

import json
import subprocess
import threading
import time
from dataclasses import replace
from pathlib import Path
from urllib.request import Request, urlopen

import cv2
import imageio_ffmpeg
import numpy as np
import pyarrow.parquet as pq
import pytest
from clips import DETECTOR, encode
from shell import refused

from experiments.recorded.table_video import FOV_DEG, HEIGHT, TILT_DEG, WIDTH, WideEyedWorld
from jointattn_mj import SessionResult
from jointattn_mj.errors import FootageError
from jointattn_mj.footage.sessions import session as sessions
from jointattn_mj.footage.sessions.camera import PAUSED_S, CameraSource
from jointattn_mj.footage.sessions.config import CameraSessionConfig, VideoSessionConfig
from jointattn_mj.footage.sessions.latency import CameraCount
from jointattn_mj.footage.sessions.lens import HeadConfig, Lens
from jointattn_mj.footage.sessions.run import run_footage_session
from jointattn_mj.footage.sessions.source import WideFrame
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.perception.som import SOMConfig
from jointattn_mj.scene import gl
from jointattn_mj.scene.world import World, WorldConfig
from jointattn_mj.viewing.live import LiveView

pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with"),
]
FRAMES, LEARNED = 150, 15
INKS = {"red": (219, 10, 10), "blue": (21, 48, 219)}
HEAD = HeadConfig(fov_deg=FOV_DEG, mount_deg=TILT_DEG)
ROBOT = RobotConfig(familiarise=FamiliariseConfig(minutes=LEARNED / 1800), som=SOMConfig(updates=20))


@pytest.fixture(scope="module")
def wide() -> np.ndarray:
    """The wide image of a rendered person, (320, 440, 3) RGB, without objects."""
    world = WideEyedWorld.build(WorldConfig(), np.random.SeedSequence(3))
    eye = world.wide_eye()
    world.hold()
    world._object_positions[:] = (0, 0, -1)
    world.step(np.radians([0, TILT_DEG]))
    world._object_positions[:] = (0, 0, -1)
    image = cv2.resize(eye.render(), None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    world.close()
    return image


def moments(wide: np.ndarray, frames: int) -> np.ndarray:
    """Images (n, h, w, 3) RGB in which a red thing moves to and fro, and a blue one lies still."""
    images = np.repeat(wide[None], frames, axis=0)
    for number, image in enumerate(images):
        x = 190 + round(6 * np.sin(number / 4)) if number % 60 < 30 else 190
        cv2.rectangle(image, (x, 176), (x + 8, 184), INKS["red"], -1)
        cv2.rectangle(image, (260, 177), (268, 185), INKS["blue"], -1)
    return images


@pytest.fixture(scope="module")
def table(wide, tmp_path_factory) -> Path:
    """A folder with a video and its coding."""
    folder = tmp_path_factory.mktemp("table")
    encode(folder / "table.mp4", moments(wide, FRAMES), "-c:v", "libx264", "-preset", "ultrafast", "-crf", "20")
    (folder / "coding.csv").write_text("onset_s,offset_s,tier,code\n0,3,looks at,red\n3,20,looks at,blue\n")
    return folder


def config(table: Path, **more) -> VideoSessionConfig:
    return VideoSessionConfig(
        objects=("red", "blue"), detector="templates", head=HEAD, robot=ROBOT, video_file=table / "table.mp4", **more
    )


def tables(out: Path) -> dict[str, bytes]:
    return {name: (out / name).read_bytes() for name in ("frames.parquet", "gaze_shifts.parquet", "weights.npz")}


@pytest.fixture(scope="module")
def whole(table, tmp_path_factory):
    """A session at the video, with its folder and summary."""
    out = tmp_path_factory.mktemp("whole") / "out"
    return out, run_footage_session(config(table, coding=table / "coding.csv"), out)


def test_a_session_at_a_video(whole):
    out, summary = whole
    assert summary.frames == FRAMES - LEARNED
    assert min(summary.detected.values()) > 0.95
    assert summary.gaze_shifts > 0
    assert summary.gaze_shifts_judged == summary.gaze_shifts
    assert summary.success == "coding coding.csv"
    assert summary.camera is None
    frames = pq.read_table(out / "frames.parquet")
    np.testing.assert_allclose(frames["time_s"].to_numpy(), np.arange(LEARNED, FRAMES) / 30, atol=1e-6)
    assert frames["target"].to_pylist()[0] == "red" and frames["target"].to_pylist()[-1] == "blue"
    shifts = pq.read_table(out / "gaze_shifts.parquet").to_pylist()
    judged = [row for row in shifts if row["face_to_object"]]
    assert all(row["success"] == (row["nearest"] == "red") for row in judged if row["landing_s"] < 3)
    assert {path.name for path in out.glob("*.png")} == {"som.png", "success.png"}


def test_a_session_at_a_video_opens_as_a_result(table, whole, tmp_path):
    out, summary = whole
    result = SessionResult.open(out)
    assert result.config == config(table, coding=table / "coding.csv")
    assert result.summary == summary
    assert len(result.frames) == summary.frames and len(result.shifts) == summary.gaze_shifts_of_all_kinds
    result.save(tmp_path / "copy")
    assert SessionResult.open(tmp_path / "copy") == result
    assert {path.name for path in (tmp_path / "copy").glob("*.png")} == {"som.png", "success.png"}


def test_a_session_that_was_stopped_goes_on_to_the_same_result(table, whole, tmp_path):
    asked = config(table, coding=table / "coding.csv")

    def stop(session):
        raise RuntimeError("killed")

    with pytest.raises(RuntimeError, match="killed"):
        run_footage_session(asked, tmp_path / "out", checkpoint_minutes=1 / 60, progress=stop)
    summary = run_footage_session(asked, tmp_path / "out", resume=True)
    assert summary == whole[1]
    assert tables(tmp_path / "out") == tables(whole[0])


def test_a_session_that_was_killed_after_its_last_frame_leaves_its_results(table, whole, tmp_path, monkeypatch):
    asked = config(table, coding=table / "coding.csv")

    def killed(session, out):
        raise RuntimeError("killed")

    with monkeypatch.context() as patched:
        patched.setattr(sessions.VideoSessionRun, "draw", killed)
        with pytest.raises(RuntimeError, match="killed"):
            run_footage_session(asked, tmp_path / "out")
    assert run_footage_session(asked, tmp_path / "out", resume=True) == whole[1]
    assert tables(tmp_path / "out") == tables(whole[0])


def test_without_a_coding_success_is_not_known(table, tmp_path):
    summary = run_footage_session(config(table, minutes=2 / 60), tmp_path / "out")
    assert (summary.success, summary.successes, summary.success_rate) == ("not known", None, None)
    assert not (tmp_path / "out" / "success.png").exists()
    assert pq.read_table(tmp_path / "out" / "frames.parquet")["target"].null_count == summary.frames == 60


def test_times_are_those_of_the_file_at_a_variable_rate(table, tmp_path):
    """Every other image of the middle is left out: the session lasts as long, and repeats are not perceived."""
    cut = ("-vf", r"select='not(between(n,40,100)*mod(n,2))'", "-fps_mode", "vfr", "-c:v", "libx264", "-crf", "20")
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-i", table / "table.mp4", *cut]
    subprocess.run([*command, tmp_path / "table.mp4"], check=True)
    summary = run_footage_session(config(tmp_path), tmp_path / "out")
    frames = pq.read_table(tmp_path / "out" / "frames.parquet")
    assert summary.frames == FRAMES - LEARNED
    np.testing.assert_allclose(np.diff(frames["time_s"].to_numpy()), 1 / 30, atol=1e-6)
    images = frames["image"].to_numpy()
    assert len(np.unique(images)) == FRAMES - 30 - LEARNED


def test_a_thing_that_moves_while_the_head_turns_is_seen_when_it_has_turned(wide, tmp_path):
    images = np.repeat(wide[None], 4 * FRAMES, axis=0)
    for number, image in enumerate(images):
        x = 180 + abs(4 * number % 176 - 88)  # up to 8 pixels of the robot's image a frame
        cv2.rectangle(image, (x, 176), (x + 8, 184), INKS["blue"], -1)
        cv2.rectangle(image, (140, 177), (148, 185), INKS["red"], -1)
    encode(tmp_path / "table.mp4", images, "-c:v", "libx264", "-preset", "ultrafast", "-crf", "20")
    summary = run_footage_session(config(tmp_path), None)
    assert summary.gaze_shifts_of_all_kinds > 3
    assert summary.detected["blue"] > 0.95


def test_a_cut_while_the_head_turns_is_known_when_it_has_turned(wide, table):
    """The robot perceives nothing while it turns. Afterwards nothing need be where it was."""

    class Source:
        """Jumps before its fifth image."""

        aspect = 1.0

        def __init__(self, frames: int):
            self.images = (WideFrame(wide[..., ::-1].copy(), k, k / 30, k in (0, 4)) for k in range(frames, 9))

        def next(self) -> WideFrame | None:
            return next(self.images, None)

        def close(self) -> None:
            pass

    session, lost = sessions.VideoSessionRun(config(table)), []
    session.wide.connect(Source, None)
    session.perceiver.areas.show_faces = lambda boxes, cut, shifted: lost.append(cut)
    for perceives in (True, True, False, False, False, True, True):
        if perceives:
            session.perceiver.perceive(session._observation, landed=False)
        session.wide.step(np.zeros(2))
    session.close()
    assert lost == [True, False, True, False]


def test_without_a_face_a_session_says_so(wide, table, tmp_path, monkeypatch):
    monkeypatch.setattr(sessions, "FACELESS_S", 0.3)
    images = np.repeat(np.zeros_like(wide)[None], 30, axis=0)
    encode(tmp_path / "table.mp4", images, "-c:v", "libx264")
    with pytest.raises(FootageError, match=r"no face was found in 0\.3 s of .*table\.mp4"):
        run_footage_session(config(tmp_path), None)


def test_a_robot_sees_in_a_wide_image_what_it_sees_in_the_world():
    """The crop of the wide image is the image that the robot's own eye renders, but for sampling."""
    seed = np.random.SeedSequence(5)
    wide, world = WideEyedWorld.build(WorldConfig(), seed), World.build(WorldConfig(), seed)
    eye, head = wide.wide_eye(), np.radians([9.0, -12.0])
    wide.hold()
    for _ in range(40):
        wide.step(np.radians([0, TILT_DEG]))
        world.step(head)
    wide_image = np.ascontiguousarray(eye.render()[..., ::-1])
    off = np.abs(
        Lens(WIDTH, HEIGHT, HEAD).crop(wide_image, np.degrees(world.head_angles())).astype(int) - world.image()
    )
    assert np.mean(off) < 1.5
    assert np.mean(off.max(axis=2) > 40) < 0.01
    wide.close(), world.close()


def test_a_camera_is_followed_in_real_time_and_leaves_nothing(table, tmp_path, monkeypatch):
    """A video file in place of a device; the machine may be busy, so only what must hold is asked."""
    monkeypatch.chdir(tmp_path)
    asked = config(table)
    camera = CameraSessionConfig(
        objects=asked.objects, detector="templates", head=HEAD, robot=ROBOT, camera=str(table / "table.mp4"),
        minutes=2 / 60,
    )  # fmt: skip
    began = time.monotonic()
    summary = run_footage_session(camera, None)
    assert time.monotonic() - began > 2
    assert summary.frames == 60
    assert summary.camera is not None
    assert summary.camera.images >= 60
    assert summary.camera.latency_median_ms is not None
    assert 0 <= summary.camera.frames_lost < 75
    assert list(tmp_path.iterdir()) == []


def test_the_live_view_shows_a_session_and_ends_it(table):
    """Somebody looks at the page from another thread, pauses, goes on, and ends the session."""
    camera = CameraSessionConfig(
        objects=("red", "blue"), detector="templates", head=HEAD, robot=ROBOT, camera=str(table / "table.mp4")
    )
    states, images = [], []

    def look(view: LiveView) -> None:
        host = view.address.split("/")[2]

        def ask(place: str, method: str = "GET") -> bytes:
            request = Request(f"{view.address}{place}", method=method, headers={"Origin": f"http://{host}"})
            with urlopen(request, timeout=20) as answer:
                return answer.read()

        def until(phase: str) -> None:
            for _ in range(200):
                states.append(json.loads(ask("state.json")))
                if states[-1]["phase"] == phase:
                    return
                time.sleep(0.05)

        until("session")
        ask("pause", "POST")
        until("paused")
        images.extend(cv2.imdecode(np.frombuffer(ask(name), np.uint8), 1) for name in ("image.jpg", "wide_image.jpg"))
        ask("resume", "POST")
        ask("finish", "POST")

    with LiveView(18_200) as view:
        looker = threading.Thread(target=look, args=(view,))
        looker.start()
        summary = run_footage_session(camera, None, prepare=view.attach)
        looker.join(30)
    assert [image.shape[1] for image in images] == [640, 640]
    paused = next(state for state in states if state["phase"] == "paused")
    assert [candidate["name"] for candidate in paused["candidates"]] == ["red", "blue", "face"]
    assert paused["camera"]["images"] > 0
    assert 0 < summary.frames < FRAMES


def test_a_present_person_can_go_on_later(table, tmp_path):
    camera = CameraSessionConfig(
        objects=("red", "blue"), detector="templates", head=HEAD, robot=ROBOT, camera=str(table / "table.mp4"),
        minutes=2 / 60,
    )  # fmt: skip

    def stop(session):
        raise RuntimeError("killed")

    with pytest.raises(RuntimeError, match="killed"):
        run_footage_session(camera, tmp_path / "out", checkpoint_minutes=1 / 120, progress=stop)
    summary = run_footage_session(camera, tmp_path / "out", resume=True)
    assert summary.frames == 60
    assert min(summary.detected.values()) > 0.9  # objects are found at once after the break, too
    frames = pq.read_table(tmp_path / "out" / "frames.parquet")
    assert frames.num_rows == 60
    assert (np.diff(frames["image"].to_numpy()) >= 0).all()  # another camera's images are others
    opened = SessionResult.open(tmp_path / "out")
    assert (opened.config, opened.summary) == (camera, summary)
    assert opened.summary.camera == summary.camera and len(opened.frames) == 60


def test_a_pause_is_no_loss_and_a_later_camera_goes_on_with_the_clock(table):
    """Time goes on where the first camera stopped, pause included, and images of the pause are not lost ones."""
    count, shown, open_s = CameraCount(), [], []
    asked = CameraSessionConfig(objects=("red",), detector="templates", head=HEAD, camera=str(table / "table.mp4"))
    for pause_s in (PAUSED_S + 0.3, 0.0):
        source = CameraSource(asked, count)
        for number in range(4):
            shown.append(source.next())
            time.sleep(pause_s * (number == 2))
        open_s.append(count.seconds)  # as a checkpoint holds it
        source.close()
    times, numbers = [frame.time_s for frame in shown], [frame.number for frame in shown]
    assert times == sorted(times) and numbers == sorted(numbers) and numbers[4] > numbers[3]
    assert [frame.cut for frame in shown] == [True, False, False, True, True, False, False, False]
    assert times[3] - times[2] > PAUSED_S
    assert count.images_lost < 30 * PAUSED_S
    assert open_s[0] > PAUSED_S and open_s == sorted(open_s)


def test_objects_can_be_picked(table, tmp_path):
    asked = replace(config(table), objects=("red", "box@1s:264,181"), minutes=1 / 60)
    summary = run_footage_session(asked, tmp_path / "out")
    assert summary.detected["box"] > 0.95


def test_command_lines(jointattn, table, tmp_path):
    video = (
        "session",
        "--world",
        "video",
        "--detector",
        "templates",
        "--objects",
        "red",
        "blue",
        "--out",
        tmp_path / "a",
    )
    refused(jointattn(*video, "--video-file", tmp_path / "none.mp4"), 2, "none.mp4", "does not exist")
    (tmp_path / "words.mp4").write_text("no video\n" * 99)
    refused(jointattn(*video, "--video-file", tmp_path / "words.mp4"), 2, "is no video")
    narrow = (*video, "--video-file", table / "table.mp4")
    refused(jointattn(*narrow, "--fov-deg", "60"), 2, "--fov-deg", "--border black")
    refused(jointattn(*narrow, "--coding", tmp_path / "none.csv"), 2, "none.csv")
    refused(jointattn("session", "--world", "vidoe"), 2, "perhaps you meant 'video'")
    refused(
        jointattn("session", "--world", "camera", "--detector", "templates", "--camera", "97", "--no-live"), 2, "97"
    )
    refused(jointattn("session", "--world", "camera", "--resume"), 2, "--out")
    if DETECTOR != "yunet":
        refused(jointattn("session", "--world", "camera"), 2, "footage")
    assert not (tmp_path / "a" / "summary.json").exists()
    done = jointattn(
        *video, "--video-file", table / "table.mp4", "--fov-deg", FOV_DEG, "--mount-deg", TILT_DEG, "--minutes",
        1 / 60, "--robot.familiarise.minutes", LEARNED / 1800, "--robot.som.updates", 20,
    )  # fmt: skip
    assert done.code == 0, done.err
    assert "success is not known" in done.out
    assert json.loads((tmp_path / "a" / "summary.json").read_text())["success"] == "not known"
