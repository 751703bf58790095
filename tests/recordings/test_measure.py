"""``jointattn measure`` and ``jointattn discover``: what they say and write, and how they refuse."""

import csv
import json
import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from shell import Outcome, refused

import jointattn_mj.contingency as c
from jointattn_mj import read_recordings
from jointattn_mj.errors import ConfigError, OutputError
from jointattn_mj.io.results import bracket, number, share
from jointattn_mj.recordings import patience
from jointattn_mj.recordings.discover import DiscoverOptions, run_discover
from jointattn_mj.recordings.measure import MeasureOptions, run_measure

pytestmark = pytest.mark.integration

FEW = ("--surrogates", 199, "--resamples", 30)
PARTS = ("--sensors", "gaze", "colour", "--actions", "turn", "hand", "--results", "object")


@pytest.fixture(scope="module")
def coding(tmp_path_factory):
    """2000 steps of two days in which gaze and turn together lead to objects."""
    rng = np.random.default_rng(0)
    n = 2000
    gaze, turn = rng.integers(0, 3, n), rng.integers(0, 3, n)
    found = np.where(rng.random(n) < 0.5, gaze == turn, rng.integers(0, 2, n))
    locations = np.array(["left", "middle", "right"])
    columns = {
        "day": np.where(np.arange(n) < 1000, "monday", "tuesday"),
        "gaze": locations[gaze],
        "colour": rng.integers(0, 3, n),
        "turn": locations[turn],
        "hand": rng.integers(0, 3, n),
        "object": np.array(["none", "there"])[np.concatenate([[0], found[:-1]])],
        "warmth": rng.random(n).round(3),
        "gaps": np.where(rng.random(n) < 0.1, "", locations[gaze]),
    }
    path = tmp_path_factory.mktemp("seen") / "seen.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    return path


