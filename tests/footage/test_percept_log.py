"""The growing table of percepts: complete, in order, described, and flat in memory."""

import pickle
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest

from jointattn_mj.errors import OutputError
from jointattn_mj.footage.log import BLOCK, RECENT, PerceptLog
from jointattn_mj.perception.percept import Percept

NAMES = ("red", "blue", "face")


def watcher(frame: int) -> SimpleNamespace:
    """One whose numbers tell the frame."""
    visible = np.array([True, False, frame % 2 == 0])
    px = np.where(visible[:, None], frame + np.arange(6.0).reshape(3, 2), np.nan)
    return SimpleNamespace(
        attention=SimpleNamespace(
            saliency=np.arange(3.0), motion=np.arange(3.0) + frame % 7, interest=frame + np.arange(3.0)
        ),
        percept=Percept(visible, px, np.array([frame % 3 == 0, False, False])),
        perceiver=SimpleNamespace(fix=SimpleNamespace(score=0.5)),
        attended=None if frame < 4 else 2,
        goal=0 if frame % 5 == 0 else None,
    )


@pytest.mark.parametrize("frames", [0, 1, BLOCK, 2 * BLOCK + 2 * RECENT + 7])
def test_every_frame_once(tmp_path, frames):
    log = PerceptLog(tmp_path, NAMES)
    held = log._recent.nbytes
    for frame in range(frames):
        log.add(watcher(frame), frame // 2, frame % 2 == 0)
        if frame % 500 == 0:
            check_recent(log, frame)
    assert log._recent.nbytes == held
    assert not (tmp_path / "percepts.parquet").exists()
    log.write(tmp_path / "percepts.parquet")
    assert {path.name for path in tmp_path.iterdir()} - {"log"} == {"percepts.parquet"}
    table = pq.read_table(tmp_path / "percepts.parquet")
    assert all(field.metadata[b"description"] for field in table.schema)
    columns = table.to_pydict()
    number = np.arange(frames)
    np.testing.assert_allclose(columns["time_s"], number / 30)
    assert columns["image"] == (number // 2).tolist()
    assert columns["fresh"] == (number % 2 == 0).tolist()
    assert columns["attended"] == [None if k < 4 else "face" for k in range(frames)]
    assert columns["head_moves"] == (number % 5 == 0).tolist()
    np.testing.assert_allclose(columns["face_interest"], number + 2)
    np.testing.assert_allclose(columns["red_y_px"], number + 1)
    assert columns["blue_x_px"] == [None] * frames
    assert columns["face_x_px"] == [k + 4 if k % 2 == 0 else None for k in range(frames)]
    assert columns["red_moves"] == (number % 3 == 0).tolist()


def check_recent(log: PerceptLog, frame: int) -> None:
    """The last rows can be looked back at."""
    recent = log.column("interest", 1)
    assert recent[-1] == frame + 1
    assert len(recent) >= min(frame + 1, RECENT)
    np.testing.assert_array_equal(np.diff(recent), 1)


def test_going_on_from_a_checkpoint(tmp_path):
    """What was written after it is cut off; the file is the same, and the last rows can be looked back at at once."""
    for name in ("straight", "on"):
        (tmp_path / name).mkdir()
    straight, log = (PerceptLog(tmp_path / name, NAMES) for name in ("straight", "on"))
    for frame in range(3000):
        straight.add(watcher(frame), frame, True)
        log.add(watcher(frame if frame < 2500 else 9), frame, True)
        if frame == 2499:
            kept = pickle.dumps(log.rows)
    again = PerceptLog(tmp_path / "on", NAMES, pickle.loads(kept))
    assert again.frames == 2500
    check_recent(again, 2499)
    for frame in range(2500, 3000):
        again.add(watcher(frame), frame, True)
    check_recent(again, 2999)
    for written, name in ((straight, "straight"), (again, "on")):
        written.write(tmp_path / name / "percepts.parquet")
    assert (tmp_path / "straight" / "percepts.parquet").read_bytes() == (
        tmp_path / "on" / "percepts.parquet"
    ).read_bytes()


def test_a_place_that_cannot_be_written(tmp_path):
    log = PerceptLog(tmp_path / "nowhere", NAMES)
    with pytest.raises(OutputError, match=r"percepts.*another folder"):
        for frame in range(BLOCK):
            log.add(watcher(frame), frame, True)
