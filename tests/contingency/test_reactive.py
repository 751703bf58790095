"""Reactive modules: the tables that they give, and what is refused."""

import numpy as np
import pytest
from worlds import variables

from jointattn_mj.contingency.online.reactive import AvoidingModule, RandomModule, ReactiveTable
from jointattn_mj.errors import ConfigError

WORLD = variables([3, 2], [4, 2], [2])


def test_random():
    table = RandomModule("a0", trust=2.0).table(WORLD)
    assert (table.joint, table.sensor, table.trust) == ("a0", "s0", 2.0)
    assert table.odds.tolist() == [[0.25] * 4] * 3


def test_avoiding():
    table = AvoidingModule("a0", "2", share=0.25).table(WORLD.with_module("one"))
    assert table.odds == pytest.approx(np.array([[4, 4, 1, 4]] * 3) / 13)
    assert AvoidingModule("a0", "2", share=0).table(WORLD).odds[:, 2].tolist() == [0, 0, 0]
    assert (
        AvoidingModule("a0", "2", share=1).table(WORLD).odds.tolist() == RandomModule("a0").table(WORLD).odds.tolist()
    )


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: RandomModule("tail").table(WORLD), ("tail", "a0", "a1")),
        (lambda: RandomModule("a0", trust=0.0).table(WORLD), ("trust", "0.0")),
        (lambda: RandomModule("a0", trust=float("nan")).table(WORLD), ("trust", "nan")),
        (lambda: AvoidingModule("a0", "2", share=1.5), ("share", "1.5")),
        (lambda: AvoidingModule("a0", "2", share=float("nan")), ("share", "nan")),
        (lambda: AvoidingModule("a0", "9").table(WORLD), ("9", "0", "3")),
        (lambda: ReactiveTable("a0", "s0", np.ones((3, 4)), 1.0), ("a0", "sum")),
        (lambda: ReactiveTable("a0", "s0", np.array([[2.0, -1.0]]), 1.0), ("a0", "sum")),
        (lambda: ReactiveTable("a0", "s0", np.array([1.0]), 1.0), ("a0", "values, commands")),
        (lambda: ReactiveTable("a0", "s0", np.array([[np.nan, 1.0]]), 1.0), ("a0", "sum")),
    ],
)
def test_refused(make, words):
    with pytest.raises(ConfigError) as refused:
        make()
    for word in words:
        assert word in str(refused.value)


def test_a_module_for_a_module_is_no_joint():
    with pytest.raises(ConfigError, match="one now"):
        RandomModule("one now").table(WORLD.with_module("one"))
