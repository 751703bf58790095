"""Files that are damaged, renamed, of another kind, or made up: tables, weights, checkpoints, videos, stored cells."""

import csv
import hashlib
import io
import json
import os
import random
import shutil
import signal
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tools.reliability.folders import contents, differences
from tools.reliability.malformed import Input, anything, numbers, refused
from tools.reliability.subjects import Run
from tools.shell import Outcome, Shell

MEASURE = ("--source", "her_gaze", "--condition", "my_gaze", "--target", "toy_seen", "--surrogates", "50")
DISCOVER = ("--sensors", "her_gaze", "--actions", "my_gaze", "--results", "toy_seen", "--surrogates", "50")


def damaged(raw: bytes, chance: random.Random) -> tuple[str, bytes]:
    """The bytes of a file after something has happened to them, and what."""
    place = chance.randrange(max(1, len(raw)))
    length = chance.choice((1, 4, 64, 4096))
    some = bytes(chance.randrange(256) for _ in range(length))
    made = {
        "cut off": raw[:place],
        "beginning lost": raw[place:],
        "overwritten": raw[:place] + some + raw[place + length :],
        "zeroed": raw[:place] + bytes(length) + raw[place + length :],
        "inserted": raw[:place] + some + raw[place:],
        "part lost": raw[:place] + raw[place + length :],
        "part doubled": raw[: place + length] + raw[place:],
        "a bit turned": raw[:place] + bytes([raw[place] ^ (1 << chance.randrange(8))]) + raw[place + 1 :],
        "longer": raw + some,
        "empty": b"",
        "noise": bytes(chance.randrange(256) for _ in range(512)),
    }
    how = chance.choice(list(made))
    return f"{how} at {place}", made[how]


# Tables

ALONE = 6
"""Of so many tables one is read in an interpreter of its own: threads of a reader can end it with a signal."""


def codings() -> dict[str, list[str]]:
    """Columns of a recording: the toy is seen after both have looked at the same place."""
    chance = random.Random(0)
    hers, mine = ([chance.choice(["left", "right", "door"]) for _ in range(300)] for _ in range(2))
    seen = ["no", *("yes" if a == b else "no" for a, b in zip(hers[:-1], mine[:-1], strict=True))]
    return {"her_gaze": hers, "my_gaze": mine, "toy_seen": seen}


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
    yield "Parquet called CSV", "t.csv", as_parquet(good), refused
    yield "CSV called Parquet", "t.parquet", text.encode(), refused
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


