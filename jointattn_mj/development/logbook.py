"""Tables of a run, in words: what happened step by step, contingency over time, and the learned maps."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa

from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.development.behaviour import SHORT, BehaviourLog
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.gaze_following.columns import described
from jointattn_mj.io.arrow import number_array, word_array
from jointattn_mj.io.files import write_whole
from jointattn_mj.io.parquet import write_parts
from jointattn_mj.io.rows import spans
from jointattn_mj.io.table import Table

ROWS = 1 << 17
"""Steps in a part of the log."""
PART_BYTES = 1 << 23
"""Bytes in a part of the contingency table."""
RELIABILITY = "reliability"
"""Column of a map."""


def steps_table(run: DevelopmentRun) -> Table:
    """The log, a row a step."""
    return Table(pa.concat_tables(_steps(run)))


def contingency_table(run: DevelopmentRun) -> Table:
    """The measure of every event over time; null before the event existed."""
    return Table(pa.concat_tables(_contingency(run)))


def write_steps(path: Path, run: DevelopmentRun) -> None:
    """Write ``steps_table`` as Parquet, a part at a time."""
    write_parts(path, _steps(run))


def write_contingency(path: Path, run: DevelopmentRun) -> None:
    """Write ``contingency_table`` as Parquet, a part at a time."""
    write_parts(path, _contingency(run))


def map_rows(variables: Variables, module: Module) -> list[list[str]]:
    """A module's map as text: a header, and a row for each pair of observables; blank where it offers nothing."""
    sensor, action = variables.sensors[module.event.sensor], variables.actions[module.event.action]
    result = variables.results[module.event.result]
    rows = [[result.name, sensor.name, action.name, RELIABILITY, f"expected {result.name}"]]
    for r, before in enumerate(result.values):
        for s, sensed in enumerate(sensor.values):
            offer = ["", "", ""]
            if module.command[r, s] != OFFERS_NOTHING:
                command, expected = action.values[module.command[r, s]], result.values[module.expected[r, s]]
                offer = [command, f"{module.reliability[r, s]:.6f}", expected]
            rows.append([before, sensed, *offer])
    return rows


def write_map(path: Path, rows: Iterable[Sequence[str]]) -> None:
    """Write ``map_rows`` as CSV."""

    def write(temporary: Path) -> None:
        with temporary.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)

    write_whole(path, write)


def read_map(path: Path) -> list[list[str]]:
    """What ``write_map`` wrote."""
    with path.open(newline="") as file:
        return list(csv.reader(file))


def map_table(rows: Sequence[Sequence[str]]) -> Table:
    """``map_rows`` as a table; null where the map offers nothing."""
    header, *body = rows
    columns = {
        name: pa.array([float(text) if text else None for text in values], pa.float64())
        if name == RELIABILITY
        else pa.array([text or None for text in values], pa.string())
        for name, values in zip(header, zip(*body, strict=True), strict=True)
    }
    return Table(pa.table(columns))


def _contingency(run: DevelopmentRun) -> Iterator[pa.Table]:
    """The contingency table in parts; at least one, which may be empty."""
    unit = f"{run.agent.config.detector.ranks_by} in units of base {run.agent.config.detector.base:g}"
    names = [run.agent.variables.describe(event) for event in run.agent.events]
    meanings = {"step": "steps done", **dict.fromkeys(names, unit)}
    for first, last in spans(len(run.contingency_log), max(1, PART_BYTES // (8 * len(names)))):
        values = run.contingency_log.values(first, last)
        columns = {"step": number_array(run.contingency_log.n_steps(first, last))}
        columns |= {name: number_array(column, np.isnan(column)) for name, column in zip(names, values.T, strict=True)}
        yield described(pa.table(columns), meanings)


def _steps(run: DevelopmentRun) -> Iterator[pa.Table]:
    """The log in parts of ROWS steps; at least one, which may be empty."""
    variables, meanings = run.agent.variables, {"step": "counted from 1"}
    worlds = variables.sensors[: len(variables.sensors) - variables.modules]
    words: dict[str, tuple[str, ...]] = {}
    for group, meaning in ((worlds, "sensed before the robot acts"), (variables.results, "result sensed with it")):
        for variable in group:
            words[variable.name], meanings[variable.name] = variable.values, meaning
    for joint in variables.joints:
        words[joint.name], meanings[joint.name] = joint.values, "command that the robot then gives"
    words |= run.witnessed
    meanings |= {name: "ground truth, not known to the robot" for name in run.witnessed}
    behaviour = "what the robot does, by the names of Fig. 5.5"
    drivers = {f"driver of {joint.name}": "module that gave the command" for joint in variables.joints}
    meanings |= {**drivers, "behaviour": behaviour}
    names, codes = _drivers(run)
    done = BehaviourLog(run)
    for first, last in spans(run.steps_done, ROWS):
        steps = np.arange(first, last)
        columns = {"step": number_array(steps + 1)}
        columns |= {name: _in_words(run.log(name, first, last), values) for name, values in words.items()}
        made = np.searchsorted(_made(run), steps, side="right")
        for name in drivers:
            columns[name] = _in_words(codes[made, run.log(name, first, last)], names)
        columns["behaviour"] = _in_words(done[first:last], SHORT)
        yield described(pa.table(columns), meanings)


def _made(run: DevelopmentRun) -> list[int]:
    """Steps done when each module was made."""
    return [detection.step for detection in run.detections if detection.module is not None]


def _drivers(run: DevelopmentRun) -> tuple[tuple[str, ...], np.ndarray]:
    """Names of modules, and which of them a number in the log means, (modules made by then + 1, numbers)."""
    drivers, made = run.agent.drivers(), len(run.agent.modules)
    names = tuple(dict.fromkeys(drivers))
    codes = np.zeros((made + 1, len(drivers)), np.int8)
    for known in range(made + 1):
        then = drivers[:known] + drivers[made:]
        codes[known, : len(then)] = [names.index(name) for name in then]
    return names, codes


def _in_words(codes: np.ndarray, words: tuple[str, ...]) -> pa.Array:
    return pa.DictionaryArray.from_arrays(number_array(np.ascontiguousarray(codes, np.int8)), word_array(words))