class TestMeasure:
    def test_measures_are_chosen(self, coding):
        few = {"source": ("gaze",), "target": ("object",), "surrogates": 199, "resamples": 30}
        every = run_measure(MeasureOptions(coding, condition=("turn",), **few))
        some = run_measure(MeasureOptions(coding, condition=("turn",), measures=("transfer_entropy", "SAC"), **few))
        assert [value.name for value in every.measured] == ["SAC", "T^C", "TE(s -> r)", "I(s; r')", "I(s; r' | a)"]
        assert some.measured == (every.measured[0], every.measured[2])  # chance of their own, whatever else is measured
        assert math.isnan(some.granger) and "Granger" not in some.text()
        assert repr(some).startswith("MeasureResult(gaze -> object | turn: 1999 steps in 1 recording, bits; SAC 0.19")
        assert max(len(repr(shown)) for shown in (some, *some.measured, *some.measured[0].values)) <= 120
        with pytest.raises(ConfigError, match=r"`measures` names T\^C, which needs a `condition`"):
            MeasureOptions(coding, measures=("tc",), **few)
        with pytest.raises(ConfigError, match=r"need one of .*transfer_entropy among `measures`"):
            MeasureOptions(coding, measures=("mi",), scan="4", **few)
        with pytest.raises(ConfigError, match="expected a tuple, each one of sac, tc, te, mi, cmi"):
            MeasureOptions(coding, measures=("entropy",), **few)

    def test_measures_are_chosen_on_the_command_line(self, jointattn, coding):
        outcome = jointattn("measure", coding, "--source", "gaze", "--target", "object", "--measures", "te", *FEW)
        assert (outcome.code, outcome.err) == (0, "")
        assert "TE(s -> r)" in outcome.out and "I(s; r')" not in outcome.out

    def test_what_it_prints_and_writes(self, jointattn, coding, tmp_path):
        options = ("--source", "gaze", "--target", "object", "--condition", "turn", *FEW)
        outcome = jointattn("measure", coding, *options, "--out", tmp_path / "new" / "gaze.csv")
        assert (outcome.code, outcome.err) == (0, "")
        assert outcome.out.startswith("gaze -> object | turn: 1999 steps in 1 recording, bits\n")
        with (tmp_path / "new" / "gaze.csv").open() as file:
            rows = {row["measure"]: row for row in csv.DictReader(file)}
        assert list(rows) == ["SAC", "T^C", "TE(s -> r)", "I(s; r')", "I(s; r' | a)"]
        data = read_recordings(coding, ["gaze", "turn", "object"]).columns
        sac = c.state_action_contingency(data["gaze"], data["turn"], data["object"])
        assert float(rows["SAC"]["plug_in"]) == pytest.approx(sac)
        assert f"{sac:.5f}" in outcome.out
        assert float(rows["SAC"]["p"]) == 1 / 200
        assert float(rows["TE(s -> r)"]["p"]) > 0.01
        corrected = c.transfer_entropy(data["gaze"], data["object"], correction="miller_madow")
        assert float(rows["TE(s -> r)"]["miller_madow"]) == pytest.approx(corrected)
        document = json.loads((tmp_path / "new" / "gaze.json").read_text())
        assert document["config"]["source"] == ["gaze"]
        assert "numpy" in document["versions"]
        assert [row["measure"] for row in document["rows"]] == list(rows)
        assert document["rows"][0]["effective"] == pytest.approx(float(rows["SAC"]["effective"]))

    def test_without_a_condition(self, jointattn, coding):
        outcome = jointattn("measure", coding, "--source", "gaze", "turn", "--target", "object", "--resamples", 0)
        assert outcome.code == 0
        assert "gaze & turn -> object" in outcome.out
        assert "SAC" not in outcome.out
        assert "TE(s -> r)" in outcome.out

    def test_recordings_and_gaps(self, jointattn, coding):
        options = ("--source", "gaps", "--target", "object", "--condition", "turn", *FEW)
        refused(jointattn("measure", coding, *options), 2, "gaps", "missing values", "--missing break")
        outcome = jointattn("measure", coding, *options, "--missing", "break", "--recording", "day")
        assert outcome.code == 0
        assert "in 2 recordings" in outcome.out
        assert "of 2000 rows have missing values; recordings were cut there" in outcome.out
        assert "says little" not in outcome.out  # pieces of one day are permuted together

    def test_same_seed_same_words(self, coding):
        first, second, other = (
            run_measure(MeasureOptions(coding, ("colour",), ("object",), surrogates=99, resamples=20, seed=seed)).text()
            for seed in (3, 3, 4)
        )
        assert first == second != other

    def test_little_to_permute(self, tmp_path):
        path = tmp_path / "short.csv"
        path.write_text("who,s,r\n" + "".join(f"{i // 2},{i % 3},{i % 5 // 3}\n" for i in range(40)))
        options = MeasureOptions(path, ("s",), ("r",), recording="who", surrogates=99, resamples=0)
        assert "p says little" in run_measure(options).text()
        assert "p says little" not in run_measure(replace(options, across_recordings=True)).text()

    def test_too_many_values_for_some(self, jointattn, tmp_path):
        """Only linear Granger gives up."""
        path = tmp_path / "many.csv"
        path.write_text("s,r\n" + "".join(f"{i},{i % 7 // 3}\n" for i in range(2100)))
        outcome = jointattn("measure", path, "--source", "s", "--target", "r", *FEW, "--out", tmp_path / "x")
        assert outcome.code == 0
        assert "Note: linear Granger takes up to 1000 values" in outcome.out
        assert json.loads((tmp_path / "x.json").read_text())["rows"][0]["linear_granger"] is None

    def test_text_rows_and_progress(self, coding):
        told = []
        options = MeasureOptions(coding, ("gaze",), ("object",), surrogates=20, resamples=10)
        result = run_measure(options, told.append)
        assert sum(told) == options.draws
        assert len(result.rows()) == 2
        assert all(math.isfinite(value) for row in result.rows() for value in row.values() if isinstance(value, float))
        assert "linear Granger" in result.text()


class TestDiscover:
    def test_what_it_prints_and_writes(self, jointattn, coding, tmp_path):
        outcome = jointattn("discover", coding, *PARTS, *FEW, "--out", tmp_path)
        assert (outcome.code, outcome.err) == (0, "")
        lines = outcome.out.splitlines()
        assert lines[1].startswith("(gaze, turn) -> object")
        assert lines[1].endswith("*")
        assert sum(line.endswith("*") for line in lines) == 1
        assert "(gaze, turn) -> object is carried by" in outcome.out
        assert "gaze left with turn left: object" in outcome.out
        with (tmp_path / "events.csv").open() as file:
            rows = list(csv.DictReader(file))
        assert [row["rank"] for row in rows] == ["1", "2", "3", "4"]
        assert rows[0]["significant"] == "True"
        document = json.loads((tmp_path / "events.json").read_text())
        assert document["config"]["sensors"] == ["gaze", "colour"]
        assert document["rows"][0]["p_adjusted"] == pytest.approx(4 / 200)

    def test_other_measure_and_correction(self, coding):
        options = DiscoverOptions(
            coding,
            ("gaze", "colour"),
            ("turn", "hand"),
            ("object",),
            "tc",
            "benjamini_hochberg",
            surrogates=50,
            resamples=0,
        )
        text = run_discover(options).text()
        assert "T^C" in text
        assert "Benjamini and Hochberg" in text
        assert "would do" not in text
        assert "79 surrogates would do" in run_discover(replace(options, correction="holm")).text()

    def test_progress(self, coding):
        told = []
        options = DiscoverOptions(coding, ("gaze",), ("turn",), ("object",), surrogates=20, resamples=10)
        assert len(run_discover(options, told.append).rows()) == 1
        assert sum(told) == options.draws


