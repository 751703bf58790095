"""Computes the trials that are missing of some claims. Failed trials and dead workers do not stop the others."""

import shlex
import traceback
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Annotated

from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.options import Checked, Seed, Whole, warn_renamed
from jointattn_mj.sweeps.backends import Backend, gone, lost_touch
from jointattn_mj.sweeps.claim import Claim
from jointattn_mj.sweeps.store import Keys, PlannedTrial, Store
from jointattn_mj.sweeps.worker import TrialOutcome, compute, pack

GOLDEN = 0.618
"""Runs that share a folder begin this share of the queue apart, which spreads any number of them."""
FORMER_SETTINGS = {"truth/": "state/", "an image every turn": "an image every step", "exact_places": "exact_locations"}
"""Beginnings of settings as version 0.1 called them, and as they are called now."""
WAIT_S = 1.0
"""Seconds after which progress is reported though no trial has ended."""


@dataclass
class Tally:
    """Progress of a run of trials."""

    todo: int = 0
    """Trials that were missing at the beginning."""
    stored: int = 0
    """Trials that were stored at the beginning."""
    done: int = 0
    """Trials computed and stored by this run."""
    failed: list[tuple[PlannedTrial, str, str]] = field(default_factory=list)
    """Failed trials, each with its error and the command that runs it alone."""
    running: int = 0
    """Trials in workers now."""
    deaths: int = 0
    """Number of workers that died."""
    left: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Trials still to do, by claim and setting."""
    seconds: dict[tuple[str, str], tuple[int, float]] = field(default_factory=dict)
    """Number and computing time of finished trials, by claim and setting."""

    def __repr__(self) -> str:
        return f"Tally({self.done} of {self.todo} done, {self.stored} stored before, {len(self.failed)} failed)"

    def work_left_s(self) -> float | None:
        """Seconds of computing still to do, from the finished trials of the same settings; None before the first."""
        known = sum(count for count, _ in self.seconds.values())
        if not known:
            return None
        mean = sum(spent for _, spent in self.seconds.values()) / known
        per_trial = {kind: spent / count for kind, (count, spent) in self.seconds.items()}
        return sum(count * per_trial.get(kind, mean) for kind, count in self.left.items())


class SweepWatcher:
    """Receives the progress of a run; this one ignores it. ``slots`` is the number of trials that can run at once."""

    def begin(self, tally: Tally, slots: int) -> None:
        """Called before the first trial."""

    def tick(self, tally: Tally, slots: int) -> None:
        """Called whenever a trial has ended, and every second."""

    def end(self, tally: Tally) -> None:
        """Called after the last trial, or when the run is cut short."""


@dataclass(frozen=True)
class Selection(Checked):
    """A choice of a claim's trials. None means all settings, the setting's number of runs, the claim's first seed."""

    setting: str | None = None
    """Id of a setting, or the beginning of several ids."""
    runs: Annotated[int, Whole("[1, 1e6]")] | None = None
    """Runs of each setting."""
    seed: Seed | None = None
    """Seed of the first run."""

    def names(self, claim: Claim) -> list[str]:
        """Ids of the chosen settings."""
        if self.setting is None:
            return list(claim.settings)
        if self.setting in claim.settings:
            return [self.setting]
        chosen = [name for name in claim.settings if name.startswith(self.setting)]
        former = next((name for name in FORMER_SETTINGS if self.setting.startswith(name)), None)
        if not chosen and former is not None:
            current = self.setting.replace(former, FORMER_SETTINGS[former], 1)
            chosen = replace(self, setting=current).names(claim)
            if chosen:
                warn_renamed(f"setting {self.setting}", current)
        return chosen

    def seeds(self, claim: Claim, names: Iterable[str]) -> dict[str, range]:
        """Chosen seeds of each of these settings."""
        first = claim.first_seed if self.seed is None else self.seed
        return {
            name: range(first, first + (claim.settings[name].runs if self.runs is None else self.runs))
            for name in names
        }


