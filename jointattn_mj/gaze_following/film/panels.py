"""The video's panels on learning: the map of faces, who decides where to look, and success so far.

A panel paints once what never changes, and keeps an image of what changes rarely.
"""

import cv2
import numpy as np

from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, SessionRun
from jointattn_mj.gaze_following.summary import rate_of_success
from jointattn_mj.perception.som import SOM
from jointattn_mj.video.paint import (
    FAINT,
    GREEN,
    GREY,
    GROUND,
    LEARNED,
    PANEL,
    RED,
    SMALL,
    TEXT,
    TITLE,
    WHITE,
    Box,
    fitting,
    lines,
    write,
)

_GLOW = np.array([255, 196, 92], np.float32)  # colour of a unit that is fully active
_GAMMA = 0.7  # brightens the middle tones of faces
_TITLES = (TITLE, 18, 16, 14)
"""Sizes of a panel's title; the first that fits."""


def _begin(canvas: np.ndarray, box: Box, title: str) -> None:
    """Paint a panel's ground and its title."""
    box.of(canvas)[:] = PANEL
    write(canvas, box.x + 12, box.y + 7, title, WHITE, fitting(title, box.width - 20, _TITLES, True), True)


class MapPanel:
    """The self-organising map of faces, lit by its activation for the face from which the robot last turned away.

    The most active unit stands below it, larger.
    """

    def __init__(self, canvas: np.ndarray, box: Box):
        """Paint what stays the same on ``canvas``."""
        _begin(canvas, box, "Faces it knows")
        side = box.width - 24
        self._box = Box(box.x + 12, box.y + 36, side, side)
        below = box.y + 36 + side + 6
        large = box.y + box.height - 8 - below
        self._large = Box(box.x + 12, below, large, large)
        for line, text in enumerate(("most like the", "last one it saw")):
            write(canvas, self._large.x + large + 10, below + 1 + 20 * line, text, GREY, SMALL)
        self._shown: np.ndarray | None = None
        self._cells: np.ndarray | None = None
        self._image = np.zeros((side, side, 3), np.uint8)
        self._winner = np.full((large, large, 3), FAINT, np.uint8)

    def draw(self, canvas: np.ndarray, session: SessionRun) -> None:
        """Draw the map; it is made anew only when the robot turns away from another face."""
        shift, som = session.robot.shift, session.robot.som
        activations = None if shift is None else shift.activations
        if activations is not None and activations.size != len(som.weights):
            activations = None  # a learner of another kind, which does not read the map
        if self._cells is None or (activations is not None and activations is not self._shown):
            if self._cells is None:
                self._cells = face_cells(som, self._box.width)
            self._shown = activations
            shape = som.config.rows, som.config.columns
            self._image = lit(self._cells, activations, shape)
            if activations is not None:
                self._winner = _unit(self._cells, int(np.argmax(activations)), shape, self._large.width)
        self._box.of(canvas)[:] = self._image
        self._large.of(canvas)[:] = self._winner


def face_cells(som: SOM, side: int) -> np.ndarray:
    """The patterns of all units side by side, (side, side) float32 from 0 to 1; uniform where they are no images."""
    rows, columns = som.config.rows, som.config.columns
    dimension = som.weights.shape[1]
    pattern = round(dimension**0.5)
    if pattern < 4 or pattern * pattern != dimension:
        return np.full((side, side), 0.8, np.float32)
    low, high = np.percentile(som.weights, (2, 98))
    tones = np.clip((som.images() - low) / max(high - low, 1e-6), 0, 1) ** _GAMMA
    whole = tones.transpose(0, 2, 1, 3).reshape(rows * pattern, columns * pattern).astype(np.float32)
    cells: np.ndarray = cv2.resize(whole, (side, side), interpolation=cv2.INTER_AREA)
    return cells


def _edges(shape: tuple[int, int], side: int) -> tuple[np.ndarray, np.ndarray]:
    """Borders of the units of a map of ``shape`` on an image (side, side): of its rows, and of its columns; pixels."""
    rows, columns = (np.round(np.linspace(0, side, n + 1)).astype(int) for n in shape)
    return rows, columns


def lit(cells: np.ndarray, activations: np.ndarray | None, shape: tuple[int, int]) -> np.ndarray:
    """The map of faces as an image: all units can be seen, active ones glow, a frame is around the most active one.

    Args:
        cells: What ``face_cells`` gives, (side, side).
        activations: Of the units, (k,); None for none.
        shape: Rows and columns of the map.

    Returns:
        (side, side, 3) uint8, RGB.
    """
    side = len(cells)
    active = np.zeros(shape, np.float32)
    if activations is not None:
        active = (activations / activations.max()).reshape(shape).astype(np.float32)
    light = cv2.resize(active, (side, side), interpolation=cv2.INTER_NEAREST)[..., None]
    grey = 200 * cells[..., None] * np.ones(3, np.float32)
    glowing = 70 + 0.9 * cells[..., None] * _GLOW
    image: np.ndarray = (grey + light * (glowing - grey)).clip(0, 255).astype(np.uint8)
    rows, columns = _edges(shape, side)
    image[rows[1:-1]] = GROUND
    image[:, columns[1:-1]] = GROUND
    if activations is not None:
        row, column = divmod(int(np.argmax(active)), shape[1])
        corner, end = (int(columns[column]), int(rows[row])), (int(columns[column + 1]), int(rows[row + 1]))
        cv2.rectangle(image, corner, end, WHITE, 2)
    return image


