"""The six behaviours of Fig. 5.5: each step is one of them, and the rates are those of the last steps."""

import numpy as np
import pytest

from jointattn_mj.development.behaviour import FG, KEC, NFG, SC, SO, SS, behaviours, moving_rates, phases
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import LOOKS_AT, TableConfig
from jointattn_mj.errors import ConfigError

pytestmark = pytest.mark.integration

SPOTS = 3
AT_ROBOT, NOT_VISIBLE, TO_CAREGIVER = 3, 4, 3


@pytest.mark.parametrize(
    ("face", "before", "gaze", "expected"),
    [
        (0, TO_CAREGIVER, 0, FG),
        (2, TO_CAREGIVER, 2, FG),
        (2, TO_CAREGIVER, 1, NFG),
        (AT_ROBOT, TO_CAREGIVER, 1, NFG),
        (1, TO_CAREGIVER, TO_CAREGIVER, KEC),
        (AT_ROBOT, TO_CAREGIVER, TO_CAREGIVER, KEC),
        (NOT_VISIBLE, 1, TO_CAREGIVER, SC),
        (NOT_VISIBLE, 1, 1, SS),
        (NOT_VISIBLE, 1, 2, SO),
    ],
)
def test_each(face, before, gaze, expected):
    """Of two steps, the second one."""
    assert behaviours(np.array([NOT_VISIBLE, face]), np.array([before, gaze]), SPOTS)[1] == expected


def test_nothing_before_the_first_step():
    assert behaviours(np.array([NOT_VISIBLE]), np.array([0]), SPOTS).tolist() == [SO]
    assert behaviours(np.zeros(0, int), np.zeros(0, int), SPOTS).shape == (0,)


@pytest.mark.parametrize("order", ["caregiver_first", "robot_first"])
@pytest.mark.parametrize("spots", [3, 5])
def test_a_run(order, spots):
    """From where both really look, told in another way."""
    run = TableRun(TableConfig(spots=spots, order=order), PRESETS["thesis"].agent, seed=3, n_steps=3000)
    run.advance(3000)
    gaze, caregivers = run.log("shift gaze").tolist(), run.log(LOOKS_AT).tolist()
    found = behaviours(run.log("caregiver's face"), run.log("shift gaze"), spots)
    before = spots  # a run begins face to face
    for step, (now, theirs) in enumerate(zip(gaze, caregivers, strict=True)):
        if before == spots:
            expected = KEC if now == spots else FG if now == theirs else NFG
        else:
            expected = SC if now == spots else SS if now == before else SO
        assert found[step] == expected, step
        before = now
    assert len(set(found.tolist())) == 6


def test_rates():
    found = np.random.default_rng(0).integers(0, 6, 500)
    steps = np.array([1, 7, 50, 51, 500])
    rates = moving_rates(found, steps, window=50)
    for row, step in zip(rates, steps, strict=True):
        last = found[max(0, step - 50) : step]
        assert np.allclose(row, [(last == number).mean() for number in range(6)])
    assert np.allclose(rates.sum(axis=1), 1)


def test_phases():
    found = np.repeat([FG, SC, SO], [30, 20, 50])
    parts = phases(found, [30, 50], window=10)
    assert [(part.first, part.last) for part in parts] == [(0, 30), (30, 50), (50, 100)]
    assert [part.rates.index(1.0) for part in parts] == [FG, SC, SO]


def test_phases_take_their_own_steps_only():
    """The second is shorter than the window."""
    found = np.repeat([FG, SC, SO], [30, 5, 50])
    assert phases(found, [30, 35], window=1000)[1].rates[SC] == 1.0


@pytest.mark.parametrize(("made", "bounds"), [([], [(0, 40)]), ([40], [(0, 40)]), ([10, 10], [(0, 10), (10, 40)])])
def test_phases_at_the_edges(made, bounds):
    """No module, one with the last step, two at once."""
    assert [(part.first, part.last) for part in phases(np.zeros(40, int), made)] == bounds


def test_series_that_do_not_fit():
    with pytest.raises(ConfigError, match="got 3 and 4"):
        behaviours(np.zeros(3, int), np.zeros(4, int), SPOTS)
