"""Rows in memory and in files: the same rows, whatever is stopped, killed, copied or damaged; memory stays as it is."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jointattn_mj.errors import CheckpointError, OutputError
from jointattn_mj.io import rows as module
from jointattn_mj.io.rows import RowStore, forget_log, log_folder, spans, summary_of_ended

COLUMNS = 3


@pytest.fixture(autouse=True)
def small_buffers(monkeypatch):
    """Five rows in a buffer, seven in what is read at a time."""
    monkeypatch.setattr(module, "BUFFER_BYTES", 5 * COLUMNS * 4)
    monkeypatch.setattr(module, "PART_BYTES", 7 * COLUMNS * 4)


def row(number: int) -> np.ndarray:
    return np.array([number, -number, number / 7], np.float32)


def expected(first: int, last: int) -> np.ndarray:
    return np.array([row(number) for number in range(first, last)], np.float32).reshape(-1, COLUMNS)


def store(rows: int = 0, folder=None) -> RowStore:
    made = RowStore("numbers", np.float32, COLUMNS)
    if folder is not None:
        made.attach(folder)
    return grown(made, rows)


def grown(given: RowStore, to: int) -> RowStore:
    while len(given) < to:
        given.append(row(len(given)))
    return given


@pytest.mark.parametrize("attached", [False, True])
@pytest.mark.parametrize("rows", [0, 1, 5, 6, 10, 23])
def test_reading(tmp_path, attached, rows):
    made = store(rows, tmp_path if attached else None)
    assert len(made) == rows
    for first in range(rows + 1):
        for last in range(first, rows + 1):
            np.testing.assert_array_equal(made.read(first, last), expected(first, last))
            np.testing.assert_array_equal(made.column(1, first, last), expected(first, last)[:, 1])
    np.testing.assert_array_equal(made.read(), expected(0, rows))
    for first, last in ((-1, 0), (0, rows + 1), (1, 0)):
        with pytest.raises(IndexError):
            made.read(first, last)


def test_reading_gives_copies():
    made = store(7)
    made.read()[:] = 0
    np.testing.assert_array_equal(made.read(), expected(0, 7))


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 9), max_size=8))
def test_rows_many_at_a_time(pieces):
    """As compiled loops fill them."""
    made = store()
    for piece in pieces:
        while piece:
            free = made.free()
            count = min(piece, len(free))
            free[:count] = expected(len(made), len(made) + count)
            made.fill(count)
            piece -= count
    np.testing.assert_array_equal(made.read(), expected(0, sum(pieces)))


def test_more_than_was_free():
    made = store(3)
    with pytest.raises(ValueError, match="2 rows are free"):
        made.fill(3)


@pytest.mark.parametrize("attached", [False, True])
def test_a_row_wider_than_a_buffer(tmp_path, attached):
    made = RowStore("wide", np.float64, 1000)
    if attached:
        made.attach(tmp_path)
    for number in range(3):
        made.append(np.full(1000, number))
    assert made.column(999).tolist() == [0, 1, 2]


def test_memory_holds_no_more_than_a_buffer(tmp_path):
    """And so does a checkpoint, however many rows there are."""
    sizes = [len(pickle.dumps(store(rows, tmp_path / str(rows)))) for rows in (23, 2003)]
    assert abs(sizes[1] - sizes[0]) < 20
    assert len(pickle.dumps(store(2003))) > 2003 * COLUMNS * 4


@settings(max_examples=40, deadline=None)
@given(stop=st.integers(0, 30), beyond=st.integers(0, 30), end=st.integers(30, 60))
def test_killed_and_resumed(tmp_path_factory, stop, beyond, end):
    """What was written after the checkpoint is forgotten, and the file is as if nothing had been."""
    folder, whole = tmp_path_factory.mktemp("killed"), tmp_path_factory.mktemp("whole")
    made = store(stop, folder)
    checkpoint = pickle.dumps(made)
    while len(made) < stop + beyond:
        made.append(np.full(COLUMNS, 99))
    again = pickle.loads(checkpoint)
    again.attach(folder)
    np.testing.assert_array_equal(again.read(), expected(0, stop))
    np.testing.assert_array_equal(grown(again, end).read(), expected(0, end))
    store(end, whole)
    assert (folder / "numbers.rows").read_bytes() == (whole / "numbers.rows").read_bytes()


def test_a_new_run_where_a_killed_one_left_rows(tmp_path):
    store(23, tmp_path)
    np.testing.assert_array_equal(store(8, tmp_path).read(), expected(0, 8))
    assert (tmp_path / "numbers.rows").stat().st_size == 5 * COLUMNS * 4


def test_rows_in_memory_move_into_the_file(tmp_path):
    made = store(13)
    made.attach(tmp_path / "log")
    np.testing.assert_array_equal(grown(made, 23).read(), expected(0, 23))
    again = pickle.loads(pickle.dumps(made))
    again.attach(tmp_path / "log")
    np.testing.assert_array_equal(again.read(), expected(0, 23))


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda given: pickle.loads(pickle.dumps(given))])
def test_copies_of_rows_in_memory(copied):
    made = store(13)
    again = grown(copied(made), 23)
    np.testing.assert_array_equal(again.read(), expected(0, 23))
    np.testing.assert_array_equal(made.read(), expected(0, 13))


def test_a_copy_without_its_file(tmp_path):
    again = pickle.loads(pickle.dumps(store(13, tmp_path)))
    np.testing.assert_array_equal(again.read(10, 13), expected(10, 13))  # what waited in memory
    for use in (again.read, lambda: grown(again, 23)):
        with pytest.raises(CheckpointError, match="attach"):
            use()


@pytest.mark.parametrize(
    "change",
    [
        {"name": "../numbers"}, {"name": ""}, {"shape": (1 << 40, 3)}, {"shape": (0, 3)}, {"shape": (-5, -3)},
        {"shape": (1, 10**9)}, {"shape": (5, 3.0)}, {"stored": 12}, {"stored": -1}, {"checksum": "x"},
        {"kind": "O"}, {"kind": "V4"}, {"kind": "<U1"}, {"kind": "<f8"}, {"kind": "<c8"},
        {"waiting": np.zeros((1, 1), np.float32)}, {"waiting": np.zeros((9, 3), np.float32)}, {"waiting": [[0, 0, 0]]},
        {"full": [np.zeros((5, 3), object)]}, {"full": [np.zeros((5, 1), np.float32)] * 2},
    ],
)  # fmt: skip
def test_a_state_from_somebody_else(change):
    """Names no file outside of the folder, takes no more memory than its rows, and reads none as objects."""
    with pytest.raises(ValueError, match=r"numbers|no store|must be"):
        RowStore.__new__(RowStore).__setstate__(store(13).__getstate__() | change)


def test_recalled_into_memory(tmp_path):
    """And lives on there, while the file stays as it is."""
    made = store(13, tmp_path)
    again = pickle.loads(pickle.dumps(made))
    grown(made, 30)
    before = (tmp_path / "numbers.rows").read_bytes()
    again.recall(tmp_path)
    again = grown(pickle.loads(pickle.dumps(again)), 23)
    np.testing.assert_array_equal(again.read(), expected(0, 23))
    assert (tmp_path / "numbers.rows").read_bytes() == before


@pytest.mark.parametrize("fault", ["missing", "short", "changed"])
def test_damaged_file(tmp_path, fault):
    made = store(13, tmp_path)
    checkpoint, path = pickle.dumps(made), tmp_path / "numbers.rows"
    content = bytearray(path.read_bytes())
    if fault == "missing":
        path.unlink()
    elif fault == "short":
        path.write_bytes(content[:-1])
    else:
        content[50] ^= 1
        path.write_bytes(content)
    for use in (RowStore.attach, RowStore.recall):
        with pytest.raises(CheckpointError, match=r"numbers\.rows"):
            use(pickle.loads(checkpoint), tmp_path)
    if fault != "changed":
        with pytest.raises((CheckpointError, OSError)):
            made.read()


def test_a_full_disk_loses_nothing(tmp_path, monkeypatch):
    """The rows are still in memory, and are written when there is room again."""
    made = store(5, tmp_path)
    checkpoint = pickle.dumps(made)
    monkeypatch.setattr(made, "_path", Path("/dev/full"))
    with pytest.raises(OutputError, match="free space"):
        made.append(row(5))
    assert pickle.dumps(made) == checkpoint
    monkeypatch.setattr(made, "_path", tmp_path / "numbers.rows")
    np.testing.assert_array_equal(grown(made, 12).read(), expected(0, 12))


def test_beside(tmp_path):
    for first in (store(), store(0, tmp_path)):
        made = first.beside("others", 2)
        for number in range(20):
            made.append([number, 0])
        assert made.column(0).tolist() == list(range(20))
    assert [path.name for path in tmp_path.iterdir()] == ["others.rows"]


def test_the_log_of_a_finished_run(tmp_path):
    store(20, log_folder(tmp_path))
    forget_log(tmp_path)
    assert not list(tmp_path.iterdir())
    forget_log(tmp_path)


def test_a_run_that_has_ended(tmp_path):
    """It has its summary; what a kill has left of its log goes."""
    store(20, log_folder(tmp_path))
    assert summary_of_ended(tmp_path) is None
    assert log_folder(tmp_path).exists()
    (tmp_path / "summary.json").write_text('{"steps": 20}')
    assert summary_of_ended(tmp_path) == {"steps": 20}
    assert not log_folder(tmp_path).exists()
    (tmp_path / "summary.json").write_text("{")
    with pytest.raises(CheckpointError, match=r"summary\.json"):
        summary_of_ended(tmp_path)


def test_spans():
    assert list(spans(7, 3)) == [(0, 3), (3, 6), (6, 7)]
    assert list(spans(6, 3)) == [(0, 3), (3, 6)]
    assert list(spans(0, 3)) == [(0, 0)]
