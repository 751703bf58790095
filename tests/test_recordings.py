"""Observations from CSV files: labels, recordings, gaps; nothing is dropped without a word."""

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import csv, parquet

import jointattn_mj.contingency as c
from jointattn_mj.contingency import read_recordings
from jointattn_mj.errors import SeriesError


@pytest.fixture
def write(tmp_path):
    def write(text: str | bytes, name: str = "seen.csv"):
        path = tmp_path / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    return write


def codes(data, name):
    return [part.tolist() for part in data.columns[name]]


def test_labels(write):
    data = read_recordings(write("gaze,n,x\nleft,10,1.0\nrobot,9,2\nleft,-1,1\n"), ["gaze", "n", "x"])
    assert codes(data, "gaze") == [[0, 1, 0]]
    assert data.labels == {"gaze": ("left", "robot"), "n": ("-1", "9", "10"), "x": ("1", "2")}
    assert codes(data, "n") == [[2, 1, 0]]
    assert codes(data, "x") == [[0, 1, 0]]
    assert (data.rows, data.transitions, data.notes()) == (3, 2, ())


SAME = {
    "semicolons": "a;b\nx;1\ny;0\nx;1\n",
    "tabs": "a\tb\nx\t1\ny\t0\nx\t1\n",
    "blanks": " a , b\n x,1 \ny , 0\nx,1\n",
    "quotes": 'a,b\n"x",1\n"y","0"\nx,1\n',
    "windows": "a,b\r\nx,1\r\ny,0\r\nx,1\r\n",
    "byte order mark": "\ufeffa,b\nx,1\ny,0\nx,1\n",
    "blank lines at the end": "a,b\nx,1\ny,0\nx,1\n\n\n",
    "no newline at the end": "a,b\nx,1\ny,0\nx,1",
    "a column more": "z,a,b\n,x,1\n,y,0\n0.5,x,1\n",
}


@pytest.mark.parametrize("case", SAME)
def test_ways_to_write_the_same(write, case):
    data = read_recordings(write(SAME[case]), ["a", "b"])
    assert codes(data, "a") == [[0, 1, 0]]
    assert codes(data, "b") == [[1, 0, 1]]
    assert data.labels == {"a": ("x", "y"), "b": ("0", "1")}


class TestParquet:
    def test_the_same(self, tmp_path):
        """Text, words behind numbers, numbers, truth values; columns as asked for."""
        words = pa.DictionaryArray.from_arrays(pa.array([1, 0, 1], pa.int8()), ["y", "x"])
        table = pa.table({"z": [0.5, 1, 2], "b": [1, 0, 1], "a": words, "c": [1.0, 2.0, 1.0], "d": [True, False, True]})
        parquet.write_table(table, tmp_path / "seen.parquet")
        data = read_recordings(tmp_path / "seen.parquet", ["a", "b", "c", "d"])
        assert [codes(data, name) for name in "abcd"] == [[[0, 1, 0]], [[1, 0, 1]], [[0, 1, 0]], [[1, 0, 1]]]
        assert data.labels == {"a": ("x", "y"), "b": ("0", "1"), "c": ("1", "2"), "d": ("false", "true")}

    def test_missing_values(self, tmp_path):
        parquet.write_table(pa.table({"a": ["x", None, "y", "x"]}), tmp_path / "seen.parquet")
        with pytest.raises(SeriesError, match="1 missing"):
            read_recordings(tmp_path / "seen.parquet", ["a"])
        assert codes(read_recordings(tmp_path / "seen.parquet", ["a"], missing="break"), "a") == [[1, 0]]

    def test_none(self, write, tmp_path):
        with pytest.raises(SeriesError, match="no Parquet file"):
            read_recordings(write("a,b\n1,2\n", "seen.parquet"), ["a"])
        with pytest.raises(SeriesError, match="No such file"):
            read_recordings(tmp_path / "nothing.parquet", ["a"])

    def test_what_cannot_be_a_label(self, tmp_path):
        parquet.write_table(pa.table({"a": [[1], [2]]}), tmp_path / "seen.parquet")
        with pytest.raises(SeriesError, match="no Parquet file that can be read"):
            read_recordings(tmp_path / "seen.parquet", ["a"])
        with pytest.raises(SeriesError, match="no column 'b'"):
            read_recordings(tmp_path / "seen.parquet", ["b"])


def test_labels_that_look_like_numbers(write):
    data = read_recordings(write("a,b,c\n01,0.5,1e3\n1,low,2\n01,high,1000\n"), ["a", "b", "c"])
    assert data.labels == {"a": ("01", "1"), "b": ("0.5", "high", "low"), "c": ("2", "1000")}
    assert codes(data, "c") == [[1, 0, 1]]


