"""The video's panel on attention: everybody's interest measure over the last seconds, and who looked at what.

The two stripes below the curves have the colour of what the robot and the person look at: the same colour one above
the other is joint attention.
"""

from typing import Protocol

import cv2
import numpy as np

from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.video.paint import FAINT, GREY, PANEL, PERSON, ROBOT, WHITE, Box, Colour, lines, width_of, write

SECONDS = 10
FRAMES = round(SECONDS / FRAME_S)
"""What is drawn at a time."""
_SPAN = 50  # the most over the least interest that is drawn
_STRIPE = 13  # height of a stripe, pixels
_MARGIN = 128  # left of the curves: what they are
_LEGENDS = ((13, 16), (11, 8), (10, 5))  # size of text and gap, pixels; the first that fits


def _legend_width(names: tuple[str, ...], size: int, gap: int) -> int:
    return sum(size + 4 + width_of(name, size) + gap for name in names) - gap


class Columns(Protocol):
    """A table with a row a frame, whose last rows are up to now."""

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """Values of a column; per-candidate columns need the candidate's number."""


class InterestPanel:
    """Curves of I_i (eq. 6.1), on a logarithmic scale, and two stripes."""

    def __init__(
        self, canvas: np.ndarray, box: Box, names: tuple[str, ...], inks: list[Colour], attention: AttentionConfig,
        person: bool = True,
    ):  # fmt: skip
        """``person``: whether it is known where she looks, for the second stripe."""
        box.of(canvas)[:] = PANEL
        self._knows_person = person
        self._inks = inks
        gain = 1 + attention.motion_gain if attention.motion_cues else 1.0
        self._most = max(attention.face_preference, attention.object_preference) * gain
        left, width = box.x + _MARGIN, box.width - _MARGIN - 12
        self._plot = Box(left, box.y + 32, width, box.height - 32 - (1 + person) * (_STRIPE + 3) - 12)
        below = self._plot.y + self._plot.height
        self._robot = Box(left, below + 7, width, _STRIPE)
        self._person = Box(left, below + 7 + _STRIPE + 3, width, _STRIPE)
        # Colour of each candidate's stripe, then of a turning head, then of nothing.
        self._stripes = np.array([*inks, FAINT, PANEL], np.uint8)
        self._label(canvas, box, names)

    def _label(self, canvas: np.ndarray, box: Box, names: tuple[str, ...]) -> None:
        x = write(canvas, box.x + 12, box.y + 7, f"What interests it, last {SECONDS} s", WHITE, 14, True) + 22
        end = box.x + box.width - 8
        size, gap = next((fit for fit in _LEGENDS if x + _legend_width(names, *fit) < end), _LEGENDS[-1])
        for name, ink in zip(names, self._inks, strict=True):
            if x + size + 4 + width_of(name, size) < end:
                canvas[box.y + 13 : box.y + 18, x : x + size] = ink
                x = write(canvas, x + size + 4, box.y + 21 - size, name, ink, size) + gap
        x, y = box.x + 12, self._plot.y
        write(canvas, x, y + 2, "moving things", GREY, 12)
        write(canvas, x, y + 17, "gain interest,", GREY, 12)
        write(canvas, x, y + 32, "what it looks at", GREY, 12)
        write(canvas, x, y + 47, "grows boring", GREY, 12)
        write(canvas, x, self._robot.y - 1, "robot looks at", ROBOT, 12)
        if self._knows_person:
            write(canvas, x, self._person.y - 1, "person (truth)", PERSON, 12)
        self._plot.of(canvas)[-1] = FAINT

    def draw(self, canvas: np.ndarray, table: Columns) -> None:
        """The last seconds up to now; now is at the right."""
        frames = FRAMES
        turning = table.column("head_moves")[-frames:] > 0
        shown = len(turning)
        plot = self._plot.of(canvas)
        columns = np.round((frames - shown + np.arange(shown + 1)) * self._plot.width / frames).astype(int)
        edges = np.flatnonzero(np.diff(turning, prepend=False, append=False))
        for start, end in edges.reshape(-1, 2):  # a turning head: nothing changes in its mind
            band = plot[:, columns[start] : columns[end]]
            band[:] = np.minimum(band.astype(np.int16) + 9, 255)
        x = columns[1:].astype(float)
        for number, ink in enumerate(self._inks):
            interest = table.column("interest", number)[-frames:]
            height = 1 + np.log(np.maximum(interest / self._most, 1 / _SPAN)) / np.log(_SPAN)
            y = self._plot.height - 3 - height * (self._plot.height - 6)
            lines(plot, [np.column_stack([x, y])], ink, 2)
        candidates = len(self._inks)
        robot = np.where(turning, candidates, table.column("attended")[-frames:])
        self._draw_stripe(canvas, self._robot, robot, shown)
        if self._knows_person:
            self._draw_stripe(canvas, self._person, table.column("target")[-frames:], shown)

    def _draw_stripe(self, canvas: np.ndarray, box: Box, values: np.ndarray, shown: int) -> None:
        nothing = len(self._stripes) - 1
        numbers = np.full(FRAMES, nothing)
        numbers[FRAMES - shown :] = np.where(np.isnan(values), nothing, values)
        row = self._stripes[numbers][None]
        box.of(canvas)[:] = cv2.resize(row, (box.width, 1), interpolation=cv2.INTER_NEAREST)
