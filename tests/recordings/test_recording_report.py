"""The page of coded interaction: what it says is what the measures say, and it is one file."""

import base64
import csv
import json
import re

import numpy as np
import pytest
from matplotlib.text import Text

from jointattn_mj import recordings
from jointattn_mj.errors import ConfigError, OutputError, SeriesError
from jointattn_mj.io.figures import lacking, without_font, without_formulas
from jointattn_mj.io.page import drawn
from jointattn_mj.recordings.agreement import AgreementOptions, agreement
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.export import write_events
from jointattn_mj.recordings.joint_attention import JointAttentionRules, joint_attention
from jointattn_mj.recordings.report import ReportOptions, run_report
from jointattn_mj.recordings.report_figures import code_colours, timeline

pytestmark = pytest.mark.integration

FEW = {"surrogates": 60, "resamples": 20, "step": 0.5, "lag": "0.5s", "scan": "2s"}


def coding(name: str, rng: np.random.Generator) -> Events:
    """A mother, and an infant who looks where she does half a second later in four of five looks."""
    looks, onset = [], 0.0
    while onset < 90:
        code, offset = rng.choice(["cup", "ball", "face"]), onset + rng.choice([1.0, 1.5, 2.0])
        looks.append(("mother", code, onset, offset))
        looks.append(("infant", code if rng.random() < 0.8 else rng.choice(["cup", "away"]), onset + 0.5, offset + 0.5))
        onset = offset
    return Events.of(*zip(*looks, strict=True), recording=name)


@pytest.fixture(scope="module")
def codings(tmp_path_factory):
    folder, rng = tmp_path_factory.mktemp("codings"), np.random.default_rng(0)
    every = [coding(name, rng) for name in ("a <b>", "c & d", "e")]
    write_events(every[0].joined(*every[1:]), folder / "first", "boris")
    write_events(every[0], folder / "second", "table")
    (folder / "ages.csv").write_text("dyad;age\na <b>;6\nc & d.eaf;9\ne;9\n")
    return folder


def beside(folder):
    return {"second": folder / "second", "by": "age", "groups": folder / "ages.csv"}


@pytest.fixture(scope="module")
def report(codings):
    options = ReportOptions(
        codings / "first", out=codings / "out", second=codings / "second", by="age", groups=codings / "ages.csv", **FEW
    )
    return run_report(options)


def test_the_page_is_one_file_with_all_parts(report, codings):
    text = (codings / "out" / "report.html").read_text("utf-8")
    assert re.findall(r'id="([\w-]+)"', text) == [
        "timelines", "joint-attention", "transitions", "ranking", "lags", "groups", "agreement", "left-out", "methods",
    ]  # fmt: skip
    assert not re.findall(r'(?:src|href)="(?!data:|#)', text)
    assert "a &lt;b&gt;" in text and "<b>" not in text
    assert text.count("Timeline of") == 3


def test_values_are_those_of_the_measures(report, codings):
    coded = recordings.read(codings / "first")
    alone = coded.measure("mother", "infant", step=0.5, lag="0.5s", surrogates=60, resamples=20, measures=["te"])
    (row,) = [row for row in report.ranking() if (row["source"], row["target"]) == ("mother", "infant")]
    assert row["effective"] == alone.dyads[0].groups[0].mean > 0.1
    assert row["all_steps"] == alone.rows()[0]["effective"]
    assert report.attention.rows() == joint_attention(coded.events).rows()
    second = recordings.read(codings / "second").events
    options = AgreementOptions(step=0.5, resamples=20)
    assert [compared.row() for compared in report.agreements] == [
        compared.row() for compared in agreement(coded.events, second, None, options)
    ]


def test_recordings_are_compared_by_group(report):
    tables = report.tables()
    means = {(row["value"], row["group"]): row["mean"] for row in tables["groups"]}
    shares = [row["mutual gaze, share of time"] for row in report.attention.rows()]
    assert means["mutual gaze, share of time", "age 6"] == shares[0]
    assert means["mutual gaze, share of time", "age 9"] == pytest.approx(np.mean(shares[1:]))
    assert ("transfer entropy: mother → infant", "age 9") in means
    assert all(row["p"] != row["p"] for row in tables["comparisons"])  # one recording of 6 months tells nothing