BAD = {
    "no file": (None, ["a"], "No such file"),
    "nothing": ("", ["a"], "empty"),
    "blank": ("\n\n", ["a"], "seen.csv"),
    "header only": ("a,b\n", ["a"], "no rows"),
    "one row": ("a,b\n1,2\n", ["a"], "1 row "),
    "no such column": ("a,b\n1,2\n1,2\n", ["a", "c"], "its columns are: a, b"),
    "wrong delimiter": ("a|b\n1|2\n1|2\n", ["a"], r"a\|b"),
    "twice the same column": ("a,a\n1,2\n1,2\n", ["a"], "2 columns 'a'"),
    "fractions": ("a,b\n1,0.25\n1,0.5\n", ["b"], "bins"),
    "missing": ("a,b\n1,2\n,2\n1,2\nNA,2\n", ["a"], "2 missing values, the first in data row 2"),
    "blank line": ("a,b\n1,2\n\n1,2\n", ["a", "b"], "1 missing values"),
    "short row": ("a,b\n1,2\n1\n1,2\n", ["a"], "Expected 2 columns"),
    "not text": (b"a,b\n1,\xff\xfe\n1,2\n", ["b"], "UTF8"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_read(write, tmp_path, case):
    text, columns, words = BAD[case]
    path = tmp_path / "seen.csv" if text is None else write(text)
    with pytest.raises(SeriesError, match=words) as caught:
        read_recordings(path, columns)
    assert "\n" not in str(caught.value)


def test_a_folder(tmp_path):
    with pytest.raises(SeriesError, match="cannot read"):
        read_recordings(tmp_path, ["a"])


def test_recordings_by_column(write):
    """Also where their rows alternate."""
    data = read_recordings(write("who,a\nann,1\nbob,3\nann,2\nbob,2\nann,1\ncarl,1\n"), ["a"], recording="who")
    assert codes(data, "a") == [[0, 1, 0], [2, 1]]
    assert data.groups == [0, 1]
    assert data.alone == 1
    assert "1 rows have nothing before or after" in data.notes()[0]
    with pytest.raises(SeriesError, match="no two rows in one recording"):
        read_recordings(write("who,a\nann,1\nbob,3\n"), ["a"], recording="who")
    with pytest.raises(SeriesError, match=r"'who'.*missing"):
        read_recordings(write("who,a\nann,1\n,3\nann,2\n"), ["a"], recording="who", missing="break")


def test_recordings_are_cut_at_gaps(write):
    text = "who,a,b\n1,0,x\n1,1,\n1,1,y\n1,0,y\n1,,y\n1,1,x\n2,0,x\n2,1,x\n"
    data = read_recordings(write(text), ["a", "b"], missing="break")
    assert codes(data, "a") == [[1, 0], [1, 0, 1]]
    assert codes(data, "b") == [[1, 1], [0, 0, 0]]
    assert data.groups == [0, 0]
    assert (data.cut, data.alone) == (2, 1)
    assert "2 of 8 rows have missing values" in data.notes()[0]
    apart = read_recordings(write(text), ["a", "b"], recording="who", missing="break")
    assert codes(apart, "a") == [[1, 0], [0, 1]]
    assert apart.groups == [0, 1]
    assert apart.alone == 2


def test_everything_missing(write):
    with pytest.raises(SeriesError, match="no two rows"):
        read_recordings(write("a,b\n,1\n,2\n,3\n"), ["a"], missing="break")


def test_pieces_of_one_recording_are_permuted_together():
    """Pieces of two rows: nothing to permute within them."""
    rng = np.random.default_rng(0)
    s = [np.array([value, 0]) for value in rng.integers(0, 2, 200)]
    r = [np.array([0, part[0]]) for part in s]
    options = c.TestOptions(99, resamples=0)
    assert c.assess("transfer_entropy", s, r, options=options).p == 1
    assert c.assess("transfer_entropy", s, r, options=options, groups=[0] * 200).p == 0.01
    assert c.assess("transfer_entropy", s, r, options=options, groups=[0] * 100 + [1] * 100).exchangeable == 200
    for wrong in ([0] * 199, [0, 1] * 100):
        with pytest.raises(SeriesError, match="groups"):
            c.assess("transfer_entropy", s, r, options=options, groups=wrong)


def test_several_columns_as_one(write):
    data = read_recordings(write("a,b\nx,1\ny,1\nx,2\nx,1\n"), ["a", "b"])
    parts, labels = data.joined(["a", "b"])
    assert [part.tolist() for part in parts] == [[0, 2, 1, 0]]
    assert labels == ("x & 1", "x & 2", "y & 1")
    assert data.joined(["a"]) == (data.columns["a"], ("x", "y"))


def test_a_million_rows(tmp_path):
    n = 1_000_000
    rng = np.random.default_rng(0)
    gaze, found = rng.integers(0, 3, n), rng.integers(0, 2, n)
    table = pa.table({"gaze": np.array(["left", "right", "robot"])[gaze], "found": found})
    csv.write_csv(table, tmp_path / "long.csv")
    data = read_recordings(tmp_path / "long.csv", ["gaze", "found"])
    assert (data.columns["gaze"][0] == gaze).all()
    assert (data.columns["found"][0] == found).all()
    assessed = c.assess("transfer_entropy", gaze, found, options=c.TestOptions(200, resamples=0))
    assert assessed.value == pytest.approx(c.transfer_entropy(*(data.columns[name] for name in ("gaze", "found"))))
    assert assessed.null_mean == pytest.approx(4 / (2 * n) / np.log(2), rel=0.3)  # chi squared: df / 2n
