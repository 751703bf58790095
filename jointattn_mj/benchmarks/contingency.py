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
from functools import partial
from itertools import count

import numpy as np

from jointattn_mj.benchmarks.figures import Figures
from jointattn_mj.contingency.measures import transfer_entropy
from jointattn_mj.contingency.online.blocks import LONGEST, Block, new_block, patience, put, take_in
from jointattn_mj.contingency.online.counts import Counts, empty_counts
from jointattn_mj.contingency.online.detector import DetectorConfig, Watch, new_watch
from jointattn_mj.contingency.online.events import Variables
from jointattn_mj.contingency.series import Stacked
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
SHORT = 100
"""Samples in a short series; a fifth of all samples go into such series for the call that takes many."""
IN_A_ROW = 8
"""Calls in a row with the same series."""
ELSEWHERE = 2**23
"""Numbers, 64 MiB, that are read before each transfer entropy, after the same call. A smaller cache then holds the
series for neither program, a larger one for both."""
MODULES = {12: 0, 48: 2, 108: 4, 300: 8}
"""Number of modules for each number of triples (sensor, action, result) of the variables of chapter 5."""


def run_contingency_benchmark(blocks: int) -> Figures:
    """Measure everything in each block; compiling, which takes a new process, once.

    Args:
        blocks: Their number; one more, in which functions are compiled, is not counted.

    Returns:
        detector_steps_per_s_...: steps a second with so many triples; a step counts a transition, updates all
        contingencies and finds the highest. detector_to_numpy_...: how many times faster this is than recomputing all
        contingencies from the tables in numpy. ns_per_triple_...: the same by triple. thesis_100k_s, fast_100k_s:
        seconds of a run of 100,000 steps at the table of chapter 5 with that preset, compiled, and by the clock (wall).
        compile_s: of the first step where nothing was compiled before. transfer_entropy_ms, pyinform_ms: milliseconds
        for a million samples of 4 and 2 values, int32 as pyinform expects, from memory and with all checks.
        ..._to_pyinform: ratios, also for int64, with a condition of 3 values, for a series of 100 steps, and for 2,000
        such series in one call: many_short where both get an array of two dimensions, many_short_lists where both get
        the same lists.
        in_a_row_...: for several calls with the same series, of which only the first waits for memory.
        None where pyinform is not installed.
    """
    detecting = {triples: _Detecting(modules) for triples, modules in MODULES.items()}
    works: dict[str, Callable[[], object]] = {
        f"detector {triples}": detector.run for triples, detector in detecting.items()
    }
    for triples in (12, 300):
        series = tuple(part[: RECOMPUTED + 1] for part in detecting[triples].series)
        for padded in (False, True):
            works[f"numpy {triples} {padded}"] = partial(Recomputing(detecting[triples].variables, padded).run, *series)
    for name in ("thesis", "fast"):
        works[name] = partial(_advance, PRESETS[name], count())
    external, transfers, elsewhere = _pyinform(), _transfers(), np.ones(ELSEWHERE)
    from_memory: dict[str, Callable[[], object]] = {name: ours for name, (ours, _) in transfers.items()}
    if external:
        from_memory |= {f"pyinform {name}": partial(theirs, external) for name, (_, theirs) in transfers.items()}
    works |= from_memory
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in works}
    for _ in range(blocks + 1):
        for name, work in works.items():
            if name in from_memory:
                work()
                elsewhere.sum()
            times[name].append(_seconds(work))
    cpu, wall = (
        {name: np.array(pairs)[1:, which] for name, pairs in times.items()} for which in (0, 1)
    )  # [0] compiled
    step = {triples: cpu[f"detector {triples}"] / TRANSITIONS for triples in detecting}
    figures = Figures()
    for triples in (12, 300):
        figures.add(f"detector_steps_per_s_{triples}", 1 / step[triples])
    for triples in (12, 300):  # beside the layout that suits numpy better at this size
        ratios = [cpu[f"numpy {triples} {padded}"] / RECOMPUTED / step[triples] for padded in (False, True)]
        figures.add(f"detector_to_numpy_{triples}", min(ratios, key=lambda repeats: float(np.median(repeats))))
    for triples in detecting:
        figures.add(f"ns_per_triple_{triples}", 1e9 * step[triples] / triples)
    for name in ("thesis", "fast"):
        figures.add(f"{name}_100k_s", cpu[name])
        figures.add(f"{name}_100k_wall_s", wall[name])
    for name, seconds in zip(("compile_s", "compile_wall_s"), compile_seconds(), strict=True):
        figures.add(name, seconds)
    figures.add("transfer_entropy_ms", 1000 * cpu["transfer_entropy"])
    figures.add("pyinform_ms", 1000 * cpu["pyinform transfer_entropy"] if external else None)
    for name in transfers:
        figures.add(f"{name}_to_pyinform", cpu[name] / cpu[f"pyinform {name}"] if external else None)
    return figures


