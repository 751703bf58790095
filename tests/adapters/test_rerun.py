"""A session's log for Rerun's viewer: what is in it, that it leaves the session alone, and how it is refused."""

import errno
import io
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

from jointattn_mj.api.session import LoggedSessionOptions, run_logged
from jointattn_mj.cli.main import main
from jointattn_mj.errors import ConfigError, OutputError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

FRAMES = 240
TRAINED = Path(__file__).parents[2] / "assets" / "trained" / "robin.npz"
needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")
needs_rerun = pytest.mark.skipif(find_spec("rerun") is None, reason="no rerun-sdk")
CONFIG = SessionConfig(minutes=0.2, seed=1, robot=RobotConfig(familiarise=FamiliariseConfig(minutes=0.03)))


def columns(path: Path, entity: str) -> Iterator[dict[str, list]]:
    """What a log holds of an entity, chunk by chunk, the static apart."""
    from rerun.chunk import RrdReader

    for chunk in RrdReader(str(path)).stream():
        if chunk.entity_path == f"/{entity}" and not chunk.is_static:
            yield chunk.to_record_batch().to_pydict()


def column(path: Path, entity: str, name: str) -> list:
    """All values of one column in the order of frames."""
    rows = [pair for chunk in columns(path, entity) for pair in zip(chunk["frame"], chunk[name], strict=True)]
    return [value for _, value in sorted(rows, key=lambda row: row[0])]


@pytest.fixture(scope="module")
def logged(tmp_path_factory) -> tuple[Path, SessionRun, SessionRun]:
    """A log, the session that it is of, and the same session without a log."""
    pytest.importorskip("rerun")
    from jointattn_mj.adapters.rerun import SessionLog

    path = tmp_path_factory.mktemp("log") / "session.rrd"
    config = replace(CONFIG, start_from=TRAINED)
    plain, watched = SessionRun(config), SessionRun(config)
    for session in (plain, watched):
        session.begin()
    for _ in range(FRAMES):
        plain.step()
    images = []
    with SessionLog(path, watched) as log:
        for _ in range(FRAMES):
            watched.step(lambda session: (log(session), images.append(session.world.image().copy())))
    np.save(path.with_name("images.npy"), np.array(images[::60]))
    yield path, watched, plain
    for session in (plain, watched):
        session.close()


