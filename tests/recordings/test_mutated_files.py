"""Damaged files of every kind: a named error, or all that they say; never a traceback, nothing dropped in silence."""

import csv
import io

import numpy as np
import pyarrow as pa
import pytest
from coded_files import FILES, GAZE, RATE, as_parquet, content, workbook

from jointattn_mj import recordings
from jointattn_mj.errors import JointAttnError

CODES = {code for _, code, _, _ in GAZE}
QUICK, ALL = range(6), range(6, 66)
STEPS = [("who", "a", "b"), *((str(i // 20), "xyz"[i % 3], "uv"[i // 2 % 2]) for i in range(40))]
"""A table of steps."""
TABLES = {
    "steps": "".join(f"{','.join(row)}\n" for row in STEPS).encode(),
    "steps in parquet": as_parquet(pa.table({name: list(column) for name, *column in zip(*STEPS, strict=True)})),
    "steps in excel": workbook(STEPS),
}
PIECES = [
    b"\0",
    b'"',
    b"\t",
    b",",
    b";",
    b"\n",
    b"\r",
    b"\xff\xfe",
    b"\xe8",
    b"NA",
    b"-1",
    b"1e9",
    b"0:0",
    b"<",
    b">",
    b"&x;",
]
"""What is put into files."""
ROW_AN_EVENT = {
    "elan text",
    "elan text without a header",
    "elan text side by side",
    "boris aggregated",
    "interact",
    "commas",
}


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """The file with one to three things wrong."""
    for _ in range(rng.integers(1, 4)):
        at, length = (int(rng.integers(0, max(len(data), 1))) for _ in range(2))
        length = length % 40 + 1
        lines = data.split(b"\n")
        first, second = (int(rng.integers(0, len(lines))) for _ in range(2))
        match rng.integers(0, 8):
            case 0:
                data = data[:at] + bytes([int(rng.integers(0, 256))]) + data[at + 1 :]
            case 1:
                data = data[:at] + data[at + length :]
            case 2:
                data = data[:at] + data[at : at + length] * 2 + data[at + length :]
            case 3:
                data = data[:at]
            case 4:
                data = data[:at] + PIECES[rng.integers(0, len(PIECES))] + data[at:]
            case 5:
                lines[first], lines[second] = lines[second], lines[first]
                data = b"\n".join(lines)
            case 6:
                data = b"\n".join(lines[:first] + lines[first + 1 :])
            case 7:
                data = b"\n".join([*lines[:first], lines[second], *lines[first:]])
    return data


def events_by_rows(kind, text):
    """Events of a table, counted by the rows below its header, or by their codes where several share a row."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n")
    rows = list(csv.reader(io.StringIO(lines), delimiter="," if kind in ("boris aggregated", "commas") else "\t"))
    without = kind == "elan text without a header" or rows[0][-1] in CODES  # as when the header is what went missing
    below = rows[0 if without else 1 :]
    if kind in ("elan text side by side", "interact"):
        return sum(bool(cell.strip()) for row in below for cell in row[-2:])
    return sum(any(cell.strip() for cell in row) for row in below)


def check(kind, data, path):
    """A named error, or as many events as rows and as many steps as before."""
    path.write_bytes(data)
    try:
        coding = recordings.read(path, rate=RATE, absent="nothing", overlaps="combine", missing="break", recording=None)
        if kind in TABLES:
            coding.steps()
            return "read"
        events = coding.events
        coding.steps(0.1)
    except JointAttnError as error:
        words = str(error)
        assert words and "\n" not in words and len(words) < 1500, words
        return "refused"
    if kind in ROW_AN_EVENT and not events.remarks and set(events.tier_names) <= {"infant", "mother"}:
        assert len(events) == events_by_rows(kind, data.decode())
    return "read"


@pytest.mark.parametrize("kind", [*FILES, *TABLES])
def test_some(kind, tmp_path):
    whole = TABLES[kind] if kind in TABLES else content(kind)
    ends = {check(kind, mutated(whole, np.random.default_rng([seed, len(kind)])), tmp_path / "x") for seed in QUICK}
    assert ends <= {"read", "refused"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*FILES, *TABLES])
def test_sixty_of_each(kind, tmp_path):
    whole = TABLES[kind] if kind in TABLES else content(kind)
    ends = [check(kind, mutated(whole, np.random.default_rng([seed, len(kind)])), tmp_path / "x") for seed in ALL]
    assert {"read", "refused"} >= set(ends)
    print(kind, ends.count("read"), "read,", ends.count("refused"), "refused")
