"""Recordings as series of equal steps: what the measures take."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointattn_mj.contingency.series import joint
from jointattn_mj.io.progress import count
from jointattn_mj.io.table import Table


@dataclass(frozen=True, repr=False)
class Recordings:
    """Variables as series of codes, and what the codes are called: what ``read_recordings`` returns.

    Its arrays go into the functions of ``contingency`` as they are; ``notes()`` says what a reader should know of them.

    Examples:
        >>> import numpy as np
        >>> from jointattn_mj.recordings import Recordings
        >>> gaze = {"mother": [np.array([0, 1, 1, 0])], "infant": [np.array([0, 0, 1, 1])]}
        >>> both = Recordings(gaze, dict.fromkeys(gaze, ("away", "toy")), groups=[0], rows=4, step=0.5)
        >>> both
        Recordings(4 rows, 1 recording, 2 columns: mother, infant)
        >>> both.transitions
        3
        >>> codes, labels = both.joined(["mother", "infant"])
        >>> labels
        ('away & away', 'away & toy', 'toy & away', 'toy & toy')
    """

    columns: dict[str, list[np.ndarray]]
    """Codes by variable, recording by recording."""
    labels: dict[str, tuple[str, ...]]
    """Label of each code by variable: numbers ascending, other labels in the order of the alphabet."""
    groups: list[int]
    """Which recording each of the series' arrays belongs to: pieces of one that was cut have the same number."""
    rows: int
    """Rows of the file, or steps that its events were sampled to."""
    cut: int = 0
    """Rows with missing values, at which recordings were cut."""
    alone: int = 0
    """Rows without missing values that take part in no transition, as nothing stands before or after them."""
    names: tuple[str, ...] = ()
    """Names of the recordings, by their numbers in ``groups``; empty where they have none."""
    step: float | None = None
    """Length of a step in seconds, where it is known."""
    remarks: tuple[str, ...] = ()
    """What else a reader should know: what was left out, and why."""

    @property
    def transitions(self) -> int:
        """Steps that have a next one."""
        return sum(len(part) - 1 for part in next(iter(self.columns.values())))

    def __repr__(self) -> str:
        names = ", ".join(self.columns)
        names = names if len(names) <= 60 else f"{names[:57]}..."
        recordings = count(len(set(self.groups)), "recording")
        return f"Recordings({count(self.rows, 'row')}, {recordings}, {count(len(self.columns), 'column')}: {names})"

    def joined(self, names: Sequence[str]) -> tuple[list[np.ndarray], tuple[str, ...]]:
        """Several variables taken as one; a single one is taken as it is.

        Args:
            names: Names of columns.

        Returns:
            Codes of the combinations, recording by recording, and the labels of those that occur, by their code.

        Raises:
            KeyError: There is no such column.

        Examples:
            >>> import numpy as np
            >>> from jointattn_mj.recordings import Recordings
            >>> gaze = {"mother": [np.array([0, 1, 1])], "infant": [np.array([0, 0, 1])]}
            >>> both = Recordings(gaze, dict.fromkeys(gaze, ("away", "toy")), groups=[0], rows=3)
            >>> both.joined(["mother", "infant"])
            ([array([0, 1, 2])], ('away & away', 'toy & away', 'toy & toy'))
        """
        if len(names) == 1:
            return self.columns[names[0]], self.labels[names[0]]
        codes = joint(*(self.columns[name] for name in names))
        parts = codes if isinstance(codes, list) else [codes]
        first = np.unique(np.concatenate(parts), return_index=True)[1]
        single = [np.concatenate(self.columns[name])[first] for name in names]
        combinations = zip(
            *(np.array(self.labels[name])[at] for name, at in zip(names, single, strict=True)), strict=True
        )
        return parts, tuple(" & ".join(combination) for combination in combinations)

    @property
    def table(self) -> Table:
        """A row a step: ``recording``, ``piece`` (what was cut has several), and the label of each variable."""
        import pyarrow as pa  # here, so that measures of arrays do without it

        lengths = [len(part) for part in next(iter(self.columns.values()))]
        names = self.names or tuple(str(group) for group in range(max(self.groups) + 1))
        columns = {
            "recording": pa.DictionaryArray.from_arrays(np.repeat(self.groups, lengths), pa.array(names, pa.string())),
            "piece": pa.array(np.repeat(np.arange(len(lengths)), lengths)),
        }
        for name, parts in self.columns.items():
            labels = pa.array(self.labels[name], pa.string())
            columns[name] = pa.DictionaryArray.from_arrays(np.concatenate(parts), labels)
        return Table(pa.table(list(columns.values()), names=list(columns)))

    def to_pandas(self) -> Any:
        """Give the table as ``pandas.DataFrame``.

        Returns:
            The data frame, with the same columns.

        Raises:
            ExtraError: The package pandas is not installed.

        Examples:
            >>> import numpy as np
            >>> from jointattn_mj.recordings import Recordings
            >>> gaze = Recordings({"gaze": [np.array([0, 1])]}, {"gaze": ("away", "toy")}, groups=[0], rows=2)
            >>> gaze.to_pandas()["gaze"].tolist()
            ['away', 'toy']
        """
        return self.table.to_pandas()

    def notes(self) -> tuple[str, ...]:
        """Say what a reader should know about rows that could not be used as they are.

        Returns:
            A sentence each, without its full stop; empty where all rows were used.

        Examples:
            >>> import numpy as np
            >>> from jointattn_mj.recordings import Recordings
            >>> Recordings({"gaze": [np.array([0, 1])]}, {"gaze": ("away", "toy")}, groups=[0], rows=3, cut=1).notes()
            ('1 of 3 rows have missing values; recordings were cut there',)
        """
        notes = []
        rows = "rows" if self.step is None else "steps"
        if self.cut:
            notes.append(f"{self.cut} of {self.rows} {rows} have missing values; recordings were cut there")
        if self.alone:
            notes.append(f"{self.alone} {rows} have nothing before or after them and take part in no transition")
        return (*notes, *self.remarks)


def pieces(absent: np.ndarray, recording: np.ndarray | None = None) -> list[np.ndarray]:
    """Row numbers of each stretch without gaps in one recording.

    Args:
        absent: Which rows have missing values, bool (rows,).
        recording: Number of each row's recording (rows,); None: all are of one.

    Returns:
        Arrays of rows, each in the order of the file, recording by recording.
    """
    order = np.arange(len(absent)) if recording is None else np.argsort(recording, kind="stable")
    breaks = np.zeros(len(absent), bool)
    breaks[1:] = absent[order][1:] != absent[order][:-1]
    if recording is not None:
        breaks[1:] |= np.diff(recording[order]) != 0
    stretches = np.split(order, np.flatnonzero(breaks))
    return [stretch for stretch in stretches if len(stretch) and not absent[stretch[0]]]
