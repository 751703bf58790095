"""Result of a run: summary, modules, log, contingency over time and learned maps, in memory or in a folder."""

import json
import shutil
from dataclasses import dataclass
from functools import cached_property, partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from jointattn_mj.development.behaviour import BehaviourLog, BehaviourPhase, phases
from jointattn_mj.development.config import DevelopmentConfig, config_class
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import meanings
from jointattn_mj.development.summary import DevelopmentSummary, LearnedModule, map_name, summarise
from jointattn_mj.errors import OutputError
from jointattn_mj.io.configs import read_config
from jointattn_mj.io.files import claimed, write_whole
from jointattn_mj.io.former_names import present_file, present_name
from jointattn_mj.io.kinds import check_kind
from jointattn_mj.io.progress import count
from jointattn_mj.io.provenance import write_config
from jointattn_mj.options import path_of

if TYPE_CHECKING:  # pyarrow takes half a second to import
    from jointattn_mj.io.table import Table

STEPS, CONTINGENCY, SUMMARY, CONFIG = "steps.parquet", "contingency.parquet", "summary.json", "config.yaml"
FIGURES = "sac.png", "behaviour.png", "maps.png"


@dataclass(frozen=True, eq=False, repr=False)
class DevelopmentResult:
    """Result of a finished run: modules, log, contingency and maps.

    Tables and maps of a result that lies in a folder are read from there when they are first asked for. Two results are
    equal if config, summary, tables and maps are.

    Attributes:
        summary: Modules, behaviour rates by phase, final ranking of events.
        folder: Where the results lie; None for a result in memory.

    Examples:
        >>> from jointattn_mj import Development, DevelopmentResult
        >>> result = Development("fast", steps=2000, seed=1).run()
        >>> result
        DevelopmentResult(table, fast, seed 1, 2,000 steps, no module, in memory)
        >>> result.save("out/a_short_run")
        >>> DevelopmentResult.open("out/a_short_run") == result
        True
        >>> result.log.to_pandas()["behaviour"].iloc[-1]
        'FG'
    """

    summary: DevelopmentSummary
    _source: "_Source"

    @classmethod
    def open(cls, folder: str | PathLike[str]) -> "DevelopmentResult":
        """The result of a run that has finished in ``folder``.

        Args:
            folder: What ``--out`` or ``run(out=...)`` named, or ``save``.

        Returns:
            The result, equal to the one that the run returned.

        Raises:
            OutputError: The folder holds no finished run.

        Examples:
            >>> from jointattn_mj import Development, DevelopmentResult
            >>> result = Development("fast", steps=500, seed=1).run()
            >>> result.save("out/few_steps")
            >>> DevelopmentResult.open("out/few_steps") == result
            True
        """
        path = path_of(folder, "folder") / SUMMARY
        check_kind(path.parent, cls.__name__)
        try:
            summary = DevelopmentSummary.from_json(json.loads(path.read_text("utf-8")))
        except FileNotFoundError as error:
            raise OutputError(f"there is no finished run in {folder}: it has no {SUMMARY}") from error
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise OutputError(f"cannot read {path} ({error}); give the folder of a finished development") from error
        return cls(summary, _Folder(path.parent, summary.world))

    @property
    def folder(self) -> Path | None:
        """Where the results lie; None for a result in memory."""
        return self._source.folder

    @cached_property
    def config(self) -> DevelopmentConfig:
        """All options of the run.

        Raises:
            ConfigError: The config.yaml of a folder cannot be read.
        """
        return self._source.config()

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
        return tuple(self._source.map(module.number) for module in self.modules)

    def save(self, folder: str | PathLike[str]) -> None:
        """Write summary, tables, maps, figures and config to a folder, as ``jointattn develop`` does.

        Args:
            folder: Made when missing.

        Raises:
            OutputError: The folder holds another run, or cannot be written.

        Examples:
            >>> from jointattn_mj import Development
            >>> result = Development("fast", steps=500, seed=1).run()
            >>> result.folder is None
            True
            >>> result.save("out/kept")
        """
        with claimed(out := path_of(folder, "folder")):
            self._source.save(out)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, DevelopmentResult):
            return NotImplemented
        return (
            self.summary == other.summary
            and self.config == other.config
            and self.log == other.log
            and self.contingency == other.contingency
            and self.maps == other.maps
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        summary, where = self.summary, "in memory" if self.folder is None else f"in {self.folder}"
        names = ", ".join(module.name for module in summary.modules)
        modules = f"{count(len(summary.modules), 'module')} ({names})" if names else "no module"
        run = f"{summary.world}, {summary.preset}, seed {summary.seed}, {summary.steps:,} steps"
        return f"DevelopmentResult({run}, {modules}, {where})"


class _Source(Protocol):
    """Where the parts of a result come from."""

    @property
    def folder(self) -> Path | None: ...

    def config(self) -> DevelopmentConfig: ...

    def log(self) -> "Table": ...

    def contingency(self) -> "Table": ...

    def map(self, number: int) -> "Table": ...

    def save(self, folder: Path) -> None: ...


class _Folder:
    """The files of a finished run."""

    def __init__(self, folder: Path, world: str):
        self.folder, self._world = folder, world

    def config(self) -> DevelopmentConfig:
        return read_config(self.folder / CONFIG, config_class(self._world))

    def log(self) -> "Table":
        return self._table(STEPS)

    def contingency(self) -> "Table":
        return self._table(CONTINGENCY)

    def map(self, number: int) -> "Table":
        from jointattn_mj.development.logbook import map_table, read_map

        path = self.folder / map_name(number)
        try:
            return map_table(read_map(path))
        except (OSError, ValueError) as error:
            raise OutputError(f"cannot read the map {path} ({error}); give the folder of a finished run") from error

    def save(self, folder: Path) -> None:
        maps = sorted(path.name for path in self.folder.glob("module_*.csv"))
        for name in (CONFIG, *FIGURES, STEPS, CONTINGENCY, *maps, SUMMARY):
            write_whole(folder / name, partial(shutil.copyfile, present_file(self.folder, name)))

    def _table(self, name: str) -> "Table":
        from jointattn_mj.io.table import Table

        return Table.read(present_file(self.folder, name), present_name)


class Finished:
    """A run that has ended, as the source of its result."""

    folder = None

    def __init__(self, config: DevelopmentConfig, run: DevelopmentRun):
        self._config, self._run = config, run
        self._variables = run.named_variables()
        self._made = [detection for detection in run.detections if detection.module is not None]
        self._meanings = meanings(self._variables, run.agent.modules)

    def result(self) -> DevelopmentResult:
        """The result of the run."""
        return DevelopmentResult(self._summary(), self)

    def config(self) -> DevelopmentConfig:
        """See ``DevelopmentResult``."""
        return self._config

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
        return phases(BehaviourLog(self._run), [detection.step for detection in self._made])

    def _draw(self, folder: Path) -> None:
        from jointattn_mj.development import figures

        run, agent = self._run, self._run.agent
        marks = [
            figures.Made(made.step, agent.events.index(made.event), meaning.label)
            for made, meaning in zip(self._made, self._meanings, strict=True)
        ]
        names = [self._variables.describe(event) for event in agent.events]
        detector = agent.config.detector
        unit = "bits" if detector.base == 2 else f"units of base {detector.base:g}"
        measure = {"sac": "SAC (eq. 5.2)", "tc": "T^C (eq. 4.3)"}.get(detector.ranks_by, "SAC where it is surest")
        maps = [
            figures.MapImage(f"{number}: {mark.label}", module, self._variables)
            for number, (mark, module) in enumerate(zip(marks, agent.modules, strict=True), 1)
        ]
        sac, behaviour, learned = (folder / name for name in FIGURES)
        figures.draw_contingency(sac, run.contingency_log, names, marks, f"{measure}, {unit}")
        figures.draw_behaviour(behaviour, BehaviourLog(run), self._phases(), marks)
        figures.draw_maps(learned, maps)
