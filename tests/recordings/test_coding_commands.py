"""Lag-sequential analysis and agreement of coders as commands, and as methods of a coding."""

import json

import numpy as np
import pytest
from shell import refused

from jointattn_mj import recordings
from jointattn_mj.recordings.coders import CoderOptions
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.export import write_events
from jointattn_mj.recordings.sequential import SequentialOptions, lag_table
from jointattn_mj.recordings.transitions import TransitionOptions, run_transitions


@pytest.fixture(scope="module")
def coded(tmp_path_factory):
    """Four dyads in which the infant looks where the mother did a second before; a second coder is a bit late."""
    folder, rng = tmp_path_factory.mktemp("coded"), np.random.default_rng(0)
    rows, late = [], []
    for name in ("1", "2", "3", "4"):
        onset, last = 0.0, ""
        while onset < 60:
            code = rng.choice([code for code in ("cup", "ball", "face") if code != last])
            offset = onset + round(float(rng.uniform(1.5, 4)), 1)
            rows.append(("mother", code, onset, offset, name))
            rows.append(
                (
                    "infant",
                    code if rng.random() < 0.7 else rng.choice(["away", "cup", "ball"]),
                    onset + 1,
                    offset + 1,
                    name,
                )
            )
            late.append(("mother", code, onset + 0.2, offset + 0.2, name))
            onset, last = offset, code
    write_events(Events.of(*zip(*rows, strict=True)), folder / "first", "table")
    write_events(Events.of(*zip(*late, strict=True)), folder / "second", "table")
    return folder


def test_transitions(jointattn, coded, tmp_path):
    words = ("transitions", coded / "first", "--recording", "recording", "--step", 0.5, "--given", "mother")
    done = jointattn(*words, "--target", "infant", "--lag", "1s", "--surrogates", 50, "--out", tmp_path / "t")
    assert (done.code, done.err) == (0, "")
    assert "lag 2 (1 s), 4 recordings" in done.out
    rows = json.loads((tmp_path / "t.json").read_text())["rows"]
    (row,) = [row for row in rows if (row["given"], row["target"]) == ("cup", "cup")]
    steps = recordings.read(coded / "first", recording="recording").steps(0.5)
    table = lag_table(steps, "mother", "infant", SequentialOptions(lag=2, surrogates=50))
    assert row["yules_q"] == table.rows()[rows.index(row)]["yules_q"] > 0.5
    assert (row["recordings"], row["positive"]) == (4, 4)
    values = []
    for i in range(4):
        pair = steps.columns["mother"][i], steps.columns["infant"][i]
        cup = [steps.labels[name].index("cup") for name in ("mother", "infant")]
        given, target = pair[0][:-2] == cup[0], pair[1][2:] == cup[1]
        a, b, c, d = ((x & y).sum() for x in (given, ~given) for y in (target, ~target))
        values.append((a * d - b * c) / (a * d + b * c))
    assert row["q_mean"] == pytest.approx(np.mean(values))
    assert row["q_low"] < row["q_mean"] < row["q_high"]
    assert (row["q_p"] <= 0.05) == (row["q_low"] > 0)


def test_events_and_pairs_that_cannot_occur(jointattn, coded):
    words = ("transitions", coded / "first", "--recording", "recording", "--step", 0.5, "--given", "mother")
    done = jointattn(*words, "--unit", "events")
    assert done.code == 0, done.err
    assert "ball -> cup" in done.out
    assert "ball -> ball" not in done.out
    assert "3 degrees" not in done.out and "1 degree of freedom" in done.out
    refused(jointattn(*words, "--impossible", "cup"), 2, "impossible", "colon")
    refused(jointattn(*words, "--unit", "events", "--impossible", "ball:cup"), 2, "occurred")
    refused(jointattn(*words, "--lag", "soon"), 2, "lag")
    data = recordings.read(coded / "first", recording="recording").steps(0.5)
    together = run_transitions(TransitionOptions(coded, given="mother", target="infant", lag="0"), data)
    assert together.table.total == sum(len(part) for part in data.columns["mother"])


def test_agreement(jointattn, coded, tmp_path):
    words = ("agreement", coded / "first", coded / "second", "--recording", "recording")
    done = jointattn(*words, "--resamples", 50, "--out", tmp_path / "a")
    assert (done.code, done.err) == (0, "")
    (row,) = json.loads((tmp_path / "a.json").read_text())["rows"]
    first, second = (recordings.read(coded / name, recording="recording") for name in ("first", "second"))
    (same,) = first.agreement(second, ["mother"], resamples=50)
    assert row["kappa"] == same.kappa == first.agreement(coded / "second", ["mother"], resamples=0)[0].kappa
    assert 0.8 < row["low"] < row["kappa"] < row["high"] < 1
    tolerant = jointattn(*words, "--resamples", 0, "--tolerance-s", 0.3)
    assert "mother   0.99" in tolerant.out  # but for the ends
    refused(jointattn(*words, "--tiers", "infant"), 2, "both coders need a tier 'infant'")
    assert CoderOptions(coded, coded).step == 0.1


def test_transitions_as_a_method(coded):
    found = recordings.read(coded / "first", recording="recording").transitions(
        "mother", "infant", 0.5, lag="1s", surrogates=20
    )
    same = recordings.read(coded / "first", recording="recording").transitions(
        "mother", "infant", 0.5, lag=2, surrogates=0
    )
    assert (same.table.counts == found.table.counts).all()
    assert found.rows()[0]["count"] == found.table.counts[0, 0]
    assert "Yule's Q" in found.text()
