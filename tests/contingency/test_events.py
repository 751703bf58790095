"""Variables, and the events that can be made of them."""

import pytest

from jointattn_mj.contingency.online.events import Event, Variable, Variables
from jointattn_mj.errors import ConfigError

FEW = Variables(
    sensors=(Variable("face", ("left", "right", "away")), Variable("ball", ("no", "yes"))),
    actions=(Variable("gaze", ("left", "right")),),
    results=(Variable("joy", ("no", "yes")), Variable("light", ("off", "on"))),
)


def test_every_triple_once_results_innermost():
    events = list(FEW.events())
    assert events[:3] == [Event(0, 0, 0), Event(0, 0, 1), Event(1, 0, 0)]
    assert len(events) == len(set(events)) == 2 * 1 * 2


def test_a_module_brings_a_sensor_and_an_action():
    grown = FEW.with_module("first").with_module("second")
    assert [sensor.name for sensor in grown.sensors] == ["face", "ball", "first before", "second before"]
    assert [action.name for action in grown.actions] == ["gaze", "first now", "second now"]
    assert grown.actions[1].values == ("not used", "used")
    assert grown.results == FEW.results
    assert grown.modules == 2
    assert grown.joints == FEW.joints == FEW.actions
    assert len(list(grown.events())) == 4 * 3 * 2
    assert [event for event in grown.events() if event in set(FEW.events())] == list(FEW.events())


def test_words():
    assert FEW.describe(Event(1, 0, 1)) == "ball, gaze -> light"
    grown = FEW.with_module("module 1")
    assert grown.describe(Event(2, 1, 0)) == "module 1 before, module 1 now -> joy"
    assert grown.symbol(Event(1, 0, 1)) == "(S2, A1, R2)"
    assert grown.symbol(Event(2, 1, 0)) == "(Π1, Π1, R1)"


@pytest.mark.parametrize("values", [(), ("same", "same")])
def test_values_that_cannot_be_told_apart(values):
    with pytest.raises(ConfigError, match=r"ball.*\(" + "".join(f".{value}.*" for value in values)):
        Variable("ball", values)


@pytest.mark.parametrize("missing", ["sensors", "actions", "results"])
def test_nothing_to_be_contingent_on(missing):
    parts = {"sensors": FEW.sensors, "actions": FEW.actions, "results": FEW.results, missing: ()}
    with pytest.raises(ConfigError, match="at least one"):
        Variables(**parts)
