"""Observations from CSV files: labels, recordings, gaps; nothing is dropped without a word."""

import numpy as np
import pyarrow as pa
import pytest
from coded_files import as_parquet, workbook
from pyarrow import csv, parquet

import jointattn_mj.contingency as c
from jointattn_mj import read_recordings
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.options import RenamedWarning


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
    "old Macintosh": "a,b\rx,1\ry,0\rx,1\r",
    "a line for Excel": "sep=;\na;b\nx;1\ny;0\nx;1\n",
    "delimiters inside quotes": 'a;"c, d, e";b\nx;1,5;1\ny;2,5;0\nx;"3;5";1\n',
    "a line break inside quotes": 'a,"c\nd",b\nx,"1\n2",1\ny,,0\nx,,1\n',
    "UTF-8 with a mark": b"\xef\xbb\xbfa,b\nx,1\ny,0\nx,1\n",
    "UTF-16 with a mark": "a\tb\nx\t1\ny\t0\nx\t1\n".encode("utf-16"),
    "UTF-16 with its other mark": b"\xfe\xff" + "a\tb\r\nx\t1\r\ny\t0\r\nx\t1\r\n".encode("utf-16-be"),
    "UTF-16 without a mark": "a\tb\nx\t1\ny\t0\nx\t1\n".encode("utf-16-le"),
    "UTF-16 without its other mark": "a\tb\nx\t1\ny\t0\nx\t1\n".encode("utf-16-be"),
    "vertical bars": "a|b\nx|1\ny|0\nx|1\n",
    "lines above the header": "Observation id;dyad 3;\nMedia file;x.mp4;\na;b\nx;1\ny;0\nx;1\n",
    "blank lines at the start": "\n;;\nObservation id;dyad 3\n\na;b\nx;1\ny;0\nx;1\n",
    "a blank line above the header": "Observation id;dyad 3\n;\na;b\nx;1\ny;0\nx;1\n",
    "UTF-32 with a mark": "a;b\nx;1\ny;0\nx;1\n".encode("utf-32"),
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
            read_recordings(write(b"PAR1" + b"no more", "seen.parquet"), ["a"])
        with pytest.raises(SeriesError, match="No such file"):
            read_recordings(tmp_path / "nothing.parquet", ["a"])

    def test_what_cannot_be_a_label(self, tmp_path):
        parquet.write_table(pa.table({"a": [[1], [2]]}), tmp_path / "seen.parquet")
        with pytest.raises(SeriesError, match="no table that can be read"):
            read_recordings(tmp_path / "seen.parquet", ["a"])
        with pytest.raises(SeriesError, match="no column 'b'"):
            read_recordings(tmp_path / "seen.parquet", ["b"])


def test_the_same_table_in_every_kind_of_file(write):
    """Whole numbers, words, truth values, ids, missing values; with a blank before some."""
    header = ("who", "a", "b", "c", "d")
    rows = [("12.1", "x", 1.0, True, " NA"), ("12.1", " y", 2.0, False, "u"), ("12.1", "x", 1.0, True, "v")]
    rows += [("12.10", *row[1:]) for row in rows[1:]] + [("12.10", "x", None, True, "u")]
    text = "who,a,b,c,d\n12.1,x,1.0,true, NA\n12.1, y,2.0,false,u\n12.1,x,1,true,v\n"
    text += "12.10,y,2,false,u\n12.10,x,1.0,true,v\n12.10,x,,true,u\n"
    table = pa.table({name: [row[i] for row in rows] for i, name in enumerate(header)})
    files = [text, text.replace(",", "\t").encode("utf-16"), as_parquet(table), workbook([header, *rows])]
    for file in files:
        data = read_recordings(write(file), list("abcd"), "who", "break")
        assert data.labels == {"a": ("x", "y"), "b": ("1", "2"), "c": ("false", "true"), "d": ("u", "v")}
        assert [codes(data, name) for name in "abcd"] == [
            [[1, 0], [1, 0]],
            [[1, 0], [1, 0]],
            [[0, 1], [0, 1]],
            [[0, 1], [0, 1]],
        ]
        assert data.names == ("12.1", "12.10")


def test_labels_that_look_like_numbers(write):
    data = read_recordings(write("a,b,c\n01,0.5,1e3\n1,low,2\n01,high,1000\n"), ["a", "b", "c"])
    assert data.labels == {"a": ("01", "1"), "b": ("0.5", "high", "low"), "c": ("1000", "1e3", "2")}
    assert codes(data, "c") == [[1, 2, 0]]


