"""The video's panel on attention: the interest of every candidate over the last seconds, and who looked at what.

Two stripes below the curves have the colours of what the robot and what the caregiver looks at. The same colour one
above the other is joint attention.
"""

from typing import Protocol

import cv2
import numpy as np

from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.video.paint import (
    FAINT,
    GREY,
    PANEL,
    PERSON,
    ROBOT,
    SMALL,
    TITLE,
    WHITE,
    Box,
    Colour,
    lines,
    width_of,
    write,
)

SECONDS = 10
FRAMES = round(SECONDS / FRAME_S)
"""Frames that are drawn at a time."""
_SPAN = 50  # the most over the least interest that is drawn
_STRIPE = 15  # height of a stripe, pixels
_BEND_PX, _POINTS = 0.05, 6  # a curve is drawn through where it bends so much, and through one frame in so many
_MARGIN = 182  # left of the curves, for words; pixels
_LEGENDS = ((17, 14), (15, 10), (12, 7), (10, 5))  # size of text and gap, pixels; the first that fits


def _legend_width(names: tuple[str, ...], size: int, gap: int) -> int:
    return sum(size + 4 + width_of(name, size) + gap for name in names) - gap


class Columns(Protocol):
    """A table with a row a frame; its last row is now."""

    def column(self, name: str, candidate: int | None = None) -> np.ndarray:
        """Values (frames,) of a column; a column of candidates needs the candidate's number."""


class InterestPanel:
    """Curves of I_i (eq. 6.1), on a logarithmic scale, and two stripes."""

    def __init__(
        self, canvas: np.ndarray, box: Box, names: tuple[str, ...], inks: list[Colour], attention: AttentionConfig,
        person: bool = True,
    ):  # fmt: skip
        """Draw what stays the same.

        Args:
            canvas: Image of the film, in place.
            box: Where on it the panel goes, pixels.
            names: Of the candidates, the face last.
            inks: Their colours.
            attention: Settings that bound the interest.
            person: Whether the table has the target of the caregiver's gaze, for the second stripe.
        """
        box.of(canvas)[:] = PANEL
        self._knows_person = person
        self._inks = inks
        gain = 1 + attention.motion_gain if attention.motion_cues else 1.0
        self._most = max(attention.face_preference, attention.object_preference) * gain
        left, width = box.x + _MARGIN, box.width - _MARGIN - 12
        self._plot = Box(left, box.y + 36, width, box.height - 36 - (1 + person) * (_STRIPE + 3) - 10)
        below = self._plot.y + self._plot.height
        self._robot = Box(left, below + 7, width, _STRIPE)
        self._person = Box(left, below + 7 + _STRIPE + 3, width, _STRIPE)
        # Colour of each candidate's stripe, then of a turning head, then of nothing.
        self._stripes = np.array([*inks, FAINT, PANEL], np.uint8)
        self._label(canvas, box, names)

    def _label(self, canvas: np.ndarray, box: Box, names: tuple[str, ...]) -> None:
        x = write(canvas, box.x + 12, box.y + 7, "What interests it", WHITE, TITLE, True) + 18
        end = box.x + box.width - 8
        size, gap = next((fit for fit in _LEGENDS if x + _legend_width(names, *fit) < end), _LEGENDS[-1])
        for name, ink in zip(names, self._inks, strict=True):
            if x + size + 4 + width_of(name, size) < end:
                canvas[box.y + 17 : box.y + 22, x : x + size] = ink
                x = write(canvas, x + size + 4, box.y + 26 - size, name, ink, size) + gap
        x, y = box.x + 12, self._plot.y
        write(canvas, x, y + 2, "rises when it moves,", GREY, SMALL)
        write(canvas, x, y + 22, "falls when looked at", GREY, SMALL)
        write(canvas, x, self._robot.y - 2, "robot looks at", ROBOT, SMALL)
        if self._knows_person:
            write(canvas, x, self._person.y - 2, "caregiver looks at", PERSON, SMALL)
        self._plot.of(canvas)[-1] = FAINT

    def draw(self, canvas: np.ndarray, table: Columns) -> None:
        """Draw the last seconds of ``table``; now is at the right."""
        frames = FRAMES
        turning = table.column("head_moves")[-frames:] > 0
        shown = len(turning)
        plot = self._plot.of(canvas)
        columns = np.round((frames - shown + np.arange(shown + 1)) * self._plot.width / frames).astype(int)
        edges = np.flatnonzero(np.diff(turning, prepend=False, append=False))
        for start, end in edges.reshape(-1, 2):  # while the head turns no interest changes
            band = plot[:, columns[start] : columns[end]]
            cv2.convertScaleAbs(band, dst=band, alpha=1, beta=9)
        x = columns[1:].astype(float)
        for number, ink in enumerate(self._inks):
            interest = table.column("interest", number)[-frames:]
            height = 1 + np.log(np.maximum(interest / self._most, 1 / _SPAN)) / np.log(_SPAN)
            y = self._plot.height - 3 - height * (self._plot.height - 6)
            bends = np.abs(np.diff(y, 2, prepend=np.inf, append=np.inf)) > _BEND_PX  # straight parts need no points
            bends[::_POINTS] = True
            lines(plot, [np.column_stack([x, y])[bends]], ink, 2)
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
