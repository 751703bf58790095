"""The smaller table of a session, gaze_shifts.parquet: one row a gaze shift."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, overload

import numpy as np
import pyarrow as pa

from jointattn_mj.gaze_following.agent import GazeShift
from jointattn_mj.gaze_following.columns import SHIFT, described
from jointattn_mj.gaze_following.scoring import Judgement, Moment
from jointattn_mj.io.arrow import number_array, word_array
from jointattn_mj.io.parquet import write_parts
from jointattn_mj.io.progress import count
from jointattn_mj.io.rows import RowStore, spans
from jointattn_mj.scene.camera import off_centre
from jointattn_mj.scene.caregiver import PHASES

COMMANDERS = ("visual_feedback", "learner")
GROUP = 1 << 13
"""Shifts in a row group of the file."""


@dataclass(frozen=True, repr=False)
class ShiftRow:
    """One gaze shift. ``columns.SHIFT`` has the meanings of the fields; None where one does not apply."""

    launch_s: float
    landing_s: float
    source: str | None
    chosen: str
    reached: str | None
    commanded_by: str
    phase_at_launch: str | None
    phase_at_landing: str | None
    target_at_launch: str | None
    target_at_landing: str | None
    start_pan_deg: float
    start_tilt_deg: float
    command_pan_deg: float
    command_tilt_deg: float
    landing_pan_deg: float
    landing_tilt_deg: float
    learned: bool
    iterations: int
    face_to_object: bool
    nearest: str | None
    nearest_off_deg: float | None
    on_nothing: bool | None
    success_at_launch: bool | None
    success_at_landing: bool | None
    success: bool | None
    pan_error_deg: float | None
    tilt_error_deg: float | None
    map_error_deg: float | None

    def __repr__(self) -> str:
        """In one line: when, from where to where, who commanded it, and whether it was a success."""
        result = {None: "", True: ", success", False: ", no success"}[self.success]
        way = f"{self.source or 'nothing'} to {self.reached or 'nothing'}, commanded by {self.commanded_by}"
        return f"ShiftRow({self.launch_s:.2f} to {self.landing_s:.2f} s: {way}{result})"


def shift_row(
    shift: GazeShift,
    launch: Moment,
    landing: Moment,
    head: np.ndarray,
    iterations: int,
    names: tuple[str, ...],
    judgement: Judgement | None,
    success: bool | None,
    centre_radius_deg: float,
) -> ShiftRow:
    """The row of a gaze shift that has just landed.

    Args:
        shift: The gaze shift, as the robot knows it.
        launch: Moment at which it began.
        landing: Moment at which it ended.
        head: Direction (2,) of the head at landing, deg.
        iterations: Learning iterations so far.
        names: Of the candidates.
        judgement: Its score; None where it did not leave the face.
        success: Whether it counts as a success; None where it did not leave the face.
        centre_radius_deg: Angle from the centre of view within which an object is gazed at, deg.
    """

    def name(number: int | None) -> str | None:
        return None if number is None else names[number]

    aimed = judgement is not None and launch.target is not None
    target = launch.directions[launch.target] if aimed else np.full(2, np.nan)
    return ShiftRow(
        launch_s=launch.time_s,
        landing_s=landing.time_s,
        source=name(shift.source),
        chosen=names[shift.chosen],
        reached=name(shift.reached),
        commanded_by=COMMANDERS[shift.by_learner],
        phase_at_launch=launch.phase,
        phase_at_landing=landing.phase,
        target_at_launch=name(launch.target),
        target_at_landing=name(landing.target),
        start_pan_deg=float(shift.start[0]),
        start_tilt_deg=float(shift.start[1]),
        command_pan_deg=float(shift.command[0]),
        command_tilt_deg=float(shift.command[1]),
        landing_pan_deg=float(head[0]),
        landing_tilt_deg=float(head[1]),
        learned=shift.learned,
        iterations=iterations,
        face_to_object=judgement is not None,
        nearest=name(judgement.nearest) if judgement else None,
        nearest_off_deg=judgement.distance if judgement else None,
        on_nothing=judgement.distance > centre_radius_deg if judgement else None,
        success_at_launch=judgement.at_launch if judgement else None,
        success_at_landing=judgement.at_landing if judgement else None,
        success=success,
        pan_error_deg=float(head[0] - target[0]) if aimed else None,
        tilt_error_deg=float(head[1] - target[1]) if aimed else None,
        map_error_deg=off_centre(target, shift.suggestion) if aimed and shift.suggestion is not None else None,
    )


class Shifts(Sequence[ShiftRow]):
    """The gaze shifts of a session so far; rows are made on access.

    Values are stored as float64: words as numbers, and NaN for what does not apply.
    """

    def __init__(self, candidates: tuple[str, ...]):
        """Make an empty table; ``candidates``: names of the objects and, last, the face."""
        phases = tuple(map(str, PHASES))
        self._words = {
            "commanded_by": COMMANDERS,
            **dict.fromkeys(("phase_at_launch", "phase_at_landing"), phases),
            **dict.fromkeys(
                ("source", "chosen", "reached", "target_at_launch", "target_at_landing", "nearest"), candidates
            ),
        }
        self.rows = RowStore("gaze_shifts", np.float64, len(_KINDS))

    @property
    def objects(self) -> int:
        """Number of objects that the robot can look at."""
        return len(self._words["chosen"]) - 1

    def __len__(self) -> int:
        """Shifts so far."""
        return len(self.rows)

    @overload
    def __getitem__(self, index: int) -> ShiftRow: ...
    @overload
    def __getitem__(self, index: slice) -> list[ShiftRow]: ...
    def __getitem__(self, index: int | slice) -> ShiftRow | list[ShiftRow]:
        """One shift, or some as a list."""
        if isinstance(index, slice):
            numbers = range(len(self))[index]
            return [self[number] for number in numbers]
        number = range(len(self))[index]
        return self._row(self.rows.read(number, number + 1)[0])

    def __iter__(self) -> Iterator[ShiftRow]:
        """All shifts in order; rows are read in blocks."""
        for first, last in spans(len(self), GROUP):
            yield from map(self._row, self.rows.read(first, last))

    def __eq__(self, other: object) -> bool:
        """Whether both hold equal shifts."""
        return isinstance(other, Shifts) and len(self) == len(other) and all(map(ShiftRow.__eq__, self, other))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """In one line: how many there are."""
        counted, successes = (int(np.sum(self.column(name) == 1)) for name in ("face_to_object", "success"))
        of_all = f"{count(len(self), 'gaze shift')}, {counted} from the face to an object"
        return f"Shifts({of_all}, {successes} success{'es' * (successes != 1)})"

    def append(self, row: ShiftRow) -> None:
        """Add a shift that has just landed.

        Raises:
            OutputError: The file that the shifts are kept in cannot be written.
        """
        self.rows.append([self._number(name, value) for name, value in vars(row).items()])

    def column(self, name: str) -> np.ndarray:
        """Values (shifts,) of a field, float64: 0 and 1 for no and yes, NaN where it does not apply.

        Commanders, phases and candidates are numbers in their order.
        """
        return self.rows.column(_NUMBER[name])

    def table(self, first: int = 0, last: int | None = None) -> pa.Table:
        """The shifts from ``first`` to before ``last``, by default to the end; without shifts, the columns alone."""
        values = self.rows.read(first, last)
        columns = {name: self._array(name, values[:, number]) for name, number in _NUMBER.items()}
        return described(pa.table(columns), SHIFT)

    def _number(self, name: str, value: Any) -> float:
        if value is None:
            return np.nan
        return self._words[name].index(value) if name in self._words else value

    def _row(self, values: np.ndarray) -> ShiftRow:
        return ShiftRow(*map(self._value, _KINDS, values.tolist()))

    def _value(self, name: str, number: float) -> Any:
        if number != number:
            return None
        return self._words[name][int(number)] if name in self._words else _KINDS[name](number)

    def _array(self, name: str, values: np.ndarray) -> pa.Array:
        missing = np.isnan(values)
        known = np.where(missing, 0, values)
        if name in self._words:
            return word_array(np.array(self._words[name])[known.astype(np.int8)], missing)
        return number_array(known.astype(_KINDS[name]), missing)


def write_shifts(path: Path, shifts: Shifts) -> None:
    """Write all shifts as Parquet, whole or not at all.

    Raises:
        OutputError: The file cannot be written.
    """
    write_parts(path, (shifts.table(first, last) for first, last in spans(len(shifts), GROUP)))


def _kind(annotation: Any) -> type:
    """``bool`` of ``bool`` and of ``bool | None``."""
    return annotation if isinstance(annotation, type) else annotation.__args__[0]


_KINDS = {field.name: _kind(field.type) for field in fields(ShiftRow)}
_NUMBER = {name: number for number, name in enumerate(_KINDS)}
