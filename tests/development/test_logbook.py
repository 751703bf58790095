"""The log in words: nothing lost, and told by the names of the time."""

import csv

import numpy as np
import pyarrow.parquet as pq
import pytest

from jointattn_mj.development import logbook
from jointattn_mj.development.behaviour import SHORT, behaviours
from jointattn_mj.development.logbook import map_rows, write_contingency, write_map, write_steps
from jointattn_mj.development.table.presets import PRESETS
from jointattn_mj.development.table.run import TableRun

STEPS = 12_000


@pytest.fixture(scope="module")
def run():
    preset = PRESETS["fast"]
    run = TableRun(preset.world, preset.agent, seed=1, n_steps=STEPS)
    run.advance(STEPS)
    assert len(run.agent.modules) >= 3
    return run


@pytest.fixture(scope="module")
def found(run):
    return behaviours(run.log("caregiver's face"), run.log("shift gaze"), 3)


def test_steps(run, found, tmp_path):
    write_steps(tmp_path / "steps.parquet", run)
    table = pq.read_table(tmp_path / "steps.parquet")
    assert table.num_rows == STEPS
    assert table.column("step").to_pylist()[::5999] == [1, 6000, 11999]
    variables = run.agent.variables
    for variable in (*variables.sensors[:2], *variables.results, *variables.joints):
        expected = np.array(variable.values)[run.log(variable.name)]
        assert table.column(variable.name).to_pylist() == expected.tolist(), variable.name
    assert table.column("behaviour").to_pylist() == np.array(SHORT)[found].tolist()
    assert set(table.column("caregiver looks at").to_pylist()) == {"spot 1", "spot 2", "spot 3", "robot"}
    assert "RJA" in table.column("caregiver's option").to_pylist()
    for field in table.schema:
        assert field.metadata[b"description"], field.name


def test_drivers(run, tmp_path):
    """Numbers below that of the modules made by then are modules; those made later make no difference."""
    write_steps(tmp_path / "steps.parquet", run)
    drivers = pq.read_table(tmp_path / "steps.parquet").column("driver of shift gaze").to_pylist()
    numbers = run.log("driver of shift gaze").tolist()
    for step, (name, number) in enumerate(zip(drivers, numbers, strict=True)):
        made = sum(detection.step <= step for detection in run.detections)
        assert name == (f"module {number + 1}" if number < made else "RandomModule"), step
    assert {"module 1", "module 2", "module 3", "RandomModule"} <= set(drivers)


def test_what_drives_is_what_the_map_says(run, tmp_path):
    write_steps(tmp_path / "steps.parquet", run)
    drivers = pq.read_table(tmp_path / "steps.parquet").column("driver of shift gaze")
    drives = np.flatnonzero(np.array(drivers.to_pylist()) == "module 1")
    module, face, before = run.agent.modules[0], run.log("caregiver's face"), run.log("object")
    assert (module.command[before[drives], face[drives]] == run.log("shift gaze")[drives]).all()


def test_parts_do_not_show(run, tmp_path, monkeypatch):
    write_steps(tmp_path / "whole.parquet", run)
    monkeypatch.setattr(logbook, "ROWS", 1001)
    write_steps(tmp_path / "parts.parquet", run)
    assert (
        pq.read_table(tmp_path / "whole.parquet").to_pydict() == pq.read_table(tmp_path / "parts.parquet").to_pydict()
    )


def test_contingency(run, tmp_path, monkeypatch):
    write_contingency(tmp_path / "contingency.parquet", run)
    table = pq.read_table(tmp_path / "contingency.parquet")
    n_steps, values = run.contingency()
    assert table.column("step").to_pylist() == n_steps.tolist()
    assert table.num_columns == 1 + len(run.agent.events)
    monkeypatch.setattr(logbook, "PART_BYTES", 20_000)
    write_contingency(tmp_path / "parts.parquet", run)
    assert pq.read_metadata(tmp_path / "parts.parquet").num_row_groups > 2
    assert pq.read_table(tmp_path / "parts.parquet").equals(table)
    late = table.column("module 1 before, shift gaze -> profile")
    assert late.null_count == np.count_nonzero(n_steps <= run.detections[0].step)
    first = table.column("caregiver's face, shift gaze -> object")
    assert np.array_equal(first.to_numpy(), values[:, 2])


def test_map(run, tmp_path):
    write_map(tmp_path / "map.csv", map_rows(run.agent.variables, run.agent.modules[0]))
    rows = list(csv.DictReader((tmp_path / "map.csv").open()))
    assert list(rows[0]) == ["object", "caregiver's face", "shift gaze", "reliability", "expected object"]
    assert len(rows) == 10
    first = rows[0]
    assert [first[name] for name in ("object", "caregiver's face", "shift gaze", "expected object")] == [
        "no", "at spot 1", "spot 1", "yes",
    ]  # fmt: skip
    assert float(first["reliability"]) == pytest.approx(run.agent.modules[0].reliability[0, 0], abs=1e-6)
    assert rows[4]["caregiver's face"] == "not seen"
    assert rows[4]["shift gaze"] == rows[4]["reliability"] == ""
