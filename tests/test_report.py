"""The page and the tables: the same cells give the same bytes, and everything that was found is in them."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from toys.registry import REGISTRY

from jointattn_mj.errors import LaboratoryError, OutputError
from jointattn_mj.laboratory.claim import Finding, Verdict
from jointattn_mj.laboratory.registry import Entry
from jointattn_mj.laboratory.report import Chapter, chapter, commands, write_report
from jointattn_mj.laboratory.run import Selection, plan
from jointattn_mj.laboratory.statistics import Estimate
from jointattn_mj.laboratory.store import Store, text_of

COIN = REGISTRY["1.1"]
FILES = ("report.html", "claims.json", "claims.csv", "claims.md", "figures/1.1-heads.png")


def fill(folder, runs=3, backwards=False, claim=COIN):
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


def test_the_same_cells_the_same_bytes(folder, tmp_path):
    """In another folder, in another order, with other wall times, and after a report on fewer."""
    fill(tmp_path, runs=1)
    write_report(REGISTRY, ["1.1"], tmp_path)
    fill(tmp_path, backwards=True)
    write_report(REGISTRY, ["1.1"], tmp_path)
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


def test_the_page_needs_no_network(folder):
    page = (folder / "report.html").read_text()
    assert not re.findall(r"(?:src|href)=\"(?!data:|#)|https?://|@import|<script", page)
    assert page.count("data:image/svg+xml;base64,") == 1
    assert 'name="viewport"' in page


def test_the_page_says_all(folder):
    page = (folder / "report.html").read_text()
    for text in (
        "Coins &amp; &lt;luck&gt;",
        "section 1, Fig. 1.1",
        "A fair coin shows heads half of the time.",
        "heads of the loaded one",
        "n = 3",
        "no &lt;number&gt; there",
        "1 reproduced, 1 not reproduced, 1 extension",
        "jointattn experiment run 1.1 --runs 3 --out out/experiments",
        "numpy 2",
        "throws: 50",
        "0-2",
    ):
        assert text in page, text
    assert '<span class="badge partly">partly</span></h2>' in page


def test_tables_for_programs(folder):
    (facts,) = json.loads((folder / "claims.json").read_text())
    rows = list(csv.DictReader((folder / "claims.csv").open()))
    assert [row["what"] for row in rows] == [finding["what"] for finding in facts["findings"]]
    assert float(rows[0]["value"]) == facts["findings"][0]["value"] == pytest.approx(0.2)
    assert (rows[0]["n"], rows[2]["value"], rows[2]["verdict"]) == ("3", "", "extension")
    assert facts["settings"]["loaded"] == {"config": {"heads": 0.8, "throws": 50}, "n": 3, "seeds": "0-2"}
    assert (folder / facts["figures"][0]).is_file()
    table = (folder / "claims.md").read_text().splitlines()
    assert len(table) == 5
    assert r"so \| so" in table[-1]


def test_claims_without_cells_are_named_and_not_imported(folder):
    assert chapter(REGISTRY, "1.2", Store(folder)) == Chapter(REGISTRY.entries["1.2"])
    write_report(REGISTRY, list(REGISTRY), folder)
    page = (folder / "report.html").read_text()
    assert "A claim that cannot be read" in page
    assert "not run" in page
    assert 'id="claim-1.2"' not in page
    write_report(REGISTRY, ["1.1"], folder)


def test_nothing_stored(tmp_path):
    with pytest.raises(OutputError, match=r"holds no cells of 1\.1, 1\.2; run some with `jointattn experiment run"):
        write_report(REGISTRY, list(REGISTRY), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_analysis_that_fails_takes_nothing_with_it(tmp_path):
    fill(tmp_path)
    fill(tmp_path, claim=REGISTRY["1.2"])
    with pytest.raises(LaboratoryError, match=r"not all of it: 1\.2: analyse: KeyError"):
        write_report(REGISTRY, list(REGISTRY), tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "heads of the fair one" in page
    assert "could not be read in full: analyse: KeyError" in page


def test_what_a_reader_should_know_of_the_cells(tmp_path):
    fill(tmp_path)
    fill(tmp_path, claim=replace(COIN, version=7), runs=1)
    store, task = Store(tmp_path), next(plan([COIN], Selection(runs=9)))
    store.write_failure(task, "no", "", "")
    store.path(task).write_text("{}")
    notes = " ".join(chapter(REGISTRY, "1.1", store).notes)
    assert "Cells that failed: 1" in notes
    assert "not used: 2" in notes
    assert "hold no cell: 1" in notes


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
    found = commands(COIN, {"fair": list(fair), "loaded": list(loaded)})
    assert found == [f"jointattn experiment run {line} --out out/experiments" for line in expected]


def test_values_that_json_has_not(tmp_path, monkeypatch):
    from toys.coin import analysis

    estimate = Estimate(np.inf, 3.0, np.inf, np.nan, 9)
    monkeypatch.setattr(analysis, "analyse", lambda cells: [Finding("when", "soon", estimate, Verdict.UNDECIDED)])
    monkeypatch.setattr(analysis, "draw", lambda cells: {})
    fill(tmp_path)
    write_report(REGISTRY, ["1.1"], tmp_path)
    finding = json.loads((tmp_path / "claims.json").read_text())[0]["findings"][0]
    assert (finding["value"], finding["sd"]) == ("inf", None)
    assert "∞ [3.00, ∞]" in (tmp_path / "report.html").read_text()


def test_large_drawings_are_pictures_and_films_are_inside(tmp_path, monkeypatch):
    from toys.coin import analysis, sweep

    def draw(cells):
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