BAD = {
    "no file": (None, ["a"], "No such file"),
    "nothing": ("", ["a"], "empty"),
    "blank": ("\n\n", ["a"], "seen.csv"),
    "header only": ("a,b\n", ["a"], "no rows"),
    "one row": ("a,b\n1,2\n", ["a"], "1 row "),
    "no such column": ("a,b\n1,2\n1,2\n", ["a", "c"], "its columns are: a, b"),
    "a delimiter that is not found": ("a:b\n1:2\n1:2\n", ["a"], "a:b"),
    "twice the same column": ("a,a\n1,2\n1,2\n", ["a"], "2 columns 'a'"),
    "fractions": ("a,b\n1,0.25\n1,0.5\n", ["b"], "bins"),
    "missing": ("a,b\n1,2\n,2\n1,2\nNA,2\n", ["a"], "2 missing values, the first in data row 2"),
    "blank line": ("a,b\n1,2\n\n1,2\n", ["a", "b"], "1 missing values"),
    "short row": ("a,b\n1,2\n1\n1,2\n", ["a"], "data row 2: Expected 2 columns"),
    "another encoding": (
        b"a,b\n1,\xff\xfe\n1,2\n",
        ["b"],
        r"not in UTF-8 \(byte 0xFF in line 2\).*`encoding=.cp1252.`",
    ),
    "a damaged workbook": (b"PK\x03\x04\x14\0\x06\0" + bytes(200), ["a"], "no workbook that can be read"),
    "compressed": (b"\x1f\x8b\x08\0" + bytes(200), ["a"], "gzip"),
    "binary": (bytes(range(256)), ["a"], "no text file"),
    "a header of its own": ("id;3\nwhen;now\na;b\n1;2\n1;2\n", ["a", "b"], "Line 3 names them: say `skip_rows=2`"),
    "nearly the name": ("mother,infant\n1,2\n1,2\n", ["mothr"], "did you mean 'mother'"),
    "onset and offset": ("a,onset,offset\n1,0,2\n2,2,3\n", ["a"], "'onset' and 'offset'.*`rows_are_steps=True`"),
    "begin and end": ("Begin Time - ms\tEnd Time - ms\ta\n0\t2\t1\n2\t3\t1\n", ["a"], "lists events"),
    "two people's events": ("m.onset,m.offset,m.a\n0,2,1\n2,3,1\n", ["m.a"], "'m.onset' and 'm.offset'"),
    "onset and duration": ("onset,duration,a\n0,2,1\n2,1,1\n", ["a"], "lists events"),
    "fractions with a comma": ("a;b\n1;0,25\n1;0,5\n", ["b"], "numbers with fractions, such as 0,25.*bins"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_read(write, tmp_path, case):
    text, columns, words = BAD[case]
    path = tmp_path / "seen.csv" if text is None else write(text)
    with pytest.raises(SeriesError, match=words) as caught:
        read_recordings(path, columns)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", [".", "a\0b", "x" * 5000, "/proc/self/mem", "/dev/zero"], ids=lambda name: name[:5])
def test_what_is_no_file(tmp_path, name):
    with pytest.raises(SeriesError, match="cannot read"):
        read_recordings(tmp_path / name, ["a"])


class TestEncoding:
    TEXT = "mère;b\nà;1\né;0\nà;1\n"

    @pytest.mark.parametrize("encoding", ["cp1252", "latin-1", "mac-roman", "utf-16-le", "utf-8"])
    def test_told(self, write, encoding):
        path = write(self.TEXT.encode(encoding))
        data = read_recordings(path, ["mère", "b"], encoding=encoding)
        assert codes(data, "mère") == [[0, 1, 0]]
        assert data.labels["mère"] == ("à", "é")

    @pytest.mark.parametrize("encoding", ["utf-8", "ascii", "utf-16", "klingon", "rot13", "hex"])
    def test_told_wrong(self, write, encoding):
        with pytest.raises(SeriesError, match=encoding):
            read_recordings(write(self.TEXT.encode("cp1252")), ["b"], encoding=encoding)

    def test_bytes_that_are_no_text_in_it(self, write):
        with pytest.raises(SeriesError, match="NUL"):
            read_recordings(write(self.TEXT.encode("utf-16-le")), ["b"], encoding="latin-1")


def test_what_a_file_holds_counts_and_not_its_name(write, tmp_path):
    parquet.write_table(pa.table({"a": ["x", "y", "x"]}), tmp_path / "table.csv")
    assert codes(read_recordings(tmp_path / "table.csv", ["a"]), "a") == [[0, 1, 0]]
    assert codes(read_recordings(write("a,b\nx,1\ny,0\nx,1\n", "text.parquet"), ["a"]), "a") == [[0, 1, 0]]


def test_lines_above_the_header(write):
    path = write("Observation;dyad 3\n\na;b\nx;1\ny;0\nx;1\n")
    assert codes(read_recordings(path, ["a", "b"], skip_rows=2), "b") == [[1, 0, 1]]
    with pytest.raises(SeriesError, match="below the 9 rows"):
        read_recordings(path, ["a"], skip_rows=9)
    with pytest.raises(ConfigError, match="skip_rows: expected a whole number in"):
        read_recordings(path, ["a"], skip_rows=-1)


def test_rows_that_are_steps_with_begin_and_end(write):
    """What looks like a list of events is read where somebody knows better."""
    path = write("start,end,a\n0,1,x\n1,2,y\n2,3,x\n")
    with pytest.raises(SeriesError, match="'start' and 'end'"):
        read_recordings(path, ["a"])
    assert codes(read_recordings(path, ["a"], rows_are_steps=True), "a") == [[0, 1, 0]]


@pytest.mark.parametrize("code", [" NA", "NA", "NA ", '"NA"', '" NA"', " ", '""', "nan", " null", "#N/A"])
def test_missing_codes_with_blanks_around_them(write, code):
    path = write(f"a, b\nx, 1\ny,{code}\nx, 1\ny, 0\n")
    data = read_recordings(path, ["a", "b"], missing="break")
    assert codes(data, "b") == [[1, 0]]
    assert data.labels["b"] == ("0", "1")
    with pytest.raises(SeriesError, match="1 missing values, the first in data row 2"):
        read_recordings(path, ["a", "b"])


def test_missing_codes_in_parquet(tmp_path):
    table = pa.table({"a": ["x", " NA", "y", "x"], "b": [1.0, float("nan"), 0.0, 1.0]})
    parquet.write_table(table, tmp_path / "seen.parquet")
    for name in "ab":
        assert len(read_recordings(tmp_path / "seen.parquet", [name], missing="break").columns[name][0]) == 2


def test_names_of_recordings_may_look_like_numbers(write):
    """An id is a name: the same ones as text give the same."""
    ids, text = ("12.1", "12.2", "13.1", "13.10"), "who,a,b\n"
    rows = [(name, step % 2, step % 3) for name in ids for step in range(4)]
    data = read_recordings(write(text + "".join(f"{i},{a},{b}\n" for i, a, b in rows)), ["a", "b"], recording="who")
    named = read_recordings(write(text + "".join(f"d{i},{a},{b}\n" for i, a, b in rows)), ["a", "b"], recording="who")
    assert (data.transitions, len(set(data.groups))) == (12, 4)
    assert [codes(data, name) for name in "ab"] == [codes(named, name) for name in "ab"]
    assert data.groups == named.groups


@pytest.mark.parametrize(
    ("written", "labels"),
    [
        (("1,0", "2,0", "1"), ("1", "2")),
        (("10", "9,0", "-1,0"), ("-1", "9", "10")),
        (("0,5", "low", "0,7"), ("0,5", "0,7", "low")),
        (("1" * 400, "2", "1e400"), ("1" * 400, "1e400", "2")),
    ],
)
def test_numbers_with_a_comma_are_numbers(write, written, labels):
    path = write("a;b\n" + "".join(f"{text};1\n" for text in written))
    assert read_recordings(path, ["a"]).labels["a"] == labels


def test_missing_is_checked_from_python(write):
    with pytest.raises(ConfigError, match="missing: expected one of error, break"):
        read_recordings(write("a\n1\n2\n"), ["a"], missing="ignore")


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


def test_columns_by_the_names_that_they_had(write):
    """A column of the package's own tables that has been renamed; somebody's own column of the old name comes first."""
    path = write("step,red_visible,seen\n1,yes,a\n2,no,b\n3,yes,a\n")
    with pytest.warns(RenamedWarning, match="'red_seen' is now called 'red_visible'"):
        data = read_recordings(path, ["red_seen", "seen"])
    assert data.labels == {"red_seen": ("no", "yes"), "seen": ("a", "b")}


def test_names_of_columns(write):
    path = write("mother,infant\na,b\nb,a\na,a\n")
    single = read_recordings(path, "mother")
    assert list(single.columns) == ["mother"]
    assert repr(single) == "Recordings(3 rows, 1 recording, 1 column: mother)"
    for wrong in ([], "", [3]):
        with pytest.raises(SeriesError, match="column"):
            read_recordings(path, wrong)
