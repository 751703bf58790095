"""Values dyad by dyad, groups of dyads, and lags and methods on the command line."""

import csv
import json

import numpy as np
import pytest
from codings import dyad
from shell import refused

import jointattn_mj.contingency as c
from jointattn_mj.contingency.information import TRANSFER
from jointattn_mj.contingency.table import steps
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.recordings.delays import check_delay, delay_in_steps
from jointattn_mj.recordings.dyads import by_dyad, compare, over_dyads, scan_over_dyads, split

FEW = c.TestOptions(99, resamples=0)


@pytest.fixture(scope="module")
def coding(tmp_path_factory):
    """Six dyads: infants of 12 months follow, those of 6 do not."""
    path = tmp_path_factory.mktemp("dyads") / "dyads.csv"
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["dyad", "age", "mother", "infant", "day"])
        for i in range(6):
            mother, infant = (series[:1500] for series in dyad(np.random.default_rng(i), 1, 0.8 * (i % 2)))
            table.writerows(
                (f"d{i}", (6, 12)[i % 2], m, b, t % 2) for t, (m, b) in enumerate(zip(mother, infant, strict=True))
            )
    return path


def test_split_keeps_recordings_whole():
    parts = [[0, 1, 2], [1, 0], [2, 2, 1, 0]]
    given = steps(parts, parts, groups=[4, 4, 7])
    (first, own), (second, other) = split(given)
    assert (first, second, own.transitions, other.transitions) == (4, 7, 3, 3)
    assert own.columns()[0].tolist() == [0, 1, 1]
    assert TRANSFER.value(other.entries()) == pytest.approx(c.transfer_entropy(parts[2], parts[2]) * np.log(2))


def test_values_of_dyads_are_their_own():
    pairs = [dyad(np.random.default_rng(i), 1, 0.8) for i in range(4)]
    mothers, infants = ([series[:1000] for series in side] for side in zip(*pairs, strict=True))
    names = {i: f"d{i}" for i in range(4)}
    found = by_dyad(steps(mothers, infants), TRANSFER, names, FEW, np.log(2), np.random.SeedSequence(0))
    assert found.names == ("d0", "d1", "d2", "d3")
    for value, mother, infant in zip(found.values, mothers, infants, strict=True):
        assert value.value == pytest.approx(c.transfer_entropy(mother, infant))
    (whole,) = found.groups
    effective = [value.corrected for value in found.values]
    assert whole.mean == pytest.approx(np.mean(effective))
    assert whole.interval[0] < whole.mean < whole.interval[1]
    assert len(found.rows()) == 4
    with pytest.raises(SeriesError, match="at least 2"):
        by_dyad(steps(mothers[0], infants[0]), TRANSFER, {}, FEW, 1.0, np.random.SeedSequence(0))
    with pytest.raises(SeriesError, match="'d1' has no age"):
        by_dyad(steps(mothers, infants), TRANSFER, names, FEW, 1.0, np.random.SeedSequence(0), {"d0": "6"}, "age")


def test_interval_and_p_of_dyads_agree():
    """Where 0 lies outside the interval p is at most .05, also at the border; and chance gets as much as it should."""
    rng = np.random.default_rng(0)
    agreed = []
    for _ in range(150):
        n = int(rng.integers(2, 12))
        nulls = [rng.chisquare(4, 400) - 4 for _ in range(n)]
        values = rng.chisquare(4, n) - 4 + rng.choice([0, 0, 3]) * rng.random(n)
        (low, high), p = over_dyads(values, nulls, rng)
        assert low <= values.mean() <= high or n == 2
        assert (p <= 0.05) == (low > 0 or high < 0)
        agreed.append(p <= 0.05)
    assert 5 < sum(agreed) < 80
    p = [over_dyads(rng.chisquare(4, 5) - 4, [rng.chisquare(4, 400) - 4] * 5, rng)[1] for _ in range(150)]
    assert np.mean(np.array(p) <= 0.05) <= 0.11
    interval, p = over_dyads(np.zeros(3), nulls[:1] * 3, rng)
    assert interval == (0, 0)
    assert p > 0.5
    assert over_dyads(np.ones(3), [np.zeros(9)] * 3, rng)[1] < 0.001


