"""Runs from Python: in memory or in a folder the same, opened again equal, typed and short to read."""

import dataclasses
import doctest
import inspect
import json

import pyarrow.parquet as pq
import pytest

from jointattn_mj.development import result as results
from jointattn_mj.development import run as runs
from jointattn_mj.development.behaviour import SHORT
from jointattn_mj.development.result import DevelopmentResult
from jointattn_mj.development.run import Development
from jointattn_mj.development.summary import DevelopmentSummary
from jointattn_mj.development.table.config import TableDevelopmentConfig
from jointattn_mj.errors import CheckpointError, ConfigError, OutputError
from jointattn_mj.options import RenamedWarning

pytestmark = pytest.mark.integration

STEPS = 6000


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("run") / "finished"


@pytest.fixture(scope="module")
def result(folder):
    """In memory; the same run also in a folder."""
    development = Development("fast", steps=STEPS, seed=1)
    development.run(out=folder)
    return development.run()


def test_in_memory_and_in_a_folder_it_is_the_same(result, folder, tmp_path):
    opened = DevelopmentResult.open(folder)
    assert result == opened and opened.folder == folder and result.folder is None
    assert result.config == opened.config == Development("fast", steps=STEPS, seed=1).config
    for source in (result, opened):
        source.save(tmp_path / "saved")
        names = {path.name: path.read_bytes() for path in (tmp_path / "saved").iterdir()}
        assert names.keys() == {path.name for path in folder.iterdir()} - {"checkpoint.bin"}
        assert all(content == (folder / name).read_bytes() for name, content in names.items() if name != "config.yaml")
        assert DevelopmentResult.open(tmp_path / "saved") == result
        for path in (tmp_path / "saved").iterdir():
            path.unlink()


def test_its_parts(result):
    (module,) = result.modules
    assert (module.number, module.name, module.means) == (1, "FG-m", "gaze following")
    assert module.event == "caregiver's face, shift gaze -> object"
    assert len(result.log) == STEPS and set(result.log["behaviour"]) == set(SHORT)
    assert result.contingency["step"].tolist() == list(range(100, STEPS + 1, 100))
    assert module.event in result.contingency.columns
    (table,) = result.maps
    assert table["shift gaze"][0] == "spot 1" and table["shift gaze"][4] is None
    assert result.log.to_pandas().shape == (STEPS, len(result.log.columns))
    assert [part.phase for part in result.summary.phases] == ["P1", "P2"]
    ranking = [event.value for event in result.summary.highest_at_the_end]
    assert ranking == sorted(ranking, reverse=True) and len(ranking) == 10


def test_results_differ(result):
    assert Development("fast", steps=STEPS, seed=2).run() != result
    assert result != "a result"


def test_what_is_read_at_a_glance(result, folder):
    said = [repr(shown) for shown in (result, DevelopmentResult.open(folder), result.summary, *result.modules)]
    said += [repr(result.summary.phases[0]), repr(Development("fast", steps=STEPS, seed=1))]
    assert all("\n" not in text and len(text) < 160 for text in said)
    assert said[0] == "DevelopmentResult(table, fast, seed 1, 6,000 steps, 1 module (FG-m), in memory)"
    assert said[-1] == "Development('fast', world='table', steps=6000, seed=1)"


def test_a_summary_is_read_as_it_was_written(result):
    document = json.loads(json.dumps(result.summary.to_json()))
    assert DevelopmentSummary.from_json(document) == result.summary
    assert [module["map"] for module in document["modules"]] == ["module_1.csv"]


def test_progress_and_going_on(tmp_path):
    development, told = Development("thesis", steps=50_000), []

    class Stopped(Exception):
        pass

    def stop(run, found):
        told.append(run.steps_done)
        if run.steps_done == 45_000:
            raise Stopped

    with pytest.raises(Stopped):
        development.run(out=tmp_path / "a", checkpoint_every=25_000, progress=stop)
    assert told == [20_000, 25_000, 45_000]
    resumed = development.run(out=tmp_path / "a", resume=True, progress=lambda run, found: told.append(run.steps_done))
    assert told[3:] == [45_000, 50_000]
    assert resumed == development.run()


def test_options_are_checked():
    for wrong, words in (
        ({"preset": "fsat"}, "'fsat'.*'fast'"),
        ({"world": "moon"}, "table, rendered, realtime"),
        ({"stesp": 3}, "no option stesp.*'steps'"),
        ({"steps": 0}, "steps: expected"),
        ({"table": {"spot": 4}}, r"no option table\.spot"),
        ({"table": {"caregiver": {"follow": 2}}}, r"table\.caregiver\.follow: expected"),
        ({"minutes": 3}, "no option minutes"),
    ):
        with pytest.raises(ConfigError, match=words):
            Development(**wrong)
    with pytest.raises(ConfigError, match="out"):
        Development("fast", steps=1).run(resume=True)


def test_groups_are_given_in_part_or_whole():
    part = Development("fast", table={"spots": 4, "caregiver": {"follow": 0.25}}, agent={"memory": "whole"}).config
    fast = TableDevelopmentConfig.of(preset="fast")
    caregiver = dataclasses.replace(fast.table.caregiver, follow=0.25)
    assert part.table == dataclasses.replace(fast.table, spots=4, caregiver=caregiver)
    assert part.agent == dataclasses.replace(fast.agent, memory="whole")
    assert Development("fast", table=part.table).config.table == part.table
    assert Development.from_config(part).config is part


def test_folders_without_a_result(tmp_path):
    with pytest.raises(OutputError, match="no finished run"):
        DevelopmentResult.open(tmp_path)
    (tmp_path / "summary.json").write_text('{"frames": 3}')
    with pytest.raises(OutputError, match="finished development"):
        DevelopmentResult.open(tmp_path)
    with pytest.raises(OutputError, match="already holds a run"):
        Development("fast", steps=10).run(out=tmp_path)
    with pytest.raises(CheckpointError):
        Development("fast", steps=10).run(out=tmp_path / "none", resume=True)


def test_a_folder_of_the_last_version_is_read(result, folder, tmp_path):
    """turns.parquet with a column turn, and old keys of the summary."""
    result.save(tmp_path / "old")
    for name, old in (("steps.parquet", "turns.parquet"), ("contingency.parquet", "contingency.parquet")):
        table = pq.read_table(folder / name)
        (tmp_path / "old" / name).unlink()
        pq.write_table(table.rename_columns({"step": "turn"}), tmp_path / "old" / old)
    summary = tmp_path / "old" / "summary.json"
    summary.write_text(summary.read_text().replace("detected_without_a_module", "found_without_a_module"))
    with pytest.warns(RenamedWarning, match="is now called detected_without_a_module"):
        opened = DevelopmentResult.open(tmp_path / "old")
    with pytest.warns(RenamedWarning, match=r"turns\.parquet is now called steps\.parquet"):
        assert opened == result


@pytest.mark.parametrize("module", [runs, results])
def test_examples(module, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert doctest.testmod(module).failed == 0
    assert "Examples:" in inspect.getdoc(Development) and "Examples:" in inspect.getdoc(DevelopmentResult)