@needs_rerun
@needs_gl
class TestLog:
    def test_changes_nothing(self, logged):
        _, watched, plain = logged
        assert plain.frames.table().equals(watched.frames.table())
        assert plain.shifts == watched.shifts
        assert len(plain.shifts) >= 3
        np.testing.assert_array_equal(plain.world.data.qpos, watched.world.data.qpos)
        for name, array in plain.weights().items():
            np.testing.assert_array_equal(array, watched.weights()[name])

    def test_curves(self, logged):
        path, session, _ = logged
        interest = np.array(column(path, "agent/interest", "Scalars:scalars"))
        assert interest.shape == (FRAMES, len(session.names))
        for number in range(len(session.names)):
            np.testing.assert_allclose(interest[:, number], session.frames.column("interest", number), rtol=1e-5)
        head = np.array(column(path, "head", "Scalars:scalars"))
        np.testing.assert_allclose(head[:, 0], session.frames.column("pan_deg"), atol=1e-4)
        assert 0.9 < column(path, "agent/decides/learner", "Scalars:scalars")[0][0] < 1

    def test_images(self, logged, tmp_path):
        path = logged[0]
        samples = column(path, "world/robot_eye/image", "VideoStream:sample")
        assert len(samples) == FRAMES
        (tmp_path / "images.h264").write_bytes(b"".join(bytes(sample[0]) for sample in samples))
        video, expected = cv2.VideoCapture(str(tmp_path / "images.h264")), np.load(path.with_name("images.npy"))
        for frame in range(FRAMES):
            there, image = video.read()
            assert there
            if frame % 60 == 0:
                difference = cv2.cvtColor(image, cv2.COLOR_BGR2RGB).astype(int) - expected[frame // 60]
                assert np.abs(difference).mean() < 6

    def test_percepts(self, logged):
        path, session, _ = logged
        visible = {}
        for chunk in columns(path, "world/robot_eye/visible"):
            visible |= dict(
                zip(chunk["frame"], zip(chunk["Boxes2D:centers"], chunk["Boxes2D:labels"], strict=True), strict=True)
            )
        looked = np.flatnonzero(session.frames.column("perceived") > 0)
        for frame in looked[:: max(1, len(looked) // 8)]:
            centres, labels = visible[int(frame)]
            for centre, label in zip(centres, labels, strict=True):
                number = session.names.index(label)
                centre_px = [session.frames.column(name, number)[frame] for name in ("x_px", "y_px")]
                np.testing.assert_allclose(centre, centre_px, atol=1e-3)
        turning = np.flatnonzero(session.frames.column("perceived") == 0)
        assert not any(visible[int(frame)][0] for frame in turning if int(frame) in visible)

    def test_scene(self, logged):
        path, session, _ = logged
        positions = {}
        for chunk in columns(path, "world/object_red"):
            positions |= dict(zip(chunk["frame"], chunk["Transform3D:translation"], strict=True))
        first = [session.frames.column(name, 0)[0] for name in ("x_m", "y_m", "z_m")]
        np.testing.assert_allclose(positions[0][0], first, atol=1e-6)
        starts = np.array(column(path, "world/gaze/person", "Arrows3D:origins"))
        assert starts.shape == (FRAMES, 1, 3)
        assert (starts[..., 0] > 1.2).all()  # the caregiver sits at x = 1.5 m

    def test_doings_and_shifts(self, logged):
        path, session, _ = logged
        words = column(path, "shifts", "TextLog:text")
        assert len(words) == len(session.shifts)
        robot = column(path, "doings/robot_looks_at", "StateChange:state")
        assert ["turns its head"] in robot
        assert all(before != after for before, after in pairwise(robot))
        from_face = [row for row in session.shifts if row.source == "face" and row.map_error_deg is not None]
        sheets = column(path, "agent/activations", "Tensor:data")
        assert len(sheets) >= len(from_face) > 0

    def test_layout_is_in_the_file(self, logged):
        from rerun.chunk import RrdReader

        assert len(RrdReader(str(logged[0])).blueprints()) == 1


@needs_rerun
@needs_gl
def test_without_an_encoder(tmp_path, monkeypatch):
    """JPEG images instead."""
    from jointattn_mj.adapters.rerun import SessionLog, images

    monkeypatch.setattr(images, "can_encode", lambda: False)
    session = SessionRun(replace(CONFIG, perception="state"))
    with SessionLog(tmp_path / "a.rrd", session) as log:
        for _ in range(3):
            session.step(log)
    jpegs = column(tmp_path / "a.rrd", "world/robot_eye/image", "EncodedImage:blob")
    assert len(jpegs) == 3
    image = cv2.imdecode(np.frombuffer(bytes(jpegs[-1][0]), np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (240, 320, 3)
    session.close()


@needs_rerun
@needs_gl
def test_log_that_was_cut_short(tmp_path):
    """What is older than a few seconds is in the file although nobody has finished it."""
    from jointattn_mj.adapters.rerun import SessionLog

    session = SessionRun(replace(CONFIG, perception="state"))
    log = SessionLog(tmp_path / "a.rrd", session).__enter__()
    for _ in range(150):
        session.step(log)
    deadline = time.monotonic() + 10
    while True:
        (tmp_path / "b.rrd").write_bytes((tmp_path / "a.rrd").read_bytes())
        frames = sum(len(chunk["frame"]) for chunk in columns(tmp_path / "b.rrd", "head"))
        if frames >= 120 or time.monotonic() > deadline:
            break
        time.sleep(0.1)
    log.__exit__(None, None, None)
    session.close()
    assert frames == 120


@needs_rerun
@needs_gl
def test_resumed_sessions_leave_parts_of_one_log(tmp_path):
    """Two files that the viewer shows as one recording."""
    from rerun.chunk import RrdReader

    config = replace(CONFIG, minutes=0.1, perception="state")
    path = tmp_path / "log.rrd"

    def stop(session: SessionRun) -> None:
        if session.frame == 60:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_logged(config, LoggedSessionOptions(tmp_path / "run", rerun=path, checkpoint_minutes=1 / 60), stop)
    run_logged(config, LoggedSessionOptions(tmp_path / "run", rerun=path, resume=True))
    parts = [path, path.with_stem("log_2")]
    frames = [sorted(frame for chunk in columns(part, "head") for frame in chunk["frame"]) for part in parts]
    assert frames == [list(range(60)), list(range(60, 180))]
    first, second = (RrdReader(str(part)).recordings()[0].recording_id for part in parts)
    assert first == second


class TestRefusal:
    def test_missing_package(self, tmp_path, monkeypatch, capsys):
        """It is asked for by name, before anything is computed."""
        monkeypatch.setitem(sys.modules, "rerun", None)
        with pytest.raises(SystemExit) as stop:
            main(["session", "--out", str(tmp_path / "out"), "--rerun", str(tmp_path / "a.rrd")])
        assert stop.value.code == 2
        assert "pip install 'jointattn-mj[rerun]'" in capsys.readouterr().err
        assert not list(tmp_path.iterdir())

    def test_other_suffix(self, tmp_path):
        with pytest.raises(ConfigError, match=r"\.rrd.*a\.mp4"):
            LoggedSessionOptions(tmp_path, rerun=tmp_path / "a.mp4")

    @needs_rerun
    def test_file_that_is_there(self, tmp_path):
        (tmp_path / "a.rrd").write_text("mine")
        with pytest.raises(OutputError, match="already there"):
            run_logged(CONFIG, LoggedSessionOptions(tmp_path / "out", rerun=tmp_path / "a.rrd"))
        assert (tmp_path / "a.rrd").read_text() == "mine"
        assert not (tmp_path / "out").exists()

    @needs_rerun
    def test_a_file_in_the_folders_place(self, tmp_path):
        (tmp_path / "folder").write_text("mine")
        with pytest.raises(OutputError, match="cannot make the folder"):
            run_logged(CONFIG, LoggedSessionOptions(tmp_path / "out", rerun=tmp_path / "folder" / "a.rrd"))
        assert not (tmp_path / "out").exists()


def test_costs_nothing_when_not_asked_for():
    code = "import sys, jointattn_mj.api.session; sys.exit('rerun' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@needs_rerun
@needs_gl
def test_full_disk(tmp_path, monkeypatch, capfd):
    """It says so once, ends its file there, and the session goes on to the same end; how often it is tried."""
    from jointattn_mj.adapters.rerun import outlet

    config, plain = replace(CONFIG, minutes=0.1, perception="state"), tmp_path / "plain"
    run_logged(config, LoggedSessionOptions(plain))
    for number, room in enumerate((0, 8192, 102_400, 102_401)):
        out, path = tmp_path / str(number), tmp_path / f"{number}.rrd"
        monkeypatch.setattr(outlet, "FileIO", lambda path, how, room=room: SmallDisk(path, room))
        run_logged(config, LoggedSessionOptions(out, rerun=path))
        assert path.stat().st_size == room
        assert capfd.readouterr().err == (
            f"jointattn: cannot write {path}: No space left on device; the session goes on without it\n"
        )
        for name in ("frames.parquet", "gaze_shifts.parquet", "weights.npz"):
            assert (out / name).read_bytes() == (plain / name).read_bytes()


class SmallDisk(io.FileIO):
    """A file on a disk with so many bytes left."""

    def __init__(self, path: Path, room: int):
        super().__init__(path, "xb")
        self.room = room

    def write(self, piece: bytes) -> int:
        if not self.room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = super().write(piece[: self.room])
        self.room -= written
        return written