def _transfers() -> dict[str, tuple[Callable[[], object], Callable[..., object]]]:
    """Transfer entropies by name: ours, and a call of pyinform's function, which is given."""
    source, target, known = (np.random.default_rng(1).integers(0, size, SAMPLES, np.int32) for size in (4, 2, 3))
    wide, wide_target = source.astype(np.int64), target.astype(np.int64)
    short, short_target = source[:SHORT], target[:SHORT]
    many = [part[: SHORT * (SAMPLES // SHORT // 5)].reshape(-1, SHORT) for part in (source, target)]
    lists = [list(part) for part in many]
    again = 1 + SAMPLES // 10_000
    return {
        "transfer_entropy": (
            partial(transfer_entropy, source, target), lambda external: external(source, target, k=1),
        ),
        "int64": (
            partial(transfer_entropy, wide, wide_target), lambda external: external(wide, wide_target, k=1),
        ),
        "in_a_row": (
            lambda: [transfer_entropy(source, target) for _ in range(IN_A_ROW)],
            lambda external: [external(source, target, k=1) for _ in range(IN_A_ROW)],
        ),
        "in_a_row_int64": (
            lambda: [transfer_entropy(wide, wide_target) for _ in range(IN_A_ROW)],
            lambda external: [external(wide, wide_target, k=1) for _ in range(IN_A_ROW)],
        ),
        "conditional": (
            partial(transfer_entropy, source, target, known),
            lambda external: external(source, target, k=1, condition=known),
        ),
        "short": (
            lambda: [transfer_entropy(short, short_target) for _ in range(again)],
            lambda external: [external(short, short_target, k=1) for _ in range(again)],
        ),
        "many_short": (
            lambda: transfer_entropy(Stacked(many[0]), Stacked(many[1])), lambda external: external(*many, k=1),
        ),
        "many_short_lists": (lambda: transfer_entropy(lists[0], lists[1]), lambda external: external(*lists, k=1)),
    }  # fmt: skip


class _Detecting:
    """The detector on random series of the variables of chapter 5 and of some modules."""

    def __init__(self, modules: int):
        self.variables = table_variables(CHAPTER_5)
        for number in range(modules):
            self.variables = self.variables.with_module(f"module {number + 1}")
        events, random = list(self.variables.events()), np.random.default_rng(0)
        self.counts, self.watch = empty_counts(self.variables, events), new_watch(DetectorConfig(), len(events))
        groups = self.variables.sensors, self.variables.actions, self.variables.results
        sensors, actions, results = map(len, groups)
        self.block = new_block(sensors, actions, results, len(self.counts.n))
        self.series = tuple(
            np.column_stack([random.integers(0, len(variable.values), TRANSITIONS + 1) for variable in group])
            for group in groups
        )

    def run(self) -> None:
        _detect(self.watch, self.counts, self.block, *self.series)


@njit(cache=True, borrows=True)
def _detect(watch: Watch, counts: Counts, block: Block, s: np.ndarray, a: np.ndarray, r: np.ndarray) -> None:
    """Count and rank as a run does: as many transitions at once as the stop rule lets."""
    t, last = 0, len(s) - 1
    while t < last:
        n = min(patience(watch), LONGEST, last - t)
        for i in range(n):
            put(block, i, s[t + i], a[t + i], r[t + i], r[t + i + 1])
        take_in(watch, counts, block, n)
        t += n


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
    function: Callable[..., float] = pyinform.transfer_entropy
    return function


def _advance(preset: Preset, seeds: Iterator[int]) -> None:
    TableRun(preset.world, preset.agent, next(seeds), RUN_STEPS).advance(RUN_STEPS)


def _seconds(work: Callable[[], object]) -> tuple[float, float]:
    """Seconds of processor and clock."""
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - cpu, time.perf_counter() - wall
