"""Events and the way to equal steps: against a slow count, and what a reader must be told."""

import numpy as np
import pytest

from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.io.table import Table
from jointattn_mj.recordings import Events


def on_one_tier(*rows, tier="a", **more):
    """Events of one tier from (code, onset, offset)."""
    codes, onset, offset = zip(*rows, strict=True)
    return Events.of([tier] * len(rows), codes, onset, offset, **more)


def values(steps, tier="a"):
    return [[steps.labels[tier][code] for code in part] for part in steps.columns[tier]]


class TestModel:
    def test_order_and_names(self):
        events = Events.of(["b", "a", "b"], ["x", None, "y"], [2, 0, 1], [3, 0.5, 2], ["r2", "r1", "r2"])
        assert events.recordings == ("r2", "r1")
        assert events.tier_names == ("b", "a")
        assert events.table["onset"].tolist() == [1, 2, 0]
        assert events.table["code"].tolist() == ["y", "x", None]
        assert repr(events) == "Events(3 events, 2 tiers, 2 recordings)"
        assert isinstance(events.table, Table)
        assert len(events) == 3

    def test_some_of_them(self):
        events = Events.of(["b", "a", "b"], list("xyz"), [0, 0, 1], [1, 1, 2], ["r2", "r1", "r2"], tiers={"r1": ("c",)})
        assert events.tiers == {"r1": ("c", "a"), "r2": ("b",)}
        some = events.select(["a", "c"])
        assert (len(some), some.tiers) == (1, {"r1": ("c", "a"), "r2": ()})
        assert events.select(recordings=["r2"]).tiers == {"r2": ("b",)}
        for wrong in ({"tiers": ["d"]}, {"recordings": ["r3"]}):
            with pytest.raises(SeriesError, match=r"there is no (tier 'd'|recording 'r3')"):
                events.select(**wrong)

    def test_together(self):
        infant, mother = on_one_tier(("x", 0, 1), tier="infant"), on_one_tier(("y", 0.5, 1), tier="mother")
        both = infant.joined(mother)
        assert both.tiers == {"1": ("infant", "mother")}
        assert both.table["code"].tolist() == ["x", "y"]

    @pytest.mark.parametrize(
        ("columns", "words"),
        [
            ((["a"], ["x"], [0], [1, 2]), "equally long; got 1, 1, 1, 1, 2 rows"),
            ((["a"], ["x"], [2], [1]), "'x' on 'a'.*ends at 1 s, before it begins at 2 s"),
            ((["a"], ["x"], ["now"], [1]), "onset must be numbers"),
            ((["a"], ["x"], [0], [float("nan")]), "offset must lie within"),
        ],
    )
    def test_what_cannot_be(self, columns, words):
        with pytest.raises(SeriesError, match=words):
            Events.of(*columns)


