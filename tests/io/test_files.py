"""Files are whole or not there; what they replaced stays when the disk is full."""

import errno
import os
import resource
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from matplotlib.figure import Figure

from jointattn_mj.errors import OutputError
from jointattn_mj.gaze_following import figures
from jointattn_mj.io import checkpoint
from jointattn_mj.io.files import forget_partial, free_name, held, write_whole
from jointattn_mj.io.parquet import write_parquet
from jointattn_mj.io.provenance import write_config
from jointattn_mj.io.results import claimed_paths, write_results
from jointattn_mj.io.weights import write_weights

NOISE = np.random.default_rng(0).random((200, 200))
WRITERS = {
    "frames.parquet": lambda path: write_parquet(path, pa.table({"x": NOISE.ravel()})),
    "weights.npz": lambda path: write_weights(path, {"learner": NOISE}),
    "success.png": lambda path: figures.save(figure(), path),
    "checkpoint.bin": lambda path: checkpoint.save(path, NOISE, {}),
    "config.yaml": lambda path: write_config(path, {"x": "y" * 10_000}),
}


def figure() -> Figure:
    figure = Figure()
    figure.subplots().imshow(NOISE)
    return figure


@contextmanager
def full_disk():
    """No file can be longer than 1000 bytes; nor can a log of the tests, so no longer than needed."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def test_a_file_is_replaced_in_one_step(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")

    def write(temporary: Path) -> None:
        temporary.write_text("half")
        assert path.read_text() == "old"
        temporary.write_text("new")

    write_whole(path, write)
    assert path.read_text() == "new"
    assert [child.name for child in tmp_path.iterdir()] == ["file.txt"]


@pytest.mark.parametrize("name", WRITERS)
def test_full_disk(tmp_path, name, capfd):
    """One named error; the old file is still there, and nothing else."""
    path = tmp_path / name
    path.write_bytes(b"old")
    with full_disk(), pytest.raises(OutputError, match="free space") as caught:
        WRITERS[name](path)
    assert str(path) in str(caught.value)
    assert path.read_bytes() == b"old"
    assert [child.name for child in tmp_path.iterdir()] == [name]
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("name", WRITERS)
def test_no_folder(tmp_path, name):
    with pytest.raises(OutputError, match="No such file"):
        WRITERS[name](tmp_path / "nowhere" / name)


def test_no_space_to_put_it_in_place(tmp_path, monkeypatch):
    def full(source, target):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OutputError, match="No space left on device"):
        write_whole(tmp_path / "file", lambda path: path.write_text("new"))
    assert not list(tmp_path.iterdir())


def test_other_errors_pass_through_and_leave_nothing(tmp_path):
    def fail(path: Path) -> None:
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "file", fail)
    assert not list(tmp_path.iterdir())


def test_a_folder_whose_name_is_not_utf8(tmp_path):
    """Refused at once, and not by the writer of tables after a long run."""
    folder = tmp_path / os.fsdecode(b"a\xff")
    with pytest.raises(OutputError, match="is not UTF-8"), held(folder / "in_it"):
        pass
    assert not folder.exists()


def test_forget_partial(tmp_path):
    """Temporaries of killed writers go; everything else stays, hidden or not."""
    kept = ("frames.parquet", ".gitignore", ".notes.txt", ".frames.v2.parquet")
    for name in (*kept, ".checkpoint.4711.bin", ".frames.12.parquet"):
        (tmp_path / name).write_text("")
    forget_partial(tmp_path)
    assert {child.name for child in tmp_path.iterdir()} == set(kept)


def test_read_only_file_system(tmp_path, monkeypatch):
    """It refuses even to delete what is not there, which must not hide what is said."""

    def refuse(*arguments, **options):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(Path, "unlink", refuse)
    with pytest.raises(OutputError, match=r"cannot write .*file: Read-only file system"):
        write_whole(tmp_path / "file", refuse)


@pytest.mark.parametrize("name", WRITERS)
def test_a_folder_with_a_colon_in_its_name(tmp_path, monkeypatch, name):
    """Libraries take what stands before it in a relative path as a protocol."""
    monkeypatch.chdir(tmp_path)
    Path("o:2").mkdir()
    WRITERS[name](Path("o:2") / name)
    assert [path.name for path in Path("o:2").iterdir()] == [name]


def test_two_files_or_none(tmp_path):
    """One that cannot be written leaves neither."""
    table, document = tmp_path / "nowhere" / "a.csv", tmp_path / "a.json"
    with pytest.raises(OutputError, match=r"cannot write \S+a\.csv: No such"):
        write_results((table, document), [{"x": 1}], {})
    assert not list(tmp_path.iterdir())


def test_free_name(tmp_path):
    path = tmp_path / "video.mp4"
    for expected in ("video.mp4", "video_2.mp4", "video_3.mp4"):
        assert free_name(path).name == expected
        free_name(path).touch()


class TestClaimedPaths:
    """Names of results that an analysis writes when it has ended."""

    def test_no_second_analysis_gets_the_same_names(self, tmp_path):
        with claimed_paths(tmp_path / "a.csv", "x") as paths:
            assert paths == (tmp_path / "a.csv", tmp_path / "a.json")
            with pytest.raises(OutputError, match="about to write"), claimed_paths(tmp_path / "a", "x"):
                pass
            with claimed_paths(tmp_path, "x") as others:
                assert others[0].name == "x.csv"
        assert not list(tmp_path.iterdir())

    def test_names_are_free_again_after_a_failure(self, tmp_path):
        with pytest.raises(ValueError), claimed_paths(tmp_path / "a", "x"):
            raise ValueError
        with claimed_paths(tmp_path / "a", "x") as paths:
            paths[0].touch()
        with pytest.raises(OutputError, match="there already"), claimed_paths(tmp_path / "a", "x"):
            pass
