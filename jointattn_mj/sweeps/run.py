"""Computes what is missing of some claims, and gets over what goes wrong on the way."""

import shlex
import traceback
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import Checked, Seed, Whole
from jointattn_mj.sweeps.backends import Backend, gone, lost_touch
from jointattn_mj.sweeps.claim import Claim
from jointattn_mj.sweeps.store import Keys, PlannedTrial, Store
from jointattn_mj.sweeps.worker import Outcome, compute, pack

GOLDEN = 0.618
"""Runs that share a folder begin this part of the way apart, so that any number of them spreads."""
WAIT_S = 1.0
"""So often progress is told even where nothing has ended."""


@dataclass
class Tally:
    """How far a run has come."""

    todo: int = 0
    """Trials that were missing when it began."""
    stored: int = 0
    """Trials that were there already."""
    done: int = 0
    failed: list[tuple[PlannedTrial, str, str]] = field(default_factory=list)
    """Trials that failed, with their error and the command that runs them alone."""
    running: int = 0
    deaths: int = 0
    """Workers that died."""
    left: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Trials still to do, by claim and setting."""
    seconds: dict[tuple[str, str], tuple[int, float]] = field(default_factory=dict)
    """Trials and their computing time, by claim and setting."""

    def work_left_s(self) -> float | None:
        """Computing time of what is left, from what the same settings took so far; None before anything is known."""
        known = sum(count for count, _ in self.seconds.values())
        if not known:
            return None
        mean = sum(spent for _, spent in self.seconds.values()) / known
        per_trial = {kind: spent / count for kind, (count, spent) in self.seconds.items()}
        return sum(count * per_trial.get(kind, mean) for kind, count in self.left.items())


class SweepWatcher:
    """Is told how a run goes; this one does not listen."""

    def begin(self, tally: Tally, slots: int) -> None:
        """Before the first trial."""

    def tick(self, tally: Tally, slots: int) -> None:
        """Whenever a trial has ended, and every second."""

    def end(self, tally: Tally) -> None:
        """After the last trial, or when the run is cut short."""


@dataclass(frozen=True)
class Selection(Checked):
    """Which trials of a claim: its own settings, seeds and runs where nothing else is said."""

    setting: str | None = None
    """A setting's id, or how the ids of several begin."""
    runs: Annotated[int, Whole("[1, 1e6]")] | None = None
    first_seed: Seed | None = None

    def names(self, claim: Claim) -> list[str]:
        """The settings that are meant."""
        if self.setting is None:
            return list(claim.settings)
        if self.setting in claim.settings:
            return [self.setting]
        return [name for name in claim.settings if name.startswith(self.setting)]

    def seeds(self, claim: Claim, names: Iterable[str]) -> dict[str, range]:
        """The seeds of each."""
        first = claim.first_seed if self.first_seed is None else self.first_seed
        return {
            name: range(first, first + (claim.settings[name].runs if self.runs is None else self.runs))
            for name in names
        }


def plan(claims: Sequence[Claim], selection: Selection) -> Iterator[PlannedTrial]:
    """All trials that are meant, claim after claim.

    Raises:
        ConfigError: No claim has the setting.
    """
    named = [(claim, selection.names(claim)) for claim in claims]
    if not any(names for _, names in named):
        known = ", ".join(name for claim in claims for name in claim.settings)
        raise ConfigError(f"no setting is called {selection.setting!r} or begins so; there are {known}")
    for claim, names in named:
        yield from Keys(claim).tasks(names, selection.seeds(claim, names))


def run(
    claims: Sequence[Claim],
    selection: Selection,
    folder: Path,
    backend: Backend,
    watcher: SweepWatcher | None = None,
    **always: object,
) -> Tally:
    """Compute and store what is missing; trials that failed before are tried again.

    The error of a trial, or the death of its worker, ends that trial and no other. ``always`` are options that the
    command line needs to run a trial again.

    Raises:
        OutputError: The folder cannot be written; all trials that had been stored stay.
        LaboratoryError: The workers are gone for good.
    """
    store, watcher = Store(folder), watcher or SweepWatcher()
    meant = list(plan(claims, selection))
    for claim in claims:
        store.prepare(claim.id)
    known = {claim.id: store.known(claim.id) for claim in claims}
    queue = deque(task for task in meant if task.key not in known[task.claim.id])
    tally = Tally(stored=len(meant) - len(queue))
    tally.todo = len(queue)
    tally.left.update((task.claim.id, task.name) for task in queue)
    watcher.begin(tally, backend.slots())
    try:
        with store.berth() as place:
            queue.rotate(-int(place * GOLDEN % 1 * len(queue)))
            _Run(store, backend, watcher, tally, always).through(queue)
    finally:
        backend.close()
        tally.running = 0
        watcher.end(tally)
    return tally


