"""Folders of runs that were killed, of which one file is not what it was: damaged, made up, or another run's."""

import hashlib
import io
import json
import os
import pickle
import random
import shutil
import signal
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from tools.reliability.folders import contents, differences
from tools.reliability.inputs.damage import damaged
from tools.reliability.inputs.weights import finite
from tools.reliability.malformed import Input, anything, refused
from tools.reliability.subjects import LIMIT_S, VIDEO, Run
from tools.shell import Outcome, Shell

STATE = "session --perception state --minutes 4 --checkpoint-minutes 0.5"
RENDERED = "develop rendered --steps 300 --rendered.exploration 120 --checkpoint-every 50"
REALTIME = "develop realtime --realtime.perception state --realtime.familiarise-minutes 0.4 --checkpoint-every 20"
PERCEIVE = f"perceive {VIDEO} --checkpoint-minutes 0.01"
RUNS = tuple(
    tuple(command.split())
    for command in (
        f"{STATE} --seed 1",
        "develop table --preset fast --steps 100000 --checkpoint-every 10000",
        f"{RENDERED} --seed 1",
        f"{REALTIME} --minutes 3 --seed 1",
        f"{STATE} --preset cross_situational",
        "develop table --preset local --steps 4000 --checkpoint-every 500",
        f"{RENDERED} --resolution growing",
        f"{RENDERED} --maps continuous",
        f"{REALTIME} --minutes 3 --preset local",
        "session --minutes 0.4 --robot.familiarise.minutes 0.2 --checkpoint-minutes 0.05",
        f"{PERCEIVE} --no-overlay",
        f"{PERCEIVE} --looks",
        f"{PERCEIVE} --detector templates",
    )
)
FROM_PYTHON = """
import sys
from jointattn_mj.cli.parsing import parsed
from jointattn_mj.errors import JointAttnError
try:
    parsed({command!r}, {arguments!r})()
except JointAttnError as error:
    print(f"{{type(error).__name__}}: {{error}}", file=sys.stderr)
    sys.exit(2)
"""
"""What a command calls, without what makes a line of whatever that raises."""


def stopped(arguments: tuple[str, ...], out: Path) -> None:
    """Start a run and kill it when it has gone some way."""
    run = Run([*arguments, "--out", str(out)])
    checkpoint = out / "checkpoint.bin"
    until = time.monotonic() + LIMIT_S
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


def inputs(shell: Shell, chance: random.Random, many: int, folder: Path, video: Path) -> Iterator[Input]:
    """Folders of runs that were stopped, of which one file is not what it was; ``--resume`` refuses, or the results are
    those of a run in peace.

    Args:
        shell: Runs commands.
        chance: Draws what is damaged, and how.
        many: Number of inputs.
        folder: For their files.
        video: A video to perceive.
    """
    left, peace = [], []
    runs = [tuple(str(video) if word == VIDEO else word for word in arguments) for arguments in RUNS]
    for number, arguments in enumerate(runs):
        shell(*arguments, "--out", folder / f"peace{number}")
        peace.append(contents(folder / f"peace{number}"))
        stopped(arguments, folder / f"stopped{number}")
        left.append(folder / f"stopped{number}")
    for number in range(many):
        which = number % len(runs)
        out = folder / f"resumed{number}"
        shutil.copytree(left[which], out)
        names = sorted(path.name for path in out.iterdir() if path.is_file() and path.stat().st_size)
        name = "checkpoint.bin" if chance.random() < 0.75 else chance.choice(names)
        raw = (out / name).read_bytes()
        what, result = _change(out / name, raw, left[which - 1], chance)
        if result is None:
            result = _as_in_peace(peace[which], out, but=name)
        words = (*runs[which], "--out", str(out), "--resume")
        source = "" if number // len(runs) % 2 else FROM_PYTHON.format(command=words[0], arguments=words[1:])
        what = f"{' '.join(runs[which])}, {name}: {what}{' (Python)' if source else ''}"
        yield Input("checkpoints", what, words, source=source, result=result)


def _change(path: Path, raw: bytes, others: Path, chance: random.Random) -> tuple[str, Callable[[Outcome], str] | None]:
    """Make a file another one; what was done, and which result will do (None: the one in peace)."""
    way = chance.choice((*["made up"] * 7, "damaged", "damaged", "another run's", "a folder", "a pickle"))
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
        return f"{way}, {made[0]}", finite(path.parent, anything)
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
    if "state.json" not in members:
        return None
    name = chance.choice(["state.json", chance.choice(list(members))])
    if name.endswith(".json"):
        what, value = twisted(json.loads(members[name]), chance)
        members[name] = json.dumps(value).encode()
    elif chance.random() < 0.5:
        what, members[name] = other_array(members[name], chance)
    else:
        what, members[name] = damaged(members[name], chance)
    sink = io.BytesIO()
    with zipfile.ZipFile(sink, "w") as made:
        for member, content in members.items():
            made.writestr(member, content)
        made.comment = comment[:-64] + b"0" * 64
    content = sink.getvalue()
    return f"{name}: {what}", content[:-64] + hashlib.sha256(content[:-64]).hexdigest().encode()


def other_array(raw: bytes, chance: random.Random) -> tuple[str, bytes]:
    """An array in which one number is exchanged, or of another shape or kind."""
    array = np.lib.format.read_array(io.BytesIO(raw), allow_pickle=False)
    way = chance.choice(("a number", "a number", "all numbers", "longer", "shorter", "another dtype", "an axis more"))
    what = way
    if way in ("a number", "all numbers") and array.size and array.dtype.kind in "fiub":
        place = chance.randrange(array.size)
        number = chance.choice(EXTREMES[array.dtype.kind])
        with np.errstate(all="ignore"):
            number = np.array(number).astype(array.dtype)
            array.reshape(-1)[place if way == "a number" else slice(None)] = number
        what = f"{way} ({place}) becomes {number}"
    elif way == "longer":
        array = np.concatenate([np.atleast_1d(array)] * 2)
    elif way == "shorter":
        array = np.atleast_1d(array)[:-1]
    elif way == "another dtype" and array.dtype.kind in "fiub":
        with np.errstate(all="ignore"):
            array = array.astype(chance.choice([np.float32, np.int8, np.int64, np.uint64, complex, ">f8", "U3"]))
        what = f"{way}, {array.dtype}"
    elif way == "an axis more":
        array = array[None]
    sink = io.BytesIO()
    np.lib.format.write_array(sink, array)
    return what, sink.getvalue()


EXTREMES: dict[str, list] = {
    "f": [np.nan, np.inf, 1e308, -1e308, -1.0, 0.0],
    "i": [0, 1, -1, 100, -(2**62), 2**62, 127, -128],
    "u": [0, 1, 200, 2**62],
    "b": [True, False],
}
"""Numbers by the kind of dtype that are seldom right: none, far too large, or places beyond every end."""


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

    class Touch:
        def __reduce__(self) -> tuple:
            return Path.touch, (canary,)

    body = b"0" * 64 + pickle.dumps(Touch())
    return b"jointattn checkpoint 1\n" + hashlib.sha256(body).hexdigest().encode() + body


def _as_in_peace(peace: dict[str, bytes], out: Path, but: str) -> Callable[[Outcome], str]:
    def check(outcome: Outcome) -> str:
        differing = differences(peace, contents(out))
        differing.pop("config.yaml", None)  # says what was asked for; nothing reads it
        return f"results differ: {differing}" if differing else ""

    return check
