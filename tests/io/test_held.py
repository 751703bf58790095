"""Tuples that compiled code is handed once: what it changes in them is seen, and nothing is lost or kept too long."""

import gc
import os
import subprocess
import sys
import weakref
from typing import NamedTuple

import numpy as np
import pytest

from jointattn_mj.io.compiled import njit
from jointattn_mj.io.held import Held


class Drawing(NamedTuple):
    counts: np.ndarray
    wide: tuple[np.ndarray, float]
    random: np.random.Generator


@njit
def hold(drawing):
    return Held(drawing)


@njit
def draw(held):
    drawn = held.value.random.random()
    held.value.counts[int(10 * drawn)] += 1
    return drawn + held.value.wide[0].sum() * held.value.wide[1]


def new(seed):
    return Drawing(np.zeros(10, np.int64), (np.ones((2, 3)), 2.0), np.random.default_rng(seed))


def test_arrays_and_random_numbers_are_shared():
    drawing, twin = new(1), new(1)
    held = hold(drawing)
    drawn = [draw(held) - 12 for _ in range(100)]
    assert drawn == pytest.approx(twin.random.random(100))
    assert drawing.counts.sum() == 100
    assert drawing.random.random() == twin.random.random()


def test_arrays_stay_as_long_as_they_are_held():
    drawing = new(1)
    known, held = weakref.ref(drawing.counts), hold(drawing)
    del drawing
    gc.collect()
    draw(held)
    assert known() is not None
    del held
    gc.collect()
    assert known() is None


def test_it_works_uncompiled():
    code = "from jointattn_mj.io.held import Held; print(Held((1, 2)).value)"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, capture_output=True, check=True,
    )  # fmt: skip
    assert done.stdout.split() == [b"(1,", b"2)"]