def test_lags_over_dyads():
    """Means of the dyads' own curves, and of their surrogates'."""
    pairs = [dyad(np.random.default_rng(i), 1, 0.9) for i in range(4)]
    mothers, infants = ([series[:1500] for series in side] for side in zip(*pairs, strict=True))
    scan = scan_over_dyads(
        steps(mothers, infants), TRANSFER, range(1, 13), c.Timing(), FEW, np.log(2), np.random.SeedSequence(0)
    )
    alone = [c.scan_lags("te", *pair, lags=range(1, 13), options=FEW) for pair in zip(mothers, infants, strict=True)]
    assert np.allclose(scan.value, np.mean([scan.value for scan in alone], 0))
    assert scan.recordings == 4
    assert (scan.p_adjusted >= scan.p).all()
    assert 4 <= scan.lags[scan.best] <= 12
    assert scan.p_adjusted.min() <= 0.05


def test_groups_are_compared_by_permuting_dyads():
    labels = np.array(["6"] * 4 + ["12"] * 4)
    values = np.array([1.0, 2, 3, 4, 5, 6, 7, 8])
    (found,) = compare(values, labels, ["6", "12"], "age", 99, np.random.default_rng(0))
    assert (found.difference, found.p) == (-4, 2 / 70)  # exact: 2 of the 70 ways are as extreme
    rng = np.random.default_rng(0)
    three = np.repeat(["a", "b", "c"], 8)
    p = [compare(rng.normal(size=24), three, ["a", "b", "c"], "age", 99, rng)[0].p for _ in range(60)]
    assert np.mean(np.array(p) <= 0.05) <= 0.11


@pytest.mark.integration
class TestCommand:
    def test_lags_ages_and_method(self, jointattn, coding, tmp_path):
        options = ("--source", "mother", "--target", "infant", "--surrogates", 99, "--resamples", 20)
        more = ("--recording", "dyad", "--by", "age", "--scan", "12", "--lag", "8", "--out", tmp_path / "m")
        outcome = jointattn("measure", coding, *options, *more)
        assert (outcome.code, outcome.err) == (0, "")
        assert "6 recordings, lag 8, bits" in outcome.out
        assert "TE(s -> r), age 12: mean effective value" in outcome.out
        assert "TE(s -> r), 6 against 12: difference -" in outcome.out
        assert "significant at" in outcome.out
        assert "values are means over 6 recordings" in outcome.out
        assert "circular shifts of the source within its recording" in outcome.out
        document = json.loads((tmp_path / "m.json").read_text())
        assert [row["lag"] for row in document["lags"]] == list(range(1, 13))
        assert {row["group"] for row in document["recordings"]} == {"6", "12"}
        assert document["rows"][0]["method"] in ("shift", "permutation")
        assert sum(
            row["contribution"] for row in document["values"] if row["measure"] == "TE(s -> r)"
        ) == pytest.approx(document["rows"][0]["plug_in"])
        assert (tmp_path / "m_lags.png").read_bytes()[:4] == b"\x89PNG"
        outcome = jointattn("measure", coding, *options, "--recording", "dyad", "--scan", "12", "--over", "steps")
        assert "(max-T)." in outcome.out

    def test_refuses(self, jointattn, coding):
        options = ("--source", "mother", "--target", "infant")
        refused(jointattn("measure", coding, *options, "--lag", "0.5s"), 2, "lag", "how long a step lasts")
        refused(jointattn("measure", coding, *options, "--lag", "soon"), 2, "lag", "0.5s")
        refused(jointattn("measure", coding, *options, "--scan", "0"), 2, "scan")
        refused(jointattn("measure", coding, *options, "--lag", "9000"), 2, "lag", "shorter")
        refused(jointattn("measure", coding, *options, "--by", "age"), 2, "--recording")
        refused(jointattn("measure", coding, *options, "--by", "day", "--recording", "dyad"), 2, "day", "changes")
        refused(jointattn("measure", coding, *options, "--method", "partners"), 2, "recordings")

    def test_a_permutation_that_was_asked_for_is_warned_of(self, jointattn, coding):
        options = ("--source", "mother", "--target", "infant", "--surrogates", 20, "--resamples", 0)
        outcome = jointattn("measure", coding, *options, "--method", "permutation", "--over", "steps")
        assert "Take the method shift" in outcome.out


def test_delays():
    assert [delay_in_steps("lag", text, 0.1) for text in ("3", "3 steps", "0.5s", "500ms", "1 min")] == [
        3,
        3,
        5,
        5,
        600,
    ]
    for text in ("", "0", "-1", "s", "1h", "0s", "1e3", "٣"):
        with pytest.raises(ConfigError, match="lag"):
            check_delay("lag", text)
    with pytest.raises(ConfigError, match="half a step"):
        delay_in_steps("lag", "10ms", 0.1)