def plan(claims: Sequence[Claim], selection: Selection) -> Iterator[PlannedTrial]:
    """All chosen trials, claim after claim.

    Raises:
        ConfigError: No claim has the chosen setting.
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
    """Compute and store the trials that are missing. Trials that failed before are tried again.

    An error in a trial, or the death of its worker, ends that trial and no other.

    Args:
        claims: The claims.
        selection: Which of their trials.
        folder: Folder of results.
        backend: Where trials are computed; it is closed at the end.
        watcher: Receives the progress.
        always: Options of the command that runs a failed trial alone, such as ``registry``.

    Returns:
        The counts at the end, with the trials that failed.

    Raises:
        OutputError: The folder cannot be written; trials stored before stay.
        SweepError: The workers are gone for good.
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
        with store.berth() as number:
            queue.rotate(-int(number * GOLDEN % 1 * len(queue)))
            _Run(store, backend, watcher, tally, always).through(queue)
    finally:
        backend.close()
        tally.running = 0
        watcher.end(tally)
    return tally


class _Run:
    """The state of a run: trials with workers, packed settings, and trials during which workers died."""

    def __init__(
        self, store: Store, backend: Backend, watcher: SweepWatcher, tally: Tally, always: Mapping[str, object]
    ):
        self.store, self.backend, self.watcher, self.tally, self.always = store, backend, watcher, tally, always
        self.flying: dict[Future[TrialOutcome], PlannedTrial] = {}
        self.packed: dict[tuple[str, str], bytes] = {}
        self.deaths: Counter[str] = Counter()
        self.doubtful: deque[deque[PlannedTrial]] = deque()
        """Trials during which a worker died. They run last, half of those that died together at a time: one that kills
        is soon alone, and the others do not wait for each other."""

    def through(self, queue: deque[PlannedTrial]) -> None:
        """Compute all trials of ``queue``."""
        while queue or self.flying or self.doubtful:
            slots = self.backend.slots()
            while queue and len(self.flying) < max(1, slots):
                self.launch(queue)
            if self.doubtful and not queue and not self.flying:
                queue = self.doubtful.popleft()
                continue
            self.tally.running = min(slots, len(self.flying))
            ended, _ = wait(self.flying, timeout=WAIT_S, return_when=FIRST_COMPLETED)
            lost = [task for future in ended if (task := self.land(future)) is not None]
            if lost:
                self.bury(lost)
            self.watcher.tick(self.tally, slots)

    def launch(self, queue: deque[PlannedTrial]) -> None:
        """Hand the first trial to a worker, unless another run has stored it meanwhile."""
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

    def land(self, future: Future[TrialOutcome]) -> PlannedTrial | None:
        """Store the result of a future that has ended; returns its trial if the worker died."""
        task = self.flying.pop(future)
        kind = task.claim.id, task.name
        try:
            outcome = future.result()
        except self.backend.deaths:
            return task
        except SweepError:
            raise
        except Exception as error:
            if lost_touch(error):
                raise gone(error) from error
            outcome = TrialOutcome(0.0, error=f"{type(error).__name__}: {error}", traceback=traceback.format_exc())
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
        """Restart the backend after a death, and queue the trials that it ended or count them as failed."""
        if self.backend.all_die_together:
            ended, left = wait(self.flying, timeout=10 * WAIT_S)
            lost = lost + [task for future in ended if (task := self.land(future)) is not None]
            lost += [self.flying.pop(future) for future in left]
        self.backend.restart()
        self.tally.deaths += 1
        suspects = deque[PlannedTrial]()
        for task in lost:
            self.deaths[task.key] = self.deaths[task.key] + 1 if len(lost) == 1 else max(self.deaths[task.key], 1)
            if self.deaths[task.key] < self.backend.most_deaths:
                suspects.append(task)
            else:
                self.tally.left[task.claim.id, task.name] -= 1
                self.fail(task, "its worker died at every attempt, in the last ones with this trial alone", "")
        half = (len(suspects) + 1) // 2
        for group in (deque(islice(suspects, half)), deque(islice(suspects, half, None))):
            if group:
                self.doubtful.append(group)

    def fail(self, task: PlannedTrial, error: str, told: str) -> None:
        """Store the note of a failed trial.

        Args:
            task: The trial.
            error: The error in one line.
            told: Its traceback.
        """
        alone = command([task.claim.id], self.store.folder, setting=task.name, seed=task.seed, runs=1, **self.always)
        self.store.write_failure(task, error, told, alone)
        self.tally.failed.append((task, error, alone))


def command(claims: Sequence[str], folder: Path, **options: object) -> str:
    """Command line that runs these claims into ``folder``; options that are None are left out."""
    given: Mapping[str, object] = {**options, "out": folder}
    words = [word for name, value in given.items() if value is not None for word in (f"--{name}", str(value))]
    return f"jointattn experiment run {shlex.join([*claims, *words])}"