@pytest.mark.parametrize("step", [0.1, 0.07, 1 / 30, 0.25, 0.5])
@pytest.mark.parametrize("value_at", ["middle", "most"])
def test_against_a_slow_count(step, value_at):
    rng = np.random.default_rng(int(step * 1000))
    for _ in range(20):
        times = np.unique([0, 3000, *rng.integers(1, 3000, 2 * rng.integers(2, 20))])
        onset, offset = times[: len(times) // 2 * 2 : 2] * 1000, times[1::2] * 1000
        code = rng.integers(0, 4, len(onset)).astype(str)
        events = on_one_tier(*zip(code, onset / 1e6, offset / 1e6, strict=True))
        (found,) = values(events.steps(step, value_at=value_at, span="all", slack=0))
        edges = onset[0] + np.rint(np.arange(len(found) + 1) * step * 1e6).astype(int)
        assert len(found) == int((offset[-1] - onset[0]) / 1e6 / step + 1e-6)
        for i, value in enumerate(found):
            first, last, middle = edges[i], edges[i + 1], onset[0] + round((i + 0.5) * step * 1e6)
            if value_at == "middle":
                assert value == next(
                    (c for c, a, b in zip(code, onset, offset, strict=True) if a <= middle < b), "(none)"
                )
            else:
                lasts = {}
                for c, a, b in zip(code, onset, offset, strict=True):
                    lasts[c] = lasts.get(c, 0) + max(min(b, last) - max(a, first), 0)
                lasts["(none)"] = last - first - sum(lasts.values())
                assert lasts[value] == max(lasts.values())


class TestWhatAStepIs:
    def test_nothing(self):
        events = on_one_tier(("x", 0, 1), ("y", 2, 3))
        assert values(events.steps(0.5)) == [["x", "x", "(none)", "(none)", "y", "y"]]
        steps = events.steps(0.5, nothing="missing")
        assert values(steps) == [["x", "x"], ["y", "y"]]
        assert steps.groups == [0, 0]
        assert (steps.rows, steps.cut, steps.step) == (6, 2, 0.5)
        assert steps.labels["a"] == ("x", "y")

    def test_most_is_of_one_code_in_all(self):
        """Two short looks at x are more than one look at y."""
        events = on_one_tier(("x", 0, 0.3), ("y", 0.3, 0.7), ("x", 0.7, 1), ("y", 1, 2))
        assert values(events.steps(1, value_at="most")) == [["x", "y"]]

    def test_the_earlier_of_two_that_last_equally_long(self):
        assert values(on_one_tier(("y", 0, 0.5), ("x", 0.5, 2)).steps(1, value_at="most")) == [["y", "x"]]

    def test_frames_and_milliseconds_between_events(self):
        """Gaps and overlaps that come from how offsets are written."""
        gaps = on_one_tier(("x", 0, 0.46), ("y", 0.5, 1), resolution=0.04)
        assert values(gaps.steps(0.1)) == [["x"] * 5 + ["y"] * 5]
        assert values(gaps.steps(0.1, slack=0))[0][4] == "x"
        assert values(on_one_tier(("x", 0, 0.44), ("y", 0.5, 1)).steps(0.1))[0][4] == "(none)"
        overlap = on_one_tier(("x", 0, 0.501), ("y", 0.5, 1))
        assert values(overlap.steps(0.5)) == [["x", "y"]]
        with pytest.raises(SeriesError, match="overlap"):
            overlap.steps(0.5, slack=0)

    def test_overlaps(self):
        events = on_one_tier(("look", 0, 1), ("smile", 0.5, 1.5), ("look", 2, 3), recording="d1")
        words = r"'a' of recording 'd1': 'look' 0 to 1 s and 'smile' 0.5 to 1.5 s. Mend.*`overlaps='combine'`"
        with pytest.raises(SeriesError, match=words):
            events.steps(0.5)
        steps = events.steps(0.5, overlaps="combine")
        assert values(steps) == [["look", "look & smile", "smile", "(none)", "look", "look"]]

    def test_many_overlaps(self):
        """A long event around others, one within another, one twice."""
        events = on_one_tier(("x", 0, 10), ("y", 1, 2), ("y", 1, 2), ("z", 3, 6), ("y", 4, 5))
        with pytest.raises(SeriesError, match=r"'x' 0 to 10 s and 'y' 1 to 2 s; .*, and 1 more"):
            events.steps(1)
        found = values(events.steps(1, overlaps="combine"))
        assert found == [["x", "x & y", "x", "x & z", "x & y & z", "x & z", "x", "x", "x", "x"]]

    def test_a_code_that_is_called_like_a_combination(self):
        events = on_one_tier(("x & y", 0, 1), ("x", 1, 2), ("y", 1.5, 2))
        with pytest.raises(SeriesError, match="'x & y' is a code, and a combination"):
            events.steps(0.5, overlaps="combine")

    def test_point_events(self):
        """A moment has its step, wherever in it, but for what is coded there already."""
        events = on_one_tier(("x", 0, 1), ("nod", 1.99, 1.99), ("x", 2.5, 3), ("nod", 3, 3))
        assert values(events.steps(0.5)) == [["x", "x", "(none)", "nod", "(none)", "nod"]]
        inside = on_one_tier(("x", 0, 1), ("nod", 0.6, 0.6))
        with pytest.raises(SeriesError, match=r"'nod' and 'x' are both in the step at 0.5 s, as one is a point event"):
            inside.steps(0.5)
        assert values(inside.steps(0.5, overlaps="combine")) == [["x", "nod & x"]]
        three = on_one_tier(("x", 0, 1), ("p", 0.6, 0.6), ("q", 0.7, 0.7))
        assert values(three.steps(0.5, overlaps="combine")) == [["x", "p & q & x"]]

    def test_what_is_too_short(self):
        steps = on_one_tier(("x", 0, 1.01), ("y", 1.01, 1.1), ("x", 1.1, 2)).steps(1)
        assert values(steps) == [["x", "x"]]
        assert steps.labels["a"] == ("x",)
        assert steps.notes() == ("1 event of 'a' is in no step of 1 s; a shorter step has it",)

    def test_unknown_codes(self):
        events = on_one_tier(("x", 0, 1), (None, 1, 2), ("y", 2, 3))
        with pytest.raises(SeriesError, match="missing codes in 2 steps, the first at 1 s"):
            events.steps(0.5)
        assert values(events.steps(0.5, missing="break")) == [["x", "x"], ["y", "y"]]


class TestFromWhenToWhen:
    def looks(self):
        """Gaze without gaps up to 6 s, and two smiles in 10 s."""
        gaze = [("gaze", "xy"[i % 2], i, i + 1.0) for i in range(6)]
        smile = [("smile", "s", 2.5, 3.0), ("smile", "s", 9.0, 10.0)]
        tier, code, onset, offset = zip(*gaze, *smile, strict=True)
        return Events.of(tier, code, onset, offset)

    def test_end_of_coding(self):
        """What is coded without gaps ends where its last event ends; what is coded now and then does not."""
        events = self.looks()
        steps = events.steps(0.5)
        assert steps.rows == 12
        assert steps.notes() == (
            "1 recording (1) is cut at the ends, by 4 s in all, where a tier was not coded; the span 'all' keeps them",
        )
        assert events.steps(0.5, "smile").rows == 20
        assert events.steps(0.5, span="all").rows == 20
        assert events.steps(0.5, span="common").rows == 7

    def test_as_the_file_says(self):
        events = on_one_tier(("x", 1, 2), spans={"1": (0.0, 4.0)})
        assert values(events.steps(1)) == [["(none)", "x", "(none)", "(none)"]]

    def test_a_tier_that_says_when_there_was_coding(self):
        events = self.looks().joined(Events.of(["seen"] * 2, ["yes"] * 2, [0, 4.2], [2, 6]))
        steps = events.steps(0.5, ["gaze", "smile"], coded="seen")
        assert [len(part) for part in steps.columns["gaze"]] == [4, 3]
        phases = self.looks().joined(Events.of(["phase"] * 2, ["play", "rest"], [0, 2.2], [2.2, 6]))
        assert [len(part) for part in phases.steps(0.5, ["gaze", "smile"], coded="phase").columns["gaze"]] == [12]
        with pytest.raises(SeriesError, match="no tier 'seen'"):
            self.looks().steps(0.5, coded="seen")

    def test_recordings_stay_apart(self):
        events = Events.of(["a"] * 4, list("xyxx"), [0, 0, 10, 0], [1, 1.2, 11, 0.9], ["r1", "r2", "r3", "r4"])
        steps = events.steps(0.5)
        assert (steps.groups, steps.names) == ([0, 1, 2], ("r1", "r2", "r3", "r4"))
        assert steps.notes()[1:] == (
            "1 recording (r4) is left out, for want of two coded steps that follow each other",
        )
        assert values(steps) == [["x", "x"], ["y", "y"], ["x", "x"]]

    def test_a_recording_without_a_tier(self):
        events = Events.of(["a", "b", "a"], list("xyx"), [0, 0, 0], [1, 1, 1], ["r1", "r1", "r2"])
        with pytest.raises(SeriesError, match=r"recording 'r2' has no tier 'b'.*`absent='nothing'`"):
            events.steps(0.5)
        assert values(events.steps(0.5, absent="nothing"), "b") == [["y", "y"], ["(none)", "(none)"]]
        assert events.steps(0.5, absent="leave_out").names == ("r1",)


@pytest.mark.parametrize(
    ("step", "options", "error", "words"),
    [
        (0, {}, ConfigError, "step: expected a number"),
        ("1", {}, ConfigError, "step"),
        (1000, {}, SeriesError, "no two coded steps of 1000 s"),
        (1e-6, {}, SeriesError, "no more than 200,000,000 can be held"),
        (1, {"value_at": "end"}, ConfigError, "value_at: expected one of middle, most"),
        (1, {"tiers": "b"}, SeriesError, "no tier 'b'"),
        (1, {"tiers": []}, SeriesError, "no tier to sample"),
    ],
)
def test_what_cannot_be_sampled(step, options, error, words):
    events = on_one_tier(("x", 0, 1), ("y", 1, 2), ("z", 1000, 1001))
    with pytest.raises(error, match=words):
        events.steps(step, **options)


def test_ten_tiers_of_an_hour():
    """At 50 steps a second, with looks of half a second."""
    rng = np.random.default_rng(0)
    tier, code, onset, offset = [], [], [], []
    for number in range(10):
        times = np.round(np.cumsum(0.01 + rng.exponential(0.5, 7000)), 3)
        times = times[times < 3600]
        tier += [f"t{number}"] * (len(times) - 1)
        code += rng.choice(list("abc"), len(times) - 1).tolist()
        onset += times[:-1].tolist()
        offset += times[1:].tolist()
    steps = Events.of(tier, code, onset, offset).steps(0.02)
    assert len(steps.columns) == 10
    assert steps.rows > 170_000
