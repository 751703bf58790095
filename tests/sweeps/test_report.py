"""The page and the tables: the same trials give the same bytes, and everything that was found is in them."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from toys.registry import REGISTRY

from jointattn_mj.errors import OutputError, SweepError
from jointattn_mj.sweeps.claim import Comparison, Verdict
from jointattn_mj.sweeps.registry import Entry
from jointattn_mj.sweeps.report import Chapter, chapter, commands, weighed, write_report
from jointattn_mj.sweeps.run import Selection, plan
from jointattn_mj.sweeps.statistics import Estimate, proportion
from jointattn_mj.sweeps.store import Store, text_of

COIN = REGISTRY["1.1"]
FILES = ("report.html", "claims.json", "claims.csv", "claims.md", "figures/1.1-heads.png")


def fill(folder, runs=6, backwards=False, claim=COIN):
    store = Store(folder)
    store.prepare(claim.id)
    tasks = list(plan([claim], Selection(runs=runs)))
    for number, task in enumerate(tasks[::-1] if backwards else tasks):
        result = text_of({"heads": (task.seed % 5) / 5})
        store.write(task, result, versions={"numpy": "2"}, python="3.11", wall_seconds=number)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    fill(folder)
    write_report(REGISTRY, ["1.1"], folder)
    return folder


def test_the_same_trials_the_same_bytes(folder, tmp_path):
    """In another folder, but for its name; in another order, with other wall times, and after a report on fewer."""
    fill(tmp_path, runs=1)
    write_report(REGISTRY, ["1.1"], tmp_path)
    fill(tmp_path, backwards=True)
    write_report(REGISTRY, ["1.1"], tmp_path)
    for name in FILES:
        there = (folder / name).read_bytes().replace(str(folder).encode(), str(tmp_path).encode())
        assert (tmp_path / name).read_bytes() == there, name


def test_the_page_needs_no_network(folder):
    page = (folder / "report.html").read_text()
    assert not re.findall(r"(?:src|href)=\"(?!data:|#)|https?://|@import|<script", page)
    assert page.count("data:image/svg+xml;base64,") == 1
    assert 'name="viewport"' in page


def test_the_page_says_all(folder):
    """Its own folder, as it was given, too."""
    page = (folder / "report.html").read_text()
    for text in (
        "Coins &amp; &lt;luck&gt;",
        "section 1, Fig. 1.1",
        "A fair coin shows heads half of the time.",
        "heads of the loaded one",
        "n = 6",
        "no &lt;number&gt; there",
        "1 reproduced, 1 not reproduced, 1 extension",
        f"jointattn experiment run 1.1 --runs 6 --out {folder}",
        f"jointattn experiment report {folder}",
        "numpy 2",
        "throws: 50",
        "0-5",
    ):
        assert text in page, text
    assert '<span class="badge partly">partly</span></h2>' in page


def test_tables_for_programs(folder):
    (facts,) = json.loads((folder / "claims.json").read_text())
    rows = list(csv.DictReader((folder / "claims.csv").open()))
    assert [row["what"] for row in rows] == [finding["what"] for finding in facts["findings"]]
    assert float(rows[0]["value"]) == facts["findings"][0]["value"] == pytest.approx(1 / 3)
    assert (rows[0]["n"], rows[2]["value"], rows[2]["verdict"]) == ("6", "", "extension")
    assert facts["settings"]["loaded"] == {"config": {"heads": 0.8, "throws": 50}, "n": 6, "seeds": "0-5"}
    assert (folder / facts["figures"][0]).is_file()
    table = (folder / "claims.md").read_text().splitlines()
    assert table[0] == "## 1.1: Coins &amp; &lt;luck>"
    assert len(table) == 7
    assert r"so \| so" in table[-1]


def test_claims_without_trials_are_named_and_not_imported(folder):
    assert chapter(REGISTRY, "1.2", Store(folder)) == Chapter(REGISTRY.entries["1.2"])
    write_report(REGISTRY, list(REGISTRY), folder)
    page = (folder / "report.html").read_text()
    assert "A claim that cannot be read" in page
    assert "Not run here: 1 claim" in page and "Run here: 1 claim of 2, 12 trials in all." in page
    assert 'id="claim-1.2"' not in page
    write_report(REGISTRY, ["1.1"], folder)


def test_nothing_stored(tmp_path):
    with pytest.raises(OutputError, match=r"holds no trials of 1\.1, 1\.2; run some with `jointattn experiment run"):
        write_report(REGISTRY, list(REGISTRY), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_analysis_that_fails_takes_nothing_with_it(tmp_path):
    fill(tmp_path)
    fill(tmp_path, claim=REGISTRY["1.2"])
    with pytest.raises(SweepError, match=r"not all of it: 1\.2: analyse: KeyError"):
        write_report(REGISTRY, list(REGISTRY), tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "heads of the fair one" in page
    assert "could not be read in full: analyse: KeyError" in page


def test_what_a_reader_should_know_of_the_trials(tmp_path):
    fill(tmp_path)
    fill(tmp_path, claim=replace(COIN, version=7), runs=1)
    store, task = Store(tmp_path), next(plan([COIN], Selection(runs=9)))
    store.write_failure(task, "no", "", "")
    store.path(task).write_text("{}")
    notes = " ".join(chapter(REGISTRY, "1.1", store).notes)
    assert "Trials that failed: 1" in notes
    assert "not used: 2" in notes
    assert "hold no trial: 1" in notes


@pytest.mark.parametrize(
    ("fair", "loaded", "expected"),
    [
        (range(8), range(8), ["1.1"]),
        (range(3), range(3), ["1.1 --runs 3"]),
        (range(5, 9), range(5, 9), ["1.1 --seed 5 --runs 4"]),
        (range(8), [], ["1.1 --setting fair --runs 8"]),
        ([0, 1, 4], range(2), ["1.1 --runs 2", "1.1 --setting fair --seed 4 --runs 1"]),
    ],
)
def test_commands_compute_what_is_stored(fair, loaded, expected):
    found = commands(COIN, {"fair": list(fair), "loaded": list(loaded)}, Path("my results"))
    assert found == [f"jointattn experiment run {line} --out 'my results'" for line in expected]


def test_values_that_json_has_not(tmp_path, monkeypatch):
    from toys.coin import analysis

    estimate = Estimate(np.inf, 3.0, np.inf, np.nan, 9)
    monkeypatch.setattr(analysis, "analyse", lambda trials: [Comparison("when", "soon", estimate, Verdict.UNDECIDED)])
    monkeypatch.setattr(analysis, "draw", lambda trials: {})
    fill(tmp_path)
    write_report(REGISTRY, ["1.1"], tmp_path)
    finding = json.loads((tmp_path / "claims.json").read_text())[0]["findings"][0]
    assert (finding["value"], finding["sd"]) == ("inf", None)
    assert "not in half of the runs [3.00, ∞]" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize("runs", [1, 4, 5])
def test_few_runs_decide_nothing(tmp_path, runs):
    fill(tmp_path, runs)
    found = chapter(REGISTRY, "1.1", Store(tmp_path))
    fair, loaded, sentence = found.findings
    assert sentence.verdict is Verdict.EXTENSION
    if runs == 5:
        assert (fair.verdict, loaded.verdict, found.verdict) == (Verdict.REPRODUCED, Verdict.NOT, Verdict.PARTLY)
    else:
        assert {fair.verdict, loaded.verdict, found.verdict} == {Verdict.UNDECIDED}
        assert fair.note == f"too few to say: {runs} run{'s' * (runs > 1)}"


def test_a_claim_that_asks_for_fewer_is_decided_by_fewer():
    finding = Comparison("heads", "half", Estimate(0.5, 0.4, 0.6, 0.1, 3), Verdict.REPRODUCED)
    short = replace(COIN, settings={"fair": replace(COIN.settings["fair"], runs=3)})
    assert weighed(finding, short, 3) is finding
    assert weighed(finding, COIN, 3).verdict is Verdict.UNDECIDED
    many = replace(finding, ours=replace(finding.ours, n=90))  # settings are counted, with two runs of each
    assert weighed(many, COIN, 2).note == "too few to say: 2 runs"


def test_a_share_is_reproduced_by_its_interval():
    """Against 90%: so few that half would have given the same say nothing."""
    outcomes = {(1, 2): Verdict.UNDECIDED, (4, 5): Verdict.UNDECIDED, (9, 10): Verdict.REPRODUCED,
                (20, 20): Verdict.REPRODUCED, (5, 10): Verdict.PARTLY, (60, 100): Verdict.PARTLY}  # fmt: skip
    assert {case: Verdict.of_share(proportion(*case), 0.9) for case in outcomes} == outcomes
    assert Verdict.of_most(proportion(3, 5)) is Verdict.UNDECIDED
    assert Verdict.of_most(proportion(9, 10)) is Verdict.REPRODUCED
    assert Verdict.of_most(proportion(1, 10)) is Verdict.NOT


NASTY = "a|b `rm` <script>alert(1)</script>\n| c | [x](javascript:y) \\"


def test_nothing_is_taken_for_markup(tmp_path, monkeypatch):
    """Neither on the page nor in the table: a finding is one row of plain text, whatever is in it."""
    from toys.coin import analysis

    estimate = Estimate(0.5, 0.4, 0.6, 0.1, 6)
    finding = Comparison(NASTY, NASTY, estimate, Verdict.NOT, NASTY)
    monkeypatch.setattr(analysis, "analyse", lambda trials: [finding])
    fill(tmp_path)
    Store(tmp_path).write_failure(next(plan([COIN], Selection(runs=9))), NASTY, NASTY, NASTY)
    write_report(REGISTRY, ["1.1"], tmp_path)
    assert "<script" not in (tmp_path / "report.html").read_text()
    table = (tmp_path / "claims.md").read_text()
    assert "<" not in table
    (row,) = table.splitlines()[4:]
    assert len(re.findall(r"(?<!\\)(?:\\\\)*\|", row)) == 6  # bars that no odd number of backslashes escapes
    assert not re.search(r"(?<!\\)`", row)
    assert "](" not in row


def test_large_drawings_are_images_and_films_are_inside(tmp_path, monkeypatch):
    from toys.coin import analysis, sweep

    def draw(trials):
        figure = Figure(figsize=(2, 2))
        figure.subplots().plot(np.random.default_rng(0).random(30_000), np.arange(30_000), "x")
        return {"many": figure}

    (tmp_path / "film.mp4").write_bytes(b"film")
    monkeypatch.setattr(analysis, "draw", draw)
    monkeypatch.setattr(sweep, "FILM", tmp_path / "film.mp4", raising=False)
    fill(tmp_path)
    write_report(REGISTRY, ["1.1"], tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "data:image/png;base64," in page
    assert "data:video/mp4;base64,ZmlsbQ==" in page


def test_an_overall_verdict_without_findings():
    assert Chapter(Entry("1", "coin", "", "", "")).tally == ""
