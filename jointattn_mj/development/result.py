"""Result of a run: summary, modules, log, contingency over time and learned maps, in memory or in a folder."""

import json
import shutil
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from jointattn_mj.development.behaviour import BehaviourLog, BehaviourPhase, phases
from jointattn_mj.development.config import DevelopmentConfig
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import meanings
from jointattn_mj.development.summary import DevelopmentSummary, LearnedModule, map_name, summarise
from jointattn_mj.errors import OutputError
from jointattn_mj.io.files import claimed, write_whole
from jointattn_mj.io.notices import notice
from jointattn_mj.io.provenance import write_config

if TYPE_CHECKING:  # pyarrow takes half a second to import
    from jointattn_mj.io.table import Table

STEPS, CONTINGENCY, SUMMARY, CONFIG = "steps.parquet", "contingency.parquet", "summary.json", "config.yaml"
FIGURES = "sac.png", "behaviour.png", "maps.png"
OLD_NAMES = {STEPS: "turns.parquet"}
"""Names of files in the last version."""
OLD_COLUMNS = {"turn": "step"}
"""Columns of both tables by their names in the last version."""


class DevelopmentResult:
    """What a run came to.

    Two results are equal if their summaries, tables and maps are; a result that was saved and opened again equals the
    first one.

    Attributes:
        summary: Modules, behaviour rates by phase, final ranking of events.

    Example:
        >>> from jointattn_mj.development.run import Development
        >>> result = Development("fast", steps=2000, seed=1).run()
        >>> result
        <DevelopmentResult: table, preset fast, seed 1, 2,000 steps; modules: gaze following>
        >>> result.log["behaviour"][-1] in ("FG", "NFG", "KEC", "SC", "SS", "SO")
        True
    """

    def __init__(self, summary: DevelopmentSummary, source: "_Source"):
        self.summary, self._source = summary, source

    @classmethod
    def open(cls, folder: Path | str) -> "DevelopmentResult":
        """The result in a folder, where a run or ``save`` has left it.

        Args:
            folder: As it was given as ``out``.

        Raises:
            OutputError: There is no finished run in the folder.
        """
        folder = Path(folder)
        path = folder / SUMMARY
        try:
            return cls(DevelopmentSummary.from_json(json.loads(path.read_text("utf-8"))), _Folder(folder))
        except FileNotFoundError as error:
            raise OutputError(f"there is no finished run in {folder}: it has no {SUMMARY}") from error
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise OutputError(f"cannot read {path} ({error}); give the folder of a finished development") from error

    @property
    def modules(self) -> tuple[LearnedModule, ...]:
        """The modules in the order in which they were made, with what each means."""
        return self.summary.modules

    @cached_property
    def log(self) -> "Table":
        """A row a step: what the robot sensed and did, its behaviour, and what it could not know."""
        return self._source.log()

    @cached_property
    def contingency(self) -> "Table":
        """The contingency of every event over time, a row every ``sample_every`` steps."""
        return self._source.contingency()

    @cached_property
    def maps(self) -> tuple["Table", ...]:
        """The map of each module: under which observables it gives which command, how reliably, and what it expects."""
        return tuple(self._source.map(one.number) for one in self.modules)

    def save(self, folder: Path | str) -> None:
        """Write summary, tables, maps, figures and config to a folder, as ``jointattn develop`` does.

        Args:
            folder: Made when missing.

        Raises:
            OutputError: The folder holds another run, or cannot be written.
        """
        folder = Path(folder)
        with claimed(folder):
            self._source.save(folder)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, DevelopmentResult):
            return NotImplemented
        return (
            self.summary == other.summary
            and self.log == other.log
            and self.contingency == other.contingency
            and self.maps == other.maps
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<DevelopmentResult: {repr(self.summary).strip('<>')}>"


class _Source(Protocol):
    """Where the parts of a result come from."""

    def log(self) -> "Table": ...

    def contingency(self) -> "Table": ...

    def map(self, number: int) -> "Table": ...

    def save(self, folder: Path) -> None: ...


class _Folder:
    """The files of a finished run."""

    def __init__(self, folder: Path):
        self._folder = folder

    def log(self) -> "Table":
        return self._table(STEPS)

    def contingency(self) -> "Table":
        return self._table(CONTINGENCY)

    def map(self, number: int) -> "Table":
        from jointattn_mj.development.logbook import map_table, read_map

        path = self._folder / map_name(number)
        try:
            return map_table(read_map(path))
        except (OSError, ValueError) as error:
            raise OutputError(f"cannot read the map {path} ({error}); give the folder of a finished run") from error

    def save(self, folder: Path) -> None:
        maps = sorted(path.name for path in self._folder.glob("module_*.csv"))
        for name in (CONFIG, *FIGURES, STEPS, CONTINGENCY, *maps, SUMMARY):
            write_whole(folder / name, partial(shutil.copyfile, self._path(name)))

    def _table(self, name: str) -> "Table":
        from jointattn_mj.io.table import Table

        return Table.read(self._path(name), OLD_COLUMNS)

    def _path(self, name: str) -> Path:
        path, old = self._folder / name, self._folder / OLD_NAMES.get(name, name)
        if path.exists() or path == old or not old.exists():
            return path
        notice(f"{old} was written by an earlier version; the file is now called {name}, its column turn step")
        return old


class Finished:
    """A run that has ended, as the source of its result."""

    def __init__(self, config: DevelopmentConfig, run: DevelopmentRun):
        self._config, self._run = config, run
        self._variables = run.named_variables()
        self._made = [one for one in run.found if one.module is not None]
        self._meanings = meanings(self._variables, run.agent.modules)

    def result(self) -> DevelopmentResult:
        """The result of the run."""
        return DevelopmentResult(self._summary(), self)

    def log(self) -> "Table":
        """See ``DevelopmentResult``."""
        from jointattn_mj.development.logbook import steps_table

        return steps_table(self._run)

    def contingency(self) -> "Table":
        """See ``DevelopmentResult``."""
        from jointattn_mj.development.logbook import contingency_table

        return contingency_table(self._run)

    def map(self, number: int) -> "Table":
        """The map of a module, which are counted from 1."""
        from jointattn_mj.development.logbook import map_rows, map_table

        return map_table(map_rows(self._variables, self._run.agent.modules[number - 1]))

    def save(self, folder: Path) -> None:
        """Write all files; ``summary.json`` comes last and says that all are there."""
        from jointattn_mj.development.logbook import map_rows, write_contingency, write_map, write_steps

        if not (folder / CONFIG).exists():
            write_config(folder / CONFIG, self._config)
        self._draw(folder)
        write_steps(folder / STEPS, self._run)
        write_contingency(folder / CONTINGENCY, self._run)
        for number, module in enumerate(self._run.agent.modules, 1):
            write_map(folder / map_name(number), map_rows(self._variables, module))
        text = json.dumps(self._summary().to_json(), indent=1, ensure_ascii=False) + "\n"
        write_whole(folder / SUMMARY, lambda path: path.write_text(text, "utf-8"))

    def _summary(self) -> DevelopmentSummary:
        names = {"world": self._config.world, "preset": self._config.preset, "seed": self._config.seed}
        return summarise(self._run, names, self._meanings, self._phases())

    def _phases(self) -> list[BehaviourPhase]:
        return phases(BehaviourLog(self._run), [one.step for one in self._made])

    def _draw(self, folder: Path) -> None:
        from jointattn_mj.development import figures

        run, agent = self._run, self._run.agent
        marks = [
            figures.Made(one.step, agent.events.index(one.event), meaning.label)
            for one, meaning in zip(self._made, self._meanings, strict=True)
        ]
        names = [self._variables.describe(event) for event in agent.events]
        detector = agent.config.detector
        unit = "bits" if detector.base == 2 else f"units of base {detector.base:g}"
        measure = f"{'SAC' if detector.measure == 'sac' else 'T^C'} ({unit})"
        maps = [
            figures.MapImage(f"{number}: {mark.label}", module, self._variables)
            for number, (mark, module) in enumerate(zip(marks, agent.modules, strict=True), 1)
        ]
        sac, behaviour, learned = (folder / name for name in FIGURES)
        figures.draw_contingency(sac, run.noted, names, marks, measure)
        figures.draw_behaviour(behaviour, BehaviourLog(run), self._phases(), marks)
        figures.draw_maps(learned, maps)
