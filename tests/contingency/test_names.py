"""Every measure has one entry in one table, and each of its names is accepted wherever a measure is chosen."""

import numpy as np
import pytest

from jointattn_mj import contingency as c
from jointattn_mj.contingency.names import NAMES, OF_EVENTS, full_name
from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.contingency.significance import MEASURES, TestOptions
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.recordings.discover import DiscoverOptions

EVENT_NAMES = [(each, measure) for measure in NAMES if measure.short in OF_EVENTS for each in measure]


def test_table_agrees_with_the_measures():
    assert {measure.full for measure in NAMES} == set(MEASURES)
    for measure in NAMES:
        assert MEASURES[measure.full].name == measure.symbol
        assert hasattr(c, measure.full)
    every = [each for measure in NAMES for each in {name.lower() for name in measure}]
    assert len(set(every)) == len(every)


@pytest.mark.parametrize(("name", "measure"), [(each, measure) for measure in NAMES for each in measure])
def test_each_name_stands_for_its_measure(name, measure):
    assert {full_name(name), full_name(name.upper()), full_name(name.lower())} == {measure.full}


@pytest.mark.parametrize("name", ["", "sacs", "SA", None, 3])
def test_no_name(name):
    with pytest.raises(SeriesError, match=r"measure: expected one of state_action_contingency \(sac\), "):
        full_name(name)
    with pytest.raises(SeriesError, match="perhaps you meant 'transfer_entropy'"):
        full_name("transfer_entrop")


def test_a_measure_that_does_not_rank_events():
    with pytest.raises(SeriesError, match=r"expected one of state_action_contingency \(sac\), combined.*; got 'te'$"):
        full_name("te", OF_EVENTS)


@pytest.mark.parametrize(("name", "measure"), EVENT_NAMES)
def test_accepted_everywhere(name, measure):
    s, a, r = np.random.default_rng(0).integers(0, 2, (3, 60))
    few = TestOptions(surrogates=5, resamples=0)
    assert DetectorConfig(measure=name) == DetectorConfig(measure=measure.short)
    assert DiscoverOptions("f.csv", ("s",), ("a",), ("r",), measure=name).measure == measure.short
    assert len({c.assess(each, s, r, a, options=few, seed=1).value for each in measure}) == 1
    assert c.local_contingency(s, a, r, name) == c.local_contingency(s, a, r, measure.short)
    data = {"s": s, "a": a, "r": r}
    found = {
        repr(c.discover(data, ["s"], ["a"], ["r"], measure=each, options=few)) for each in measure
    }  # with NaN in it
    assert len(found) == 1


def test_a_config_refuses_others():
    with pytest.raises(ConfigError, match=r"DetectorConfig.measure: expected one of sac, tc; got 'te'"):
        DetectorConfig(measure="te")