GAZE = ("--source", "gaze", "--target", "object")
BAD = [
    ((), ("source",)),
    (("--source", "smell", "--target", "object"), ("smell", "gaze, colour, turn")),
    (("--source", "warmth", "--target", "object"), ("warmth", "bins")),
    ((*GAZE, "--base", 1), ("base",)),
    ((*GAZE, "--surrogates", 0), ("surrogates",)),
    ((*GAZE, "--seed", -1), ("seed",)),
    ((*GAZE, "--recording", "night"), ("night",)),
    ((*GAZE, "--missing", "ignore"), ("ignore", "break")),
]


@pytest.mark.parametrize(("options", "words"), BAD, ids=lambda value: str(value[-1]) if value else "nothing")
def test_refuses(jointattn, coding, options, words):
    refused(jointattn("measure", coding, *options), 2, *words)


def test_a_misspelt_column_never_aborts(coding):
    """Native threads of a reader that were alive when Python ended aborted every second process on a busy machine."""
    command = [
        sys.executable,
        "-m",
        "jointattn_mj.cli.main",
        "measure",
        coding,
        "--source",
        "gazes",
        "--target",
        "object",
    ]
    for _ in range(5):
        done = subprocess.run(command, capture_output=True, text=True)
        refused(Outcome(done.returncode, done.stdout, done.stderr), 2, "no column 'gazes'", "did you mean 'gaze'?")


def test_more_surrogates_than_one_can_wait_for(coding, tmp_path, monkeypatch):
    """Refused before anything is written; with ``yes`` they are drawn."""
    monkeypatch.setattr(patience, "KNOWN_AFTER_S", 0.0)
    monkeypatch.setattr(patience, "LONG_S", 0.0)
    measure = MeasureOptions(coding, ("gaze",), ("object",), surrogates=200, out=tmp_path / "x")
    discover = DiscoverOptions(coding, ("gaze",), ("turn",), ("object",), surrogates=200, out=tmp_path / "y")
    for run, options in ((run_measure, measure), (run_discover, discover)):
        with pytest.raises(ConfigError, match=rf"{options.draws:,} surrogates and resamples would take .*`yes=True`"):
            run(options)
    assert list(tmp_path.iterdir()) == []
    run_measure(replace(measure, yes=True))
    assert (tmp_path / "x.csv").exists()


def test_refuses_files(jointattn, coding, tmp_path):
    refused(jointattn("measure", tmp_path / "none.csv", *GAZE), 2, "none.csv", "No such file")
    (tmp_path / "empty.csv").write_text("")
    refused(jointattn("discover", tmp_path / "empty.csv", *PARTS), 2, "empty.csv", "empty")
    (tmp_path / "mine.json").write_text("mine")
    refused(jointattn("measure", coding, *GAZE, *FEW, "--out", tmp_path / "mine"), 2, "mine.json", "there already")
    assert (tmp_path / "mine.json").read_text() == "mine"
    assert not (tmp_path / "mine.csv").exists()
    refused(jointattn("measure", coding, *GAZE, *FEW, "--out", coding / "below" / "x"), 2, "cannot make the folder")
    refused(jointattn("measure", coding, *GAZE, *FEW, "--out", "x" * 10_000), 2, "255 bytes", "out")
    refused(jointattn("discover", coding, *PARTS, "--alpha", 2), 2, "alpha")
    refused(jointattn("discover", coding, "--sensors", "gaze", "--actions", "gaze", "--results", "object"), 2, "both")


def test_named_errors(coding):
    with pytest.raises(ConfigError):
        MeasureOptions(coding, (), ("object",))
    with pytest.raises(ConfigError):
        DiscoverOptions(coding, ("gaze",), (), ("object",))
    with pytest.raises(ConfigError, match="base"):
        MeasureOptions(coding, ("gaze",), ("object",), base=0)
    with pytest.raises(OutputError):
        run_measure(MeasureOptions(coding, ("gaze",), ("object",), out=coding))


def test_numbers():
    assert [number(x) for x in (0.0, 0.25, -0.0123456, 0.00001, -1e-17, float("nan"))] == [
        "0.00000", "0.25000", "-0.01235", "1.0e-05", "0.00000", "-",
    ]  # fmt: skip
    assert bracket((-0.5, 0.00002)) == "[-0.50000, 2.0e-05]"
    assert bracket((float("nan"), 1.0)) == "-"
    assert [share(x) for x in (0.1234, -0.0001, -0.2)] == ["12.3%", "0.0%", "-20.0%"]


def test_help(jointattn):
    for command in ("measure", "discover"):
        outcome = jointattn(command, "--help")
        assert outcome.code == 0
        assert "--surrogates" in outcome.out
    assert "measure" in jointattn("--help").out