def test_answers_are_told_only_of_significant_directions(report, codings):
    """The infant follows; the mother does not, over recordings, whatever single looks of all steps together say."""
    told = {(row["source"], row["target"]): row["significant"] for row in report.ranking()}
    text = (codings / "out" / "report.html").read_text("utf-8")
    answers = text[text.index("Which look answers which") : text.index("What two tiers lead to")]
    assert not all(told.values())
    for (source, target), significant in told.items():
        assert (f"{source} → {target} is left out" in answers) != significant
        assert significant or f"<td>{source} at" not in answers


def test_how_p_came_about_is_said_once(report):
    assert sum("come from" in note and note.startswith("p and effective values") for note in report.notes) == len(
        {row["method"] for row in (*report.ranking(), *report.events_ranked())}
    )


def test_a_timeline_draws_only_what_is_in_its_rows():
    n = 3000
    onsets = [float(i) for i in range(n)]
    offsets = [onset + 1 for onset in onsets]
    looks = Events.of(["infant"] * n + ["mother"] * n, ["face", "cup"] * n, onsets * 2, offsets * 2)
    figure = timeline(joint_attention(looks), looks.tier_names, looks.recordings[0], 1.0, {})
    assert len(figure.axes) == 60
    drawn = sum(len(of.get_paths()) for axes in figure.axes for of in axes.collections)
    assert drawn < 60 * 20  # of 3,000 looks


@pytest.mark.filterwarnings("error")
def test_words_of_figures_are_as_users_wrote_them():
    """Dollar signs, codes that begin with _, and characters that the figures' own font lacks."""
    codes = ["$\\frac{a$", "_b", "球"]
    looks = Events.of(["mo$ther^{"] * 3 + ["infant"], [*codes, codes[0]], [0, 1, 2, 0], [1, 2, 3, 3])
    rules = JointAttentionRules(partner="mo$ther^{")
    figure = timeline(joint_attention(looks, rules), looks.tier_names, "1", 3, code_colours(looks))
    _, uri = drawn(without_formulas(figure))
    assert {*codes, *looks.tier_names} <= {text.get_text() for text in figure.findobj(Text)}
    kept = set("球") & set(base64.b64decode(uri.partition(",")[2]).decode())  # as text, where no font draws it
    assert kept == set(without_font(codes)) <= set(lacking(codes)) == set("球")


def test_events_are_ranked_by_sac(report, codings):
    coded = recordings.read(codings / "first")
    (first, second) = report.events_ranked()
    assert {first["result"], second["result"]} == {"mutual gaze", "shared attention"}
    assert first["effective"] >= second["effective"] and first["low"] < first["effective"] < first["high"]
    derived = joint_attention(coded.events).events
    alone = recordings.read(derived.to_pandas(), recording="recording").measure(
        "mother", "shared attention", "infant", step=0.5, lag="0.5s", surrogates=60, resamples=20, measures=["sac"]
    )
    (row,) = [row for row in (first, second) if row["result"] == "shared attention"]
    assert row["effective"] == alone.dyads[0].groups[0].mean
    assert sum(value["contribution"] for value in report.tables()["sac_values"]) > 0
    with pytest.warns(FutureWarning, match="found is now called sac"):
        assert report.found is report.sac


def test_tables_lie_beside_it(report, codings):
    out = codings / "out"
    document = json.loads((out / "report.json").read_text("utf-8"))
    for name, rows in report.tables().items():
        with (out / f"{name}.csv").open(newline="", encoding="utf-8") as file:
            assert len(list(csv.DictReader(file))) == len(rows) > 0
        assert name == "events" or len(document[name]) == len(rows)
    assert (out / "methods.txt").read_text("utf-8").strip() == report.methods() == document["methods"]
    assert {path.name for path in (out / "figures").iterdir()} >= {"timeline_1.png", "lags.png", "dyads.png"}