def _unit(cells: np.ndarray, number: int, shape: tuple[int, int], side: int) -> np.ndarray:
    """One unit of what ``face_cells`` gives, enlarged to (side, side, 3) uint8."""
    rows, columns = _edges(shape, len(cells))
    row, column = divmod(number, shape[1])
    cell = cells[rows[row] : rows[row + 1], columns[column] : columns[column + 1]]
    large = cv2.resize(cell, (side, side), interpolation=cv2.INTER_CUBIC).clip(0, 1)
    return (large[..., None] * _GLOW).astype(np.uint8)


class GatePanel:
    """Who decides where to look after the face: the probability of the learner's command, eq. 6.8."""

    def __init__(self, canvas: np.ndarray, box: Box):
        """Paint what stays the same on ``canvas``."""
        _begin(canvas, box, "Who decides where to look?")
        write(canvas, box.x + 12, box.y + 34, "its eyes", GREY, TEXT)
        write(canvas, box.x + box.width - 12, box.y + 34, "what it has learned", LEARNED, TEXT, align="right")
        self._box = box

    def draw(self, canvas: np.ndarray, session: SessionRun) -> None:
        """Draw the bar; it is full when the learner always decides."""
        x, y, width, _ = self._box
        bar = Box(x + 12, y + 59, width - 24, 14)
        chance = session.robot.gate_probability
        bar.of(canvas)[:] = FAINT
        filled = round(bar.width * chance)
        bar.of(canvas)[:, bar.width - filled :] = LEARNED
        lessons = session.robot.iterations
        text = f"learning: {100 * chance:.0f} % of the time, {lessons} lesson{'s' * (lessons != 1)}"
        write(canvas, x + 12, y + 78, text, GREY, SMALL)


class SuccessPanel:
    """Rate of success over the session so far, eq. 6.9, and a small mark for every shift."""

    def __init__(self, canvas: np.ndarray, box: Box, minutes: float, objects: int):
        """Paint what stays the same.

        Args:
            canvas: Image of the film, in place.
            box: Where on it the panel goes, pixels.
            minutes: Length of the session.
            objects: Number of objects, for the rate of chance.
        """
        _begin(canvas, box, "Does it look where the caregiver looks?")
        self._box, self._minutes = box, minutes
        self._plot = Box(box.x + 62, box.y + 64, box.width - 76, box.height - 102)
        plot = self._plot
        for rate, label in ((0.0, "0 %"), (1.0, "100 %")):
            y = plot.y + round((1 - rate) * plot.height)
            write(canvas, plot.x - 6, y - 10, label, GREY, SMALL, align="right")
            canvas[y, plot.x : plot.x + plot.width] = FAINT
        chance = plot.y + round((1 - 1 / objects) * plot.height)
        for x in range(plot.x, plot.x + plot.width - 4, 9):
            canvas[chance, x : x + 4] = GREY
        write(canvas, plot.x + plot.width, chance - 20, "by chance", GREY, SMALL, align="right")
        write(canvas, plot.x - 6, box.y + box.height - 24, "start", GREY, SMALL, align="right")
        write(canvas, plot.x + plot.width, box.y + box.height - 22, f"{minutes:g} min", GREY, SMALL, align="right")
        self._blank = box.of(canvas).copy()
        self._image = self._blank
        self._counted = -1

    def draw(self, canvas: np.ndarray, session: SessionRun) -> None:
        """Draw the panel; it is made anew only when a shift has landed."""
        if len(session.shifts) != self._counted:
            self._counted = len(session.shifts)
            self._image = self._blank.copy()
            counts = session.shifts.column("face_to_object") == 1
            at, success = (session.shifts.column(name)[counts] for name in ("landing_s", "success"))
            self._redraw(self._image, at / 60, success == 1, session.frame / FRAMES_PER_MINUTE)
        self._box.of(canvas)[:] = self._image

    def _redraw(self, image: np.ndarray, at: np.ndarray, success: np.ndarray, now: float) -> None:
        """Draw rate and marks up to now.

        Args:
            image: The panel, in place.
            at: (k,) when the shifts landed, minutes.
            success: (k,) bool.
            now: Minutes.
        """
        if not len(success):
            write(image, 12, 37, "not yet looked from the face to an object", GREY, SMALL)
            return
        times = "time" if len(success) == 1 else "times"
        x = write(image, 12, 35, f"{success.sum()} of {len(success)} {times}", GREEN, TEXT, True) + 10
        write(image, x, 37, "(line: within a minute)", GREY, SMALL)
        left, top = self._plot.x - self._box.x, self._plot.y - self._box.y
        scale = self._plot.width / self._minutes
        for minute, right in zip(at, success, strict=True):
            x, y = left + minute * scale, top + self._plot.height + 5
            lines(image, [np.array([(x, y), (x, y + 7)])], GREEN if right else RED, 2)
        times_shown = np.linspace(0, now, max(2, round(4 * now)))
        rate = rate_of_success(times_shown, at, success)
        known = ~np.isnan(rate)
        if known.any():
            curve = np.column_stack([left + times_shown * scale, top + (1 - rate) * self._plot.height])[known]
            lines(image, [curve], GREEN, 3)
