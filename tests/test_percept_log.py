"""The growing table of percepts: complete, in order, described, and flat in memory."""

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
    seen = np.array([True, False, frame % 2 == 0])
    px = np.where(seen[:, None], frame + np.arange(6.0).reshape(3, 2), np.nan)
    return SimpleNamespace(
        attention=SimpleNamespace(
            saliency=np.arange(3.0), motion=np.arange(3.0) + frame % 7, interest=frame + np.arange(3.0)
        ),
        percept=Percept(seen, px, np.array([frame % 3 == 0, False, False])),
        perceiver=SimpleNamespace(fix=SimpleNamespace(score=0.5)),
        attended=None if frame < 4 else 2,
        goal=0 if frame % 5 == 0 else None,
    )


@pytest.mark.parametrize("frames", [0, 1, BLOCK, 2 * BLOCK + 2 * RECENT + 7])
def test_every_frame_once(tmp_path, frames):
    log = PerceptLog(tmp_path / "percepts.parquet", NAMES)
    held = log._values.nbytes
    for frame in range(frames):
        log.add(watcher(frame), frame // 2, frame % 2 == 0)
        if frame % 500 == 0:
            recent = log.column("interest", 1)
            assert recent[-1] == frame + 1
            assert len(recent) >= min(frame + 1, RECENT)
            np.testing.assert_array_equal(np.diff(recent), 1)
    assert log._values.nbytes == held
    assert not (tmp_path / "percepts.parquet").exists()
    log.close()
    assert [path.name for path in tmp_path.iterdir()] == ["percepts.parquet"]
    table = pq.read_table(tmp_path / "percepts.parquet")
    assert all(field.metadata[b"description"] for field in table.schema)
    columns = table.to_pydict()
    number = np.arange(frames)
    np.testing.assert_allclose(columns["time_s"], number / 30)
    assert columns["picture"] == (number // 2).tolist()
    assert columns["fresh"] == (number % 2 == 0).tolist()
    assert columns["attended"] == [None if k < 4 else "face" for k in range(frames)]
    assert columns["head_moves"] == (number % 5 == 0).tolist()
    np.testing.assert_allclose(columns["face_interest"], number + 2)
    np.testing.assert_allclose(columns["red_y_px"], number + 1)
    assert columns["blue_x_px"] == [None] * frames
    assert columns["face_x_px"] == [k + 4 if k % 2 == 0 else None for k in range(frames)]
    assert columns["red_moves"] == (number % 3 == 0).tolist()


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match=r"percepts.parquet.*--out"):
        PerceptLog(tmp_path / "file" / "percepts.parquet", NAMES)
