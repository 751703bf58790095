"""Tables of codings, for ``measure`` and ``discover``: damaged, renamed, of other encodings, of odd values."""

import csv
import io
import random
from collections.abc import Callable, Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tools.reliability.inputs.damage import damaged, write
from tools.reliability.malformed import Input, numbers, refused
from tools.shell import Outcome

MEASURE = ("--source", "her_gaze", "--condition", "my_gaze", "--target", "toy_seen", "--surrogates", "50")
DISCOVER = ("--sensors", "her_gaze", "--actions", "my_gaze", "--results", "toy_seen", "--surrogates", "50")
ALONE = 6
"""Of so many tables one is read in an interpreter of its own: threads of a reader can end it with a signal."""


def codings() -> dict[str, list[str]]:
    """Columns of a recording: the toy is seen after both have looked at the same place."""
    chance = random.Random(0)
    mothers, mine = ([chance.choice(["left", "right", "door"]) for _ in range(300)] for _ in range(2))
    seen = ["no", *("yes" if a == b else "no" for a, b in zip(mothers[:-1], mine[:-1], strict=True))]
    return {"her_gaze": mothers, "my_gaze": mine, "toy_seen": seen}


def as_csv(columns: dict[str, list], delimiter: str = ",") -> str:
    text = io.StringIO()
    table = csv.writer(text, delimiter=delimiter, lineterminator="\n")
    table.writerow(columns)
    table.writerows(zip(*columns.values(), strict=False))
    return text.getvalue()


def as_parquet(columns: dict[str, list]) -> bytes:
    sink = pa.BufferOutputStream()
    pq.write_table(pa.table(columns), sink)
    return sink.getvalue().to_pybytes()


def odd_tables() -> Iterator[tuple[str, str, bytes, Callable[[Outcome], str]]]:
    """What, name of the file, contents, and which result will do."""
    good, text = codings(), as_csv(codings())
    steps = len(good["her_gaze"])
    yield "nothing", "t.csv", b"", refused
    yield "a header alone", "t.csv", text.splitlines(True)[0].encode(), refused
    yield "one row", "t.csv", "".join(text.splitlines(True)[:2]).encode(), refused
    yield "UTF-16", "t.csv", text.encode("utf-16"), numbers
    yield "UTF-16 without a mark", "t.csv", text.encode("utf-16-le"), numbers
    yield "Latin-1 in a header", "t.csv", text.replace("toy_seen", "toy_seen,vu_mère").encode("latin-1"), numbers
    yield "Latin-1 in a row", "t.csv", text.replace("door", "tür").encode("latin-1"), numbers
    yield "Parquet called CSV", "t.csv", as_parquet(good), numbers
    yield "CSV called Parquet", "t.parquet", text.encode(), numbers
    yield "CSV called nothing", "t", text.encode(), numbers
    yield "NUL bytes", "t.csv", text.replace("door", "do\0r").encode(), numbers
    yield "an open quote", "t.csv", text.replace("door", '"door', 1).encode(), numbers
    yield "a column twice", "t.csv", text.replace("my_gaze", "her_gaze", 1).encode(), refused
    yield "rows of other lengths", "t.csv", text.replace("left,", "left,,,", 1).encode(), refused
    yield "a field of a megabyte", "t.csv", text.replace("door", "d" * 2**20, 1).encode(), numbers
    yield "fractions", "t.csv", as_csv(good | {"toy_seen": [str(k / 7) for k in range(steps)]}).encode(), refused
    yield (
        "decimal commas",
        "t.csv",
        as_csv(good | {"toy_seen": [f"{k / 7:.3f}".replace(".", ",") for k in range(steps)]}, ";").encode(),
        refused,
    )
    for value in ("nan", "inf", "1e308", "9" * 40):
        yield f"only {value}", "t.csv", as_csv(good | {"toy_seen": [value] * steps}).encode(), numbers
    yield "missing values", "t.csv", as_csv(good | {"toy_seen": ["", *good["toy_seen"][1:]]}).encode(), refused
    yield "a value a row", "t.csv", as_csv(good | {"toy_seen": [f"v{k}" for k in range(steps)]}).encode(), numbers
    for name, column in {
        "lists": [[1, 2]] * steps,
        "nulls": pa.nulls(steps),
        "NaN": [float("nan")] * steps,
        "infinity": [float("inf")] * steps,
        "large numbers": [2**63 - 1, -(2**63)] * (steps // 2),
        "bytes": [b"\xff\xfe"] * steps,
        "structures": [{"a": 1}] * steps,
        "times": pa.array([0] * steps, pa.timestamp("ns")),
        "truth values": [True, False] * (steps // 2),
    }.items():
        worthless = name in ("nulls", "NaN", "infinity")
        yield (
            f"Parquet of {name}",
            "t.parquet",
            as_parquet(good | {"toy_seen": column}),
            (refused if worthless else numbers),
        )
    yield "Parquet without rows", "t.parquet", as_parquet({name: pa.nulls(0, pa.string()) for name in good}), refused


def inputs(chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Tables for ``measure`` and ``discover``.

    Args:
        chance: Draws what is damaged, and how.
        many: Number of inputs.
        folder: For their files.
    """
    crafted = list(odd_tables())
    sources = {"t.csv": as_csv(codings()).encode(), "t.parquet": as_parquet(codings())}
    for number in range(many):
        if number < len(crafted):
            what, name, raw, result = crafted[number]
        else:
            name = chance.choice(list(sources))
            what, raw = damaged(sources[name], chance)
            what, result = f"{name} {what}", numbers
        path = write(folder / f"table{number}" / name, raw)
        command = ("measure", str(path), *MEASURE) if number % 2 else ("discover", str(path), *DISCOVER)
        yield Input("tables", f"{command[0]}: {what}", command, result=result, alone=number % ALONE == 0)
        if number % ALONE == 1:
            misspelt = tuple(word.replace("her_gaze", "hre_gaze") for word in command)
            yield Input("tables", f"{command[0]}: {what}, a column misspelt", misspelt, result=refused, alone=True)
