"""A computation of days is refused as soon as its pace is known, and never after that."""

import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.recordings.patience import patient


def watched(total, seconds, reports=3, yes=False):
    """So many reports of 50 draws each, so many seconds one after the other; the draws that were told of."""
    told, times = [], iter(range(10**6))
    watch = patient(told.append, total, yes, clock=lambda: seconds * next(times))
    for _ in range(reports):
        watch(50)
    return told


def test_days_are_refused_in_words():
    with pytest.raises(ConfigError, match=r"1,000,000,000 surrogates .* about 231 days .* `yes=True`"):
        watched(1_000_000_000, 1.0)


def test_what_takes_less_goes_on():
    assert watched(10_000, 1.0) == [50] * 3


def test_draws_that_were_not_needed_say_nothing_of_the_pace():
    times = iter(range(100))
    watch = patient(lambda done: None, 2_000_000_000, False, clock=lambda: next(times))
    watch(100)
    watch(10**9 - 100)
    with pytest.raises(ConfigError, match="days"):
        watch(50)


def test_reports_of_nothing_say_nothing_of_the_pace():
    """Several parts that draw the same surrogates tell of one when all have drawn it."""
    times = iter(range(100))
    watch = patient(lambda done: None, 100, False, clock=lambda: 2 * next(times))
    for done in (1, 0, 0, 1):
        watch(done)


def test_yes_is_yes():
    assert watched(1_000_000_000, 1.0, yes=True) == [50] * 3


def test_it_is_decided_once():
    """A machine that becomes slow later loses nothing that has been drawn."""
    times = iter([0, 2, *(10_000 * k for k in range(1, 50))])
    watch = patient(lambda done: None, 10_000, False, clock=lambda: next(times))
    for _ in range(20):
        watch(50)
