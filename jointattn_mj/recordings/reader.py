"""Reads coded interaction from files of any kind, as events and as steps that the measures take."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from jointattn_mj.errors import SeriesError
from jointattn_mj.options import Real, as_arguments, shown
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.groups import of_column, of_tier
from jointattn_mj.recordings.sampling import Missing, SampleOptions
from jointattn_mj.recordings.sources import SourceOptions, files_of, open_frame, open_source
from jointattn_mj.recordings.step_tables import Fractions, read_steps
from jointattn_mj.recordings.steps import Recordings
from jointattn_mj.recordings.table_files import TableFile

if TYPE_CHECKING:
    from jointattn_mj.recordings.agreement import Agreement
    from jointattn_mj.recordings.discover import DiscoverResult
    from jointattn_mj.recordings.measure import MeasureResult
    from jointattn_mj.recordings.report import RecordingReport
    from jointattn_mj.recordings.transitions import TransitionResult


@dataclass(frozen=True, kw_only=True)
class ReadOptions(SourceOptions, SampleOptions):
    """How files of coded interaction are read."""

    step: Annotated[float, Real("[1e-6, 1e6]")] | None = None
    """Sample events to steps of so many seconds, such as 0.1; not needed where rows are steps."""
    fractions: Fractions = "error"
    """What numbers with fractions are in a column of steps: an error, as measurements are first sorted into bins, or
    names like others."""

    ADVANCED: ClassVar[Sequence[str]] = ("fractions",)

    def read(self, path: Any, columns: str | Sequence[str]) -> Recordings:
        """Read columns or tiers as :func:`read_recordings` does, with these options.

        Args:
            path: A file, a folder of files, or a table of pandas, polars or pyarrow.
            columns: Names of the variables to read, or one name.

        Returns:
            Codes by variable, recording by recording, and the label of each code.

        Raises:
            SeriesError: It cannot be read or sampled.

        Examples:
            >>> import pandas
            >>> from jointattn_mj.recordings import ReadOptions
            >>> ReadOptions().read(pandas.DataFrame({"gaze": ["toy", "away", "toy"]}), "gaze")
            Recordings(3 rows, 1 recording, 1 column: gaze)
        """
        names = tuple(dict.fromkeys(_tuple(columns)))
        if not names:
            raise SeriesError(f"expected the name of a column, or several; got {shown(columns)}")
        return Coding(path, self, names).steps(self.step)


@dataclass(frozen=True, eq=False)
class Coding:
    """Coded interaction in a file, a folder of files, or a table; it is read when it is asked for.

    Attributes:
        source: A path, or a table of pandas, polars or pyarrow.
        options: How it is read.
        columns: Columns or tiers that are asked for; None: all.
        by: Columns that say what each recording is, such as an age.

    Examples:
        >>> import pandas
        >>> from jointattn_mj import recordings
        >>> coding = recordings.read(pandas.DataFrame({"mother": ["toy", "away"] * 50, "infant": ["toy", "toy"] * 50}))
        >>> coding.steps().transitions
        99
    """

    source: Any
    options: ReadOptions
    columns: tuple[str, ...] | None = None
    by: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Coding({shown(self.source if isinstance(self.source, (str, Path)) else type(self.source).__name__)})"

    @property
    def events(self) -> Events:
        """What is coded from when to when.

        Raises:
            SeriesError: It cannot be read, or it has a row for every step.
        """
        content, remarks = self._content
        events = [part for part in content if isinstance(part, Events)]
        if len(events) < len(content):
            path = next(part.path for part in content if isinstance(part, TableFile))
            raise SeriesError(
                f"{path} has a row for every step, and no events: no columns that say when something begins and ends"
            )
        known: set[tuple[str, str]] = set()
        for part in events:
            tiers = {(recording, tier) for recording, tiers in part.tiers.items() for tier in tiers}
            if known & tiers:
                recording, tier = min(known & tiers)
                raise SeriesError(
                    f"several files have the tier {tier!r} of recording {recording!r}; give recordings different "
                    "names, or name a column that tells them apart with `recording`"
                )
            known |= tiers
        whole = events[0].joined(*events[1:]) if len(events) > 1 else events[0]
        return replace(whole, remarks=(*whole.remarks, *remarks))

    def steps(self, step: float | None = None, columns: Iterable[str] | None = None, **how: Any) -> Recordings:
        """Steps of equal length for the measures.

        Args:
            step: Length of a step in seconds, for events; None where rows are steps.
            columns: Tiers or columns; None: all that were asked for.
            how: Fields of :class:`SampleOptions` other than when the file was opened.

        Returns:
            A variable for each tier or column, recording by recording.

        Raises:
            SeriesError: It cannot be read or sampled.
            ConfigError: An option that cannot work.

        Examples:
            >>> import pandas
            >>> from jointattn_mj import recordings
            >>> looks = ["toy", "away", "toy", "toy", "away"] * 40
            >>> coding = recordings.read(pandas.DataFrame({"mother": looks[1:], "infant": looks[:-1]}))
            >>> coding.steps()
            Recordings(199 rows, 1 recording, 2 columns: mother, infant)
        """
        options = replace(self.options, step=step, **how)
        names = self.columns if columns is None else _tuple(columns)
        same = replace(self, options=options, columns=names)
        content, remarks = same._content
        if step is None and any(isinstance(part, Events) for part in content):
            raise SeriesError(f"{same._name} is of events; say how long a step is, such as `step=0.1` (seconds)")
        if step is None:
            return read_steps(
                [part for part in content if isinstance(part, TableFile)],
                names,
                options.recording,
                options.missing,
                options.missing_values,
                options.fractions,
                remarks,
            )
        wanted = {name: getattr(options, name) for name in _names(SampleOptions)}
        return same.events.steps(step, names, **wanted)

    def about(self, column: str) -> dict[str, str]:
        """Give what each recording is, such as the age of its infant.

        Args:
            column: Name of a column, or of a tier, that has the same value in all of a recording.

        Returns:
            The values by the names of the recordings; without those that have none.

        Raises:
            SeriesError: There is no such column or tier, or it changes within a recording.

        Examples:
            >>> import pandas
            >>> from jointattn_mj import recordings
            >>> table = {"dyad": ["a", "b"], "age": [6, 9], "onset": [0, 0], "offset": [2, 3], "code": ["toy", "face"]}
            >>> recordings.read(pandas.DataFrame(table), recording="dyad", step=0.1, time_unit="s").about("age")
            {'a': '6', 'b': '9'}
        """
        of_steps = self.options.step is None and self.columns is not None
        coding = replace(self, by=(column,), columns=(column,) if of_steps else None)
        content, _ = coding._content
        if not all(isinstance(part, Events) for part in content):
            return of_column(coding.steps(columns=(column,)), column)
        events = coding.events
        return dict(events.about[column]) if column in events.about else of_tier(events, column)

    def measure(
        self,
        source: str | Sequence[str],
        target: str | Sequence[str],
        condition: str | Sequence[str] = (),
        step: float | None = None,
        **how: Any,
    ) -> "MeasureResult":
        """Measure how much one variable says about the next value of another, as ``jointattn measure`` does.

        Args:
            source: Tier or column whose influence is asked for; several are taken jointly.
            target: Tier or column that may be influenced.
            condition: What is known anyway, such as an action.
            step: Length of a step in seconds, for events; None where rows are steps.
            how: Further fields of ``MeasureOptions``, such as ``surrogates``.

        Returns:
            All measures; ``print(result.text())`` shows them.

        Raises:
            SeriesError: It cannot be read, sampled or measured.
            ConfigError: An option that cannot work.

        Examples:
            >>> import pandas
            >>> from jointattn_mj import recordings
            >>> looks = ["toy", "away", "toy", "toy", "away"] * 40
            >>> coding = recordings.read(pandas.DataFrame({"mother": looks[1:], "infant": looks[:-1]}))
            >>> [one.name for one in coding.measure("mother", "infant", surrogates=99).measured]
            ['TE(s -> r)', "I(s; r')"]
        """
        from jointattn_mj.recordings.measure import MeasureOptions, run_measure

        names = _tuple(source), _tuple(target), _tuple(condition)
        options = MeasureOptions(**self._told(step, how), source=names[0], target=names[1], condition=names[2])
        return run_measure(options, source=self._whole)

    def discover(
        self,
        sensors: str | Sequence[str],
        actions: str | Sequence[str],
        results: str | Sequence[str],
        step: float | None = None,
        **how: Any,
    ) -> "DiscoverResult":
        """Rank events by their contingency, as ``jointattn discover`` does.

        Args:
            sensors: Tiers or columns of what is sensed.
            actions: Those of what is done.
            results: Those of what may come of it.
            step: Length of a step in seconds, for events; None where rows are steps.
            how: Further fields of ``DiscoverOptions``, such as ``measure``.

        Returns:
            The events, the most contingent first; ``print(result.text())`` shows them.

        Raises:
            SeriesError: It cannot be read, sampled or measured.
            ConfigError: An option that cannot work.

        Examples:
            >>> import pandas
            >>> from jointattn_mj import recordings
            >>> looks = ["toy", "away", "toy", "toy", "away"] * 40
            >>> coding = recordings.read(pandas.DataFrame({"mother": looks[1:], "infant": looks[:-1]}))
            >>> events = coding.discover("mother", "infant", "infant", surrogates=99)
            >>> len(events.rows())
            1
        """
        from jointattn_mj.recordings.discover import DiscoverOptions, run_discover

        names = _tuple(sensors), _tuple(actions), _tuple(results)
        options = DiscoverOptions(**self._told(step, how), sensors=names[0], actions=names[1], results=names[2])
        return run_discover(options, coded=Coding(self.source, options, (*names[0], *names[1], *names[2])).steps(step))

    def transitions(
        self, given: str, target: str | None = None, step: float | None = None, **how: Any
    ) -> "TransitionResult":
        """Count what follows what, as ``jointattn transitions`` does.

        Args:
            given: Tier or column of the earlier code.
            target: That of the later code; None: the same.
            step: Length of a step in seconds, for events; None where rows are steps.
            how: Further fields of ``TransitionOptions``, such as ``lag`` or ``unit``.

        Returns:
            Frequencies and what follows from them; ``print(result.text())`` shows them.

        Raises:
            SeriesError: It cannot be read, sampled or counted.
            ConfigError: An option that cannot work.

        Examples:
            >>> import pandas
            >>> from jointattn_mj import recordings
            >>> looks = ["toy", "away", "toy", "toy", "away"] * 40
            >>> coding = recordings.read(pandas.DataFrame({"mother": looks[1:], "infant": looks[:-1]}))
            >>> first = coding.transitions("mother", "infant", surrogates=99).table.rows()[0]
            >>> first["given"], first["target"], first["conditional"]
            ('away', 'away', 1.0)
        """
        from jointattn_mj.recordings.transitions import TransitionOptions, run_transitions

        options = TransitionOptions(**self._told(step, how), given=given, target=target)
        return run_transitions(options, Coding(self.source, options, tuple(dict.fromkeys(options.both))).steps(step))

    def agreement(self, second: Any, tiers: Sequence[str] | None = None, **how: Any) -> tuple["Agreement", ...]:
        """Compare with a second coder, as ``jointattn agreement`` does.

        Args:
            second: Coding of the same recordings, or what ``read`` takes, which is then read like this one.
            tiers: Tiers that are compared; None: all that both have.
            how: Fields of ``AgreementOptions``, such as ``step`` or ``tolerance_s``.

        Returns:
            Kappa and more for each tier.

        Raises:
            SeriesError: They cannot be read, or have nothing in common.
            ConfigError: An option that cannot work.

        Examples:
            >>> import pandas
            >>> from jointattn_mj import recordings
            >>> looks = {"tier": "infant", "onset": [0, 40], "offset": [40, 80], "code": ["toy", "face"]}
            >>> coding = recordings.read(pandas.DataFrame(looks), time_unit="s")
            >>> coding.agreement(coding)[0].kappa
            1.0
        """
        from jointattn_mj.recordings.agreement import AgreementOptions, agreement

        other = second if isinstance(second, Coding) else replace(self, source=second)
        return agreement(self.events, other.events, tiers, AgreementOptions(**how))

    def report(self, out: Path | str, **how: Any) -> "RecordingReport":
        """Make one page of the coding, as ``jointattn recordings`` does.

        Args:
            out: Folder for the page and its tables.
            how: Further fields of ``ReportOptions``, such as ``infant``, ``partner``, ``step`` or ``surrogates``.

        Returns:
            What the page shows; ``report.tables()`` are its tables.

        Raises:
            SeriesError: It cannot be read or analysed.
            ConfigError: An option that cannot work.
            OutputError: ``out`` holds a report, or cannot be written.

        Examples:
            >>> from jointattn_mj import recordings
            >>> times = list(range(0, 90, 3))
            >>> looks = {"onset": times, "offset": times[1:] + [90], "code": ["cup", "face", "ball"] * 10}
            >>> events = recordings.Events.of(["mother"] * 30, looks["code"], looks["onset"], looks["offset"])
            >>> follows = recordings.Events.of(["infant"] * 29, looks["code"][:29], [t + 1 for t in times[:29]],
            ...                                [t + 1 for t in times[1:]])
            >>> coding = recordings.read(events.joined(follows).to_pandas(), time_unit="s")
            >>> coding.report("out/page", surrogates=9, resamples=0, step=0.5).following()[0]
            'infant follows 19 of 20 looks of mother (95%) within 3 s, median latency 1.00 s'
        """
        from jointattn_mj.recordings.report import ReportOptions, run_report

        told = self._told(self.options.step or 0.1, how)
        return run_report(ReportOptions(**told, out=Path(out)), source=self._whole)

    def _told(self, step: float | None, how: dict[str, Any]) -> dict[str, Any]:
        """Fields of the options of a test of this coding."""
        own = {name: getattr(self.options, name) for name in _names(ReadOptions)}
        delays = {name: str(how[name]) for name in ("lag", "scan") if isinstance(how.get(name), int)}  # in steps
        return {**own, "file": Path(self._name), "step": step, **how, **delays}

    @property
    def _whole(self) -> Any:
        """The source, where it is no file."""
        return None if isinstance(self.source, (str, os.PathLike)) else self.source

    @property
    def _name(self) -> str:
        return str(self.source) if isinstance(self.source, (str, os.PathLike)) else "the table"

    @cached_property
    def _content(self) -> tuple[list[Events | TableFile], list[str]]:
        sampled = self.options.step is not None
        if not isinstance(self.source, (str, os.PathLike)):
            return [open_frame(self.source, self.options, self.columns, sampled, self.by)], []
        files, remarks = files_of(Path(self.source))
        return [open_source(path, self.options, self.columns, sampled, self.by) for path in files], remarks


def read(source: Any, **options: Any) -> Coding:
    """Read coded interaction: events of ELAN, BORIS, Datavyu, Observer or INTERACT, any table of events, or of steps.

    Args:
        source: A file, a folder of files, each a recording, or a table of pandas, polars or pyarrow.
        options: Fields of :class:`ReadOptions`, such as ``recording`` or ``rate``.

    Returns:
        The coding; ``coding.events`` are its events, ``coding.steps(0.1)`` its steps for the measures.

    Raises:
        ConfigError: An option that cannot work.

    Examples:
        >>> from pathlib import Path
        >>> from jointattn_mj import recordings
        >>> table = "tier,onset,offset,code\\ninfant,0.0,0.5,toy\\ninfant,0.5,1.0,face\\nmother,0.0,1.0,toy\\n"
        >>> _ = Path("dyad.csv").write_text(table)
        >>> coding = recordings.read("dyad.csv")
        >>> coding.events
        Events(3 events, 2 tiers, 1 recording)
        >>> coding.steps(0.25).columns["infant"]
        [array([1, 1, 0, 0], dtype=int32)]
    """
    with as_arguments():
        how = ReadOptions(**options)
    return Coding(source, how)


def read_recordings(
    path: Path | str,
    columns: str | Sequence[str],
    recording: str | None = None,
    missing: Missing = "error",
    *,
    step: float | None = None,
    encoding: str | None = None,
    skip_rows: int = 0,
    rows_are_steps: bool = False,
    **options: Any,
) -> Recordings:
    """Read columns of a table, or tiers of coded events, as series of codes for the estimators of ``contingency``.

    A file is a text, Parquet or Excel table, or of ELAN or Datavyu; what it holds counts, not its name. Labels lose
    blanks around them; 1.0 and 1,0 are the same as 1. Nothing, NA, NaN, null and such are missing.

    Args:
        path: The file, or a folder of files, each a recording.
        columns: Names of the variables to read, or one name.
        recording: Column that tells independent recordings apart: rows with the same value are one, in their order.
        missing: What a missing value does: ``"error"``, or ``"break"``, which cuts the recording there.
        step: Length of a step in seconds, to which events are sampled; None where rows are steps.
        encoding: Encoding of a text file, such as ``"cp1252"``; by default UTF-8, or what its byte order mark says.
        skip_rows: Lines above the header to leave out.
        rows_are_steps: Take rows as steps although columns such as onset and offset look like a list of events.
        options: Further fields of ``ReadOptions``, such as ``value_at`` or ``missing_values``.

    Returns:
        Codes by variable, recording by recording, and the label of each code.

    Raises:
        SeriesError: No such file or column, nothing in it, another encoding, missing values, numbers with fractions,
            a list of events without ``step``, events that overlap, or no transition.

    Examples:
        >>> from pathlib import Path
        >>> from jointattn_mj import read_recordings
        >>> _ = Path("gaze.csv").write_text("gaze,toy\\nleft,no\\nright,no\\nleft,yes\\n")
        >>> recordings = read_recordings("gaze.csv", ["gaze", "toy"])
        >>> recordings.columns["gaze"], recordings.labels["gaze"]
        ([array([0, 1, 0])], ('left', 'right'))
    """
    if not isinstance(path, (str, os.PathLike)):
        raise SeriesError(f"expected the path of a file; got {type(path).__name__}")
    with as_arguments():
        how = ReadOptions(
            recording=recording,
            missing=missing,
            step=step,
            encoding=encoding,
            skip_rows=skip_rows,
            rows_are_steps=rows_are_steps,
            **options,
        )
    return how.read(path, columns)


def _tuple(names: str | Iterable[str]) -> tuple[str, ...]:
    several = (names,) if isinstance(names, str) else tuple(names) if isinstance(names, Iterable) else (names,)
    if not all(isinstance(name, str) for name in several):
        raise SeriesError(f"expected the name of a column, or several; got {shown(names)}")
    return several


def _names(options: type[SampleOptions]) -> list[str]:
    """Names of the options of a class, without what it knows about them."""
    return [field.name for field in fields(options)]