class _Run:
    def __init__(
        self, store: Store, backend: Backend, watcher: SweepWatcher, tally: Tally, always: Mapping[str, object]
    ):
        self.store, self.backend, self.watcher, self.tally, self.always = store, backend, watcher, tally, always
        self.flying: dict[Future[Outcome], PlannedTrial] = {}
        self.packed: dict[tuple[str, str], bytes] = {}
        self.deaths: Counter[str] = Counter()
        self.doubtful: deque[PlannedTrial] = deque()
        """Trials during which a worker died. They run last and alone, so that a guilty one takes nothing with it."""

    def through(self, queue: deque[PlannedTrial]) -> None:
        """Compute everything in ``queue``."""
        while queue or self.flying or self.doubtful:
            slots = self.backend.slots()
            while queue and len(self.flying) < max(1, slots):
                self.launch(queue)
            if self.doubtful and not queue and not self.flying:
                self.launch(self.doubtful)
            self.tally.running = min(slots, len(self.flying))
            ended, _ = wait(self.flying, timeout=WAIT_S, return_when=FIRST_COMPLETED)
            lost = [task for future in ended if (task := self.land(future)) is not None]
            if lost:
                self.bury(lost)
            self.watcher.tick(self.tally, slots)

    def launch(self, queue: deque[PlannedTrial]) -> None:
        """Hand the first trial to a worker, unless another run has stored it by now."""
        task = queue.popleft()
        kind = task.claim.id, task.name
        if self.store.has(task):
            self.tally.stored += 1
            self.tally.todo -= 1
            self.tally.left[kind] -= 1
            return
        if kind not in self.packed:
            self.packed[kind] = pack(task.claim.trial, task.setting.config)
        try:
            self.flying[self.backend.submit(compute, self.packed[kind], task.seed)] = task
        except self.backend.deaths:
            queue.appendleft(task)
            self.bury([])

    def land(self, future: Future[Outcome]) -> PlannedTrial | None:
        """Take in a future that has ended; returns its trial where the worker died."""
        task = self.flying.pop(future)
        kind = task.claim.id, task.name
        try:
            outcome = future.result()
        except self.backend.deaths:
            return task
        except Exception as error:
            if lost_touch(error):
                raise gone(error) from error
            outcome = Outcome(0.0, error=f"{type(error).__name__}: {error}", traceback=traceback.format_exc())
        self.tally.left[kind] -= 1
        if outcome.error:
            self.fail(task, outcome.error, outcome.traceback)
            return None
        made_with = outcome.made_with or {}
        self.store.write(task, outcome.result, **made_with, wall_seconds=round(outcome.seconds, 3))
        count, spent = self.tally.seconds.get(kind, (0, 0.0))
        self.tally.seconds[kind] = count + 1, spent + outcome.seconds
        self.tally.done += 1
        return None

    def bury(self, lost: list[PlannedTrial]) -> None:
        """Get over the death of a worker, and of those that went with it."""
        if self.backend.all_die_together:
            ended, left = wait(self.flying, timeout=10 * WAIT_S)
            lost = lost + [task for future in ended if (task := self.land(future)) is not None]
            lost += [self.flying.pop(future) for future in left]
        self.backend.restart()
        self.tally.deaths += 1
        for task in lost:
            self.deaths[task.key] += 1
            if self.deaths[task.key] < self.backend.most_deaths:
                self.doubtful.append(task)
            else:
                self.tally.left[task.claim.id, task.name] -= 1
                self.fail(task, "its worker died every time that it was tried, the last times alone", "")

    def fail(self, task: PlannedTrial, error: str, told: str) -> None:
        """Note a trial that failed."""
        alone = command([task.claim.id], self.store.folder, setting=task.name, seed=task.seed, runs=1, **self.always)
        self.store.write_failure(task, error, told, alone)
        self.tally.failed.append((task, error, alone))


def command(claims: Sequence[str], folder: Path, **options: object) -> str:
    """The command line that runs these claims."""
    given: Mapping[str, object] = {**options, "out": folder}
    words = [word for name, value in given.items() if value is not None for word in (f"--{name}", str(value))]
    return f"jointattn experiment run {shlex.join([*claims, *words])}"
