"""Speed of finding contingency: incremental counts beside full recomputation, and whole runs at the table.

Times are of the processor, not of the clock, where other programs on the machine would make a difference.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from itertools import count

import numpy as np

from jointattn_mj.contingency.measures import transfer_entropy
from jointattn_mj.contingency.online.counts import Counts, add, empty_counts
from jointattn_mj.contingency.online.detector import DetectorConfig, Watch, new_watch, update
from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.development.table.presets import PRESETS, Preset
from jointattn_mj.development.table.run import TableRun
from jointattn_mj.development.table.world import CHAPTER_5, table_variables
from jointattn_mj.io.compiled import njit

TRANSITIONS = 20_000
"""Transitions that the detector counts in a block."""
RECOMPUTED = 300
"""Transitions that are recomputed in full in a block."""
RUN_STEPS = 100_000
"""Steps of a run, as in section 5.3.2."""
SAMPLES = 1_000_000
"""Samples in the series for transfer entropy."""
MODULES = {12: 0, 48: 2, 108: 4, 300: 8}
"""Number of modules for each number of triples (sensor, action, result) of the variables of chapter 5."""


@dataclass(frozen=True)
class ContingencyBenchmark:
    """Speed of finding contingency: medians over the blocks; None where pyinform is not installed."""

    detector_steps_per_s_12: float
    """Steps a second with 12 triples. A step counts a transition, updates all contingencies and finds the highest."""
    detector_steps_per_s_300: float
    detector_to_numpy_12: float
    """How many times faster this is than recomputing all contingencies from the tables in numpy."""
    detector_to_numpy_300: float
    ns_per_triple_12: float
    ns_per_triple_48: float
    ns_per_triple_108: float
    ns_per_triple_300: float
    thesis_100k_s: float
    """Seconds of a run of 100,000 steps at the table of chapter 5, preset thesis, compiled."""
    thesis_100k_wall_s: float
    fast_100k_s: float
    fast_100k_wall_s: float
    compile_s: float
    """Seconds of the first step where nothing was compiled before."""
    compile_wall_s: float
    transfer_entropy_ms: float
    """Milliseconds for a million samples of 4 and 2 values, int32 as pyinform expects, with all checks."""
    pyinform_ms: float | None
    transfer_entropy_to_pyinform: float | None

    def rows(self) -> dict[str, float | None]:
        """The figures by name."""
        return asdict(self)


def run_contingency_benchmark(blocks: int) -> ContingencyBenchmark:
    """Measure everything in each block; compiling, which takes a new process, once.

    Args:
        blocks: Their number; one more, in which functions are compiled, is not counted.
    """
    detecting = {triples: _Detecting(modules) for triples, modules in MODULES.items()}
    works: dict[str, Callable[[], object]] = {f"detector {triples}": one.run for triples, one in detecting.items()}
    for triples in (12, 300):
        series = tuple(part[: RECOMPUTED + 1] for part in detecting[triples].series)
        for padded in (False, True):
            works[f"numpy {triples} {padded}"] = partial(Recomputing(detecting[triples].variables, padded).run, *series)
    for name in ("thesis", "fast"):
        works[name] = partial(_advance, PRESETS[name], count())
    source, target = (np.random.default_rng(1).integers(0, size, SAMPLES, np.int32) for size in (4, 2))
    works["transfer entropy"] = partial(transfer_entropy, source, target)
    if theirs := _pyinform():
        works["pyinform"] = partial(theirs, source, target, k=1)
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in works}
    for _ in range(blocks + 1):
        for name, work in works.items():
            times[name].append(_seconds(work))
    cpu, wall = (
        {name: np.array(pairs)[1:, which] for name, pairs in times.items()} for which in (0, 1)
    )  # [0] compiled
    step = {triples: float(np.median(cpu[f"detector {triples}"])) / TRANSITIONS for triples in detecting}

    def to_numpy(triples: int) -> float:
        """In comparison with the layout that suits numpy better at this size."""
        recomputed = [cpu[f"numpy {triples} {padded}"] / RECOMPUTED for padded in (False, True)]
        return float(min(np.median(one / (cpu[f"detector {triples}"] / TRANSITIONS)) for one in recomputed))

    compiling, compiling_wall = compile_seconds()
    return ContingencyBenchmark(
        detector_steps_per_s_12=1 / step[12],
        detector_steps_per_s_300=1 / step[300],
        detector_to_numpy_12=to_numpy(12),
        detector_to_numpy_300=to_numpy(300),
        ns_per_triple_12=1e9 * step[12] / 12,
        ns_per_triple_48=1e9 * step[48] / 48,
        ns_per_triple_108=1e9 * step[108] / 108,
        ns_per_triple_300=1e9 * step[300] / 300,
        thesis_100k_s=float(np.median(cpu["thesis"])),
        thesis_100k_wall_s=float(np.median(wall["thesis"])),
        fast_100k_s=float(np.median(cpu["fast"])),
        fast_100k_wall_s=float(np.median(wall["fast"])),
        compile_s=compiling,
        compile_wall_s=compiling_wall,
        transfer_entropy_ms=1000 * float(np.median(cpu["transfer entropy"])),
        pyinform_ms=1000 * float(np.median(cpu["pyinform"])) if theirs else None,
        transfer_entropy_to_pyinform=float(np.median(cpu["transfer entropy"] / cpu["pyinform"])) if theirs else None,
    )


class _Detecting:
    """The detector on random series of the variables of chapter 5 and of some modules."""

    def __init__(self, modules: int):
        self.variables = table_variables(CHAPTER_5)
        for number in range(modules):
            self.variables = self.variables.with_module(f"module {number + 1}")
        events, random = list(self.variables.events()), np.random.default_rng(0)
        self.counts, self.watch = empty_counts(self.variables, events), new_watch(DetectorConfig(), len(events))
        self.series = tuple(
            np.column_stack([random.integers(0, len(variable.values), TRANSITIONS + 1) for variable in group])
            for group in (self.variables.sensors, self.variables.actions, self.variables.results)
        )

    def run(self) -> None:
        _detect(self.watch, self.counts, *self.series)


@njit(cache=True)
def _detect(watch: Watch, counts: Counts, s: np.ndarray, a: np.ndarray, r: np.ndarray) -> None:
    for t in range(len(s) - 1):
        add(counts, s[t], a[t], r[t], r[t + 1], 1, len(counts.layout))
        update(watch, counts)


class Recomputing:
    """Recomputes SAC of all triples from their tables at every step, in numpy; c ln c is looked up in a list.

    Args:
        variables: Sensors, actions and results.
        padded: All triples in one array instead of one for each shape: more entries, but fewer calls.
    """

    def __init__(self, variables: Variables, padded: bool):
        events = list(variables.events())
        sizes: list[tuple[int, ...]] = [
            (len(variables.results[k].values), len(variables.sensors[i].values), len(variables.actions[j].values))
            for i, j, k in events
        ]
        if padded:
            sizes = [tuple(map(int, np.max(sizes, axis=0)))] * len(events)
        self.values = np.zeros(len(events))
        self._groups = []
        for shape in dict.fromkeys(sizes):
            numbers = np.array([number for number, size in enumerate(sizes) if size == shape])
            table = np.zeros((len(numbers), shape[0], *shape), np.int64)  # (E, R', R, S, A)
            self._groups.append((numbers, *np.array(events)[numbers].T, np.arange(len(numbers)), table))
        self._c_ln_c = np.zeros(1)
        self._n = 0

    def run(self, s: np.ndarray, a: np.ndarray, r: np.ndarray) -> None:
        """Count the transitions of a series, and recompute after each; SAC in nats is left in ``values``.

        Args:
            s: Codes of the sensors, (T, sensors).
            a: Codes of the actions, (T, actions).
            r: Codes of the results, (T, results).
        """
        counts = np.arange(1, self._n + len(s))
        self._c_ln_c = np.concatenate([[0.0], counts * np.log(counts)])
        for t in range(len(s) - 1):
            self._n += 1
            for numbers, sensor, action, result, each, table in self._groups:
                table[each, r[t + 1, result], r[t, result], s[t, sensor], a[t, action]] += 1
                of_action, of_sensor = table.sum(3), table.sum(4)
                alone = of_sensor.sum(3)
                combined = self._summed(table) - self._summed(of_action)
                self.values[numbers] = (combined - self._summed(of_sensor) + self._summed(alone)) / self._n

    def _summed(self, table: np.ndarray) -> np.ndarray:
        """Sum (E,) of c ln c over a table, less that over the table without R'."""
        both, before = self._c_ln_c.take(table), self._c_ln_c.take(table.sum(1))
        difference: np.ndarray = both.reshape(len(table), -1).sum(1) - before.reshape(len(table), -1).sum(1)
        return difference


def compile_seconds() -> tuple[float, float]:
    """Seconds of processor and clock that the first step takes, where nothing was compiled before."""
    code = (
        "import json, time\n"
        "from jointattn_mj.development.table.run import TableRun\n"
        "from jointattn_mj.development.table.presets import PRESETS\n"
        "preset = PRESETS['thesis']\n"
        "run = TableRun(preset.world, preset.agent, 0, 1)\n"
        "cpu, wall = time.process_time(), time.perf_counter()\n"
        "run.advance(1)\n"
        "print(json.dumps([time.process_time() - cpu, time.perf_counter() - wall]))\n"
    )
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        said = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True).stdout
    cpu, wall = json.loads(said)
    return cpu, wall


def _pyinform() -> Callable[..., float] | None:
    try:
        import pyinform
    except ImportError:
        return None
    theirs: Callable[..., float] = pyinform.transfer_entropy
    return theirs


def _advance(preset: Preset, seeds: Iterator[int]) -> None:
    TableRun(preset.world, preset.agent, next(seeds), RUN_STEPS).advance(RUN_STEPS)


def _seconds(work: Callable[[], object]) -> tuple[float, float]:
    """Seconds of processor and clock."""
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - cpu, time.perf_counter() - wall
