"""Weights for ``session --start-from``: damaged, or right as a file and wrong in what they say."""

import io
import random
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from tools.reliability.inputs.damage import damaged, write
from tools.reliability.malformed import Input, anything, refused
from tools.shell import Outcome, Shell

SESSION = ("session", "--perception", "state", "--minutes", "0.05", "--seed", "1")
ROBOTS = ((), ("--preset", "cross_situational"), ("--robot.learner.code", "linear"))


def inputs(shell: Shell, chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Weights for ``--start-from``.

    Args:
        shell: Runs commands.
        chance: Draws what is damaged, and how.
        many: Number of inputs.
        folder: For their files.
    """
    thought_of, raws = [], []
    for robot in ROBOTS:
        good = folder / f"good{len(raws)}"
        shell(*SESSION, *robot, "--out", good)
        raws.append((good / "weights.npz").read_bytes())
        crafted = odd_weights(_arrays(raws[-1]))
        thought_of += [(robot, *case) for case in crafted]
        thought_of += [(robot, "of another robot", raw, refused) for raw in raws[:-1]]
    chance.shuffle(thought_of)
    for number in range(many):
        if number < min(len(thought_of), many * 4 // 5):
            robot, what, made, result = thought_of[number]
        else:
            robot, raw = chance.choice(list(zip(ROBOTS, raws, strict=True)))
            what, made = damaged(raw, chance)
            result = anything if _same_arrays(made, _arrays(raw)) else refused
        path = write(folder / f"weights{number}" / "weights.npz", made)
        out = folder / f"weights{number}" / "out"
        words = (*SESSION, *robot, "--start-from", str(path), "--out", str(out))
        yield Input("weights", f"{' '.join(robot)} {what}".strip(), words, result=finite(out, result))


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


def _arrays(raw: bytes) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(raw)) as archive:
        return dict(archive)


def _same_arrays(raw: bytes, arrays: dict[str, np.ndarray]) -> bool:
    try:
        with np.load(io.BytesIO(raw), allow_pickle=False) as archive:
            stored = dict(archive)
    except Exception:  # whatever numpy, zipfile and zlib have to say
        return False
    return stored.keys() == arrays.keys() and all(np.array_equal(stored[name], arrays[name]) for name in arrays)


def finite(out: Path, result: Callable[[Outcome], str]) -> Callable[[Outcome], str]:
    """As ``result``; and weights that a session leaves in ``out`` have to be numbers."""

    def check(outcome: Outcome) -> str:
        if wrong := result(outcome):
            return wrong
        if not (out / "weights.npz").exists():
            return ""
        with np.load(out / "weights.npz") as archive:
            bad = [name for name, array in archive.items() if not np.isfinite(array).all()]
        return f"not finite: {', '.join(bad)}" if bad else ""

    return check