def test_the_paragraph_has_every_number_of_the_settings(report):
    said = report.methods()
    assert "steps of 0.5 s" in said and "60 surrogates" in said and "0.5 to 2 s (4 lags)" in said
    assert "level of significance is 0.05" in said and "two coders of 1 recording" in said
    for compared in report.agreements:
        assert f"{compared.tier}: {compared.kappa:.2f}" in said


def test_too_few_surrogates_for_so_many_pairs_are_told(report, codings, tmp_path):
    assert not report.out_of_reach("pair of tiers")
    few = run_report(ReportOptions(codings / "second", out=tmp_path / "out", **{**FEW, "surrogates": 38}))
    (note,) = few.out_of_reach("pair of tiers")
    assert note.startswith("with 38 surrogates p is 0.026 or more") and note.endswith("; 39 surrogates would do")
    assert not any(row["significant"] for row in few.ranking())
    assert note in json.loads((tmp_path / "out" / "report.json").read_text("utf-8"))["notes"]


def test_the_same_seed_gives_the_same_page(report, codings):
    again = recordings.read(codings / "first").report(
        codings / "again", second=codings / "second", by="age", groups=codings / "ages.csv", **FEW
    )
    assert repr(again.tables()) == repr(report.tables())  # NaN equals itself
    pages = [(codings / name / "report.html").read_text("utf-8") for name in ("out", "again")]
    assert pages[0].replace(str(codings / "out"), "") == pages[1].replace(str(codings / "again"), "")


def test_the_command_line_makes_it_from_two_tiers_of_other_names(codings, tmp_path, jointattn):
    write_events(
        Events.of(["baby"] * 4 + ["dad"] * 2, list("xyxyxy"), [0, 2, 4, 6, 0, 3], [2, 4, 6, 8, 3, 8]), tmp_path
    )
    words = ("recordings", tmp_path, "--infant", "baby", "--partner", "dad", "--step", "0.5", "--scan", "2")
    done = jointattn(*words, "--surrogates", "20", "--out", tmp_path / "out")
    assert done.code == 0, done.err
    assert "dad follows 1 of 2 looks of baby" in done.out and (tmp_path / "out" / "report.html").exists()
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    reach = "no pair of tiers can be significant at 0.05 after Holm&#39;s correction for 2 tests"
    assert reach in page and reach.replace("&#39;", "'") in done.out
    assert "is there already" in jointattn(*words, "--out", tmp_path / "out").err


def test_what_cannot_be_reported_is_told(codings, report, tmp_path):
    with pytest.raises(OutputError, match="is there already"):
        run_report(report.options)
    with pytest.raises(SeriesError, match="there is no tier 'baby'"):
        run_report(ReportOptions(codings / "first", out=tmp_path / "x", infant="baby"))
    assert not (tmp_path / "x").exists()
    with pytest.raises(SeriesError, match="no column or tier 'age'"):
        run_report(ReportOptions(codings / "first", out=tmp_path / "x", by="age"))
    with pytest.raises(ConfigError, match="scan"):
        ReportOptions(codings / "first", out=tmp_path / "x", scan="soon")
    with pytest.raises(ConfigError, match="'infant' is a sensor or an action, too"):
        ReportOptions(codings / "first", out=tmp_path / "x", results=("infant",))


def test_tiers_without_change_are_not_ranked(codings, tmp_path):
    """What never changes says nothing; counted among the tests it would only make p of the others larger."""
    events = recordings.read(codings / "second").events
    silent = events.joined(Events.of(["voice"], ["sings"], [0.0], [95.0], recording="a <b>"))
    report = recordings.read(silent.to_pandas(), recording="recording").report(tmp_path / "out", **FEW)
    assert {row["source"] for row in report.ranking()} == {"mother", "infant"}
    assert "tier 'voice' is not ranked, as it has the same value in all steps" in report.notes