def tables(chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Tables for ``measure`` and ``discover``."""
    crafted = list(odd_tables())
    sources = {"t.csv": as_csv(codings()).encode(), "t.parquet": as_parquet(codings())}
    for number in range(many):
        if number < len(crafted):
            what, name, raw, result = crafted[number]
        else:
            name = chance.choice(list(sources))
            what, raw = damaged(sources[name], chance)
            what, result = f"{name} {what}", numbers
        path = _write(folder / f"table{number}" / name, raw)
        command = ("measure", str(path), *MEASURE) if number % 2 else ("discover", str(path), *DISCOVER)
        yield Input("tables", f"{command[0]}: {what}", command, result=result, alone=number % ALONE == 0)
        if number % ALONE == 1:
            misspelt = tuple(word.replace("her_gaze", "hre_gaze") for word in command)
            yield Input("tables", f"{command[0]}: {what}, a column misspelt", misspelt, result=refused, alone=True)


# Weights

SESSION = ("session", "--perception", "truth", "--minutes", "0.05", "--seed", "1")


def weights(shell: Shell, chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Weights for ``--start-from``."""
    shell(*SESSION, "--out", folder / "good")
    raw = (folder / "good" / "weights.npz").read_bytes()
    with np.load(io.BytesIO(raw)) as archive:
        arrays = dict(archive)
    crafted = list(odd_weights(arrays))
    for number in range(many):
        if number < len(crafted):
            what, made, result = crafted[number]
        else:
            what, made = damaged(raw, chance)
            result = anything if _same_arrays(made, arrays) else refused
        path = _write(folder / f"weights{number}" / "weights.npz", made)
        out = folder / f"weights{number}" / "out"
        yield Input(
            "weights", what, (*SESSION, "--start-from", str(path), "--out", str(out)), result=_finite(out, result)
        )


def odd_weights(arrays: dict[str, np.ndarray]) -> Iterator[tuple[str, bytes, Callable[[Outcome], str]]]:
    """Weights whose file is right and whose numbers are not."""

    def packed(changed: dict[str, np.ndarray]) -> bytes:
        sink = io.BytesIO()
        np.savez(sink, **changed)
        return sink.getvalue()

    for name, array in arrays.items():
        for value in (np.nan, np.inf, 1e308):
            with np.errstate(all="ignore"):
                yield f"{name} = {value}", packed(arrays | {name: np.full(array.shape, value)}), refused
        yield f"no {name}", packed({key: other for key, other in arrays.items() if key != name}), refused
        yield f"{name} of another shape", packed(arrays | {name: np.zeros((3, 1, 2))}), refused
        yield f"{name} of text", packed(arrays | {name: np.full(array.shape, "x")}), refused
        yield f"{name} of objects", packed(arrays | {name: np.full(array.shape, None)}), refused
        yield f"{name} empty", packed(arrays | {name: np.zeros(0)}), refused
        yield f"{name} complex", packed(arrays | {name: array.astype(complex) + 1j}), refused
    yield "a size that is not there", packed(arrays).replace(b"'shape': (", b"'shape': (99999999999, "), refused
    yield "no arrays", packed({}), refused


def _same_arrays(raw: bytes, arrays: dict[str, np.ndarray]) -> bool:
    try:
        with np.load(io.BytesIO(raw), allow_pickle=False) as archive:
            found = dict(archive)
    except Exception:  # whatever numpy, zipfile and zlib have to say
        return False
    return found.keys() == arrays.keys() and all(np.array_equal(found[name], arrays[name]) for name in arrays)


def _finite(out: Path, result: Callable[[Outcome], str]) -> Callable[[Outcome], str]:
    """As ``result``; and what was learned has to be numbers."""

    def check(outcome: Outcome) -> str:
        if wrong := result(outcome):
            return wrong
        with np.load(out / "weights.npz") as archive:
            bad = [name for name, array in archive.items() if not np.isfinite(array).all()]
        return f"not finite: {', '.join(bad)}" if bad else ""

    return check


# Checkpoints

RUNS = (
    ("session", "--perception", "truth", "--minutes", "10", "--checkpoint-minutes", "0.5", "--seed", "1"),
    ("develop", "--preset", "fast", "--steps", "200000", "--checkpoint-every", "10000"),
)


def stopped(arguments: tuple[str, ...], out: Path) -> None:
    """Start a run and kill it when it has gone some way."""
    run = Run([*arguments, "--out", str(out)])
    checkpoint = out / "checkpoint.bin"
    until = time.monotonic() + 120
    first = None
    while run.running() and time.monotonic() < until:
        if checkpoint.exists():
            now = checkpoint.stat().st_mtime_ns
            first = first or now
            if now > first:
                break
        time.sleep(0.002)
    os.kill(run.process.pid, signal.SIGKILL)
    run.end()


def checkpoints(shell: Shell, chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Folders of runs that were stopped, of which one file is not what it was; ``--resume`` refuses, or the results are
    those of a run in peace."""
    left, peace = [], []
    for number, arguments in enumerate(RUNS):
        shell(*arguments, "--out", folder / f"peace{number}")
        peace.append(contents(folder / f"peace{number}"))
        stopped(arguments, folder / f"stopped{number}")
        left.append(folder / f"stopped{number}")
    for number in range(many):
        which = number % len(RUNS)
        out = folder / f"resumed{number}"
        shutil.copytree(left[which], out)
        names = sorted(path.name for path in out.iterdir() if path.is_file() and path.stat().st_size)
        name = "checkpoint.bin" if number % 3 else chance.choice(names)
        raw = (out / name).read_bytes()
        what, result = _change(out / name, raw, left[1 - which], chance, number)
        if result is None:
            result = _as_in_peace(peace[which], out, but=name)
        yield Input(
            "checkpoints", f"{RUNS[which][0]} {name}: {what}", (*RUNS[which], "--out", str(out), "--resume"),
            result=result,
        )  # fmt: skip


def _change(
    path: Path, raw: bytes, others: Path, chance: random.Random, number: int
) -> tuple[str, Callable[[Outcome], str] | None]:
    """Make a file another one; what was done, and which result will do (None: the one in peace)."""
    ways = ("damaged", "made up", "made up", "made up", "damaged", "another run's", "a folder", "a pickle")
    way = ways[number % len(ways)]
    if way == "another run's" and (others / path.name).exists():
        shutil.copy(others / path.name, path)
        return way, refused if path.name == "checkpoint.bin" else None
    if way == "a folder":
        path.unlink()
        path.mkdir()
        return way, refused if path.name == "checkpoint.bin" else None
    if way == "a pickle":
        path.write_bytes(_pickle(path.with_name("canary")))
        return way, lambda outcome: "ran code" if path.with_name("canary").exists() else ""
    if way == "made up" and (made := made_up(raw, chance)) is not None:
        path.write_bytes(made[1])
        return f"{way}, {made[0]}", anything
    what, made_of = damaged(raw, chance)
    path.write_bytes(made_of)
    return what, None


def made_up(raw: bytes, chance: random.Random) -> tuple[str, bytes] | None:
    """A checkpoint that is formally right, digest and all, and holds something else; None if its format is another."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(raw))
        members = {entry.filename: archive.read(entry) for entry in archive.infolist()}
        comment = archive.comment
    except zipfile.BadZipFile:
        return None
    name = chance.choice(["state.json"] * 3 + list(members))
    if name not in members:
        return None
    if name.endswith(".json"):
        what, value = twisted(json.loads(members[name]), chance)
        members[name] = json.dumps(value).encode()
    else:
        what, members[name] = damaged(members[name], chance)
    sink = io.BytesIO()
    with zipfile.ZipFile(sink, "w") as made:
        for member, content in members.items():
            made.writestr(member, content)
        made.comment = comment[:-64] + b"0" * 64
    content = sink.getvalue()
    return f"{name}: {what}", content[:-64] + hashlib.sha256(content[:-64]).hexdigest().encode()


def twisted(value: object, chance: random.Random) -> tuple[str, object]:
    """Plain data with one value in it exchanged for another kind of thing."""
    spots: list[tuple[dict | list, object]] = []

    def collect(part: object) -> None:
        keys = part if isinstance(part, dict) else range(len(part)) if isinstance(part, list) else ()
        for key in keys:
            spots.append((part, key))
            collect(part[key])

    collect(value)
    if not spots:
        return "nothing", None
    part, key = chance.choice(spots)
    other = chance.choice(
        [None, -1, 2**63, 10**400, 1e308, float("nan"), "", "os.system", "x" * 10_000, [], {}, True, [[[[]]]], 0]
    )
    what = f"{str(part[key])[:40]} becomes {str(other)[:20]!r}"
    part[key] = other
    return what, value


def _pickle(canary: Path) -> bytes:
    """What makes a file when it is unpickled, as checkpoints of the first format were."""
    import pickle

    class Touch:
        def __reduce__(self) -> tuple:
            return Path.touch, (canary,)

    body = b"0" * 64 + pickle.dumps(Touch())
    return b"jointattn checkpoint 1\n" + hashlib.sha256(body).hexdigest().encode() + body


def _as_in_peace(peace: dict[str, bytes], out: Path, but: str) -> Callable[[Outcome], str]:
    def check(outcome: Outcome) -> str:
        found = differences(peace, contents(out))
        found.pop("config.yaml", None)  # says what was asked for; nothing reads it
        return f"results differ: {found}" if found else ""

    return check


# Videos


def videos(chance: random.Random, many: int, folder: Path, film: Path) -> Iterator[Input]:
    """Videos for ``perceive``."""
    raw = film.read_bytes()
    crafted = {
        "text.mp4": b"This is no video.\n" * 50,
        "empty.mp4": b"",
        "table.mp4": as_csv(codings()).encode(),
        "list.m3u8": f"#EXTM3U\n#EXTINF:1,\n{film}\n#EXT-X-ENDLIST\n".encode(),
        "list.mp4": f"ffconcat version 1.0\nfile {film}\n".encode(),
        "a:b.avi": b"RIFF\x00\x00\x00\x00AVI LIST",
        "http.m3u8": b"#EXTM3U\n#EXTINF:1,\nhttp://127.0.0.1:9/x.ts\n#EXT-X-ENDLIST\n",
        "image.png": b"\x89PNG\r\n\x1a\n",
    }
    for number in range(many):
        if number < len(crafted):
            name, made = list(crafted.items())[number]
            what, result = name, anything if name.startswith("list") else refused
        else:
            name, result = "table.mp4", anything
            what, made = damaged(raw, chance)
        path = _write(folder / f"video{number}" / name, made)
        out = folder / f"video{number}" / "out"
        command = ("perceive", str(path), "--no-overlay", "--max-minutes", "0.1", "--out", str(out))
        yield Input("videos", what, command, result=result)


# Stored cells


def stores(shell: Shell, chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Folders of experiments of which a file is damaged, for ``list``, ``report`` and ``run``."""
    run = ("experiment", "run", "5.2", "--setting", "robot first", "--runs", "2", "--jobs", "1")
    shell(*run, "--out", folder / "good")
    for number in range(many):
        out = folder / f"store{number}"
        shutil.copytree(folder / "good", out)
        (cell := sorted(out.glob("cells/*/*.json"))[0]).with_name("odd.json").write_text("{}")
        if number % 3 == 0:
            note = _write(out / "failed" / "5.2" / f"{'a' * 32}.json", b'{"setting": "robot first", "seed": 1}')
            path = note
        else:
            path = cell
        what, made = damaged(path.read_bytes(), chance)
        if number % 4 == 3:
            path.unlink()
            path.mkdir()
            what = "a folder"
        else:
            path.write_bytes(made)
        command = (("experiment", "list", "--out", str(out)), ("experiment", "report", str(out)))[number % 2]
        yield Input("stored cells", f"{command[1]}: {path.parent.parent.name} {what}", command)


def _write(path: Path, raw: bytes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(raw)
    return path
