"""The video's panels on learning: the map of faces, who decides, and success so far.

Each panel paints what never changes once, and what changes rarely into an image of its own.
"""

import cv2
import numpy as np

from jointattn_mj.gaze_following.gate import gate_probability
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, SessionRun
from jointattn_mj.gaze_following.shifts import ShiftRow
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
    WHITE,
    Box,
    Colour,
    cross,
    lines,
    tick,
    write,
)

_GLOW = np.array([255, 196, 92], np.float32)  # a cell that is fully active


class MapPanel:
    """The self-organising map with its face patterns, lit where the last face before a shift was recognised."""

    def __init__(self, canvas: np.ndarray, box: Box):
        canvas[box.y : box.y + box.height, box.x : box.x + box.width] = PANEL
        write(canvas, box.x + 12, box.y + 8, "Faces it knows", WHITE, 14, True)
        side = min(box.width - 24, box.height - 80)
        self._box = Box(box.x + (box.width - side) // 2, box.y + 34, side, side)
        for line, text in enumerate(("bright: like the face that", "it last turned away from")):
            write(canvas, self._box.x, self._box.y + side + 8 + 16 * line, text, GREY, 12)
        self._shown: np.ndarray | None = None
        self._cells: np.ndarray | None = None
        self._image = np.zeros((side, side, 3), np.uint8)

    def draw(self, canvas: np.ndarray, session: SessionRun) -> None:
        """Redraws only when the robot turns away from another face."""
        shift, som = session.robot.shift, session.robot.som
        activations = None if shift is None else shift.activations
        if activations is not None and activations.size != len(som.weights):
            activations = None  # a robot whose learner reads something else than the map
        if self._cells is None or (activations is not None and activations is not self._shown):
            if self._cells is None:
                self._cells = face_cells(som, self._box.width)
            self._shown = activations
            self._image = lit(self._cells, activations, (som.config.rows, som.config.columns))
        self._box.of(canvas)[:] = self._image


def face_cells(som: SOM, side: int) -> np.ndarray:
    """(side, side) float32, 0..1: the cells' patterns side by side, or plain cells where they are no images."""
    rows, columns = som.config.rows, som.config.columns
    dimension = som.weights.shape[1]
    pattern = round(dimension**0.5)
    if pattern < 4 or pattern * pattern != dimension:
        return np.full((side, side), 0.8, np.float32)
    low, high = np.percentile(som.weights, (1, 99))
    tones = np.clip((som.images() - low) / max(high - low, 1e-6), 0, 1)
    whole = tones.transpose(0, 2, 1, 3).reshape(rows * pattern, columns * pattern).astype(np.float32)
    return cv2.resize(whole, (side, side), interpolation=cv2.INTER_AREA)


def lit(cells: np.ndarray, activations: np.ndarray | None, shape: tuple[int, int]) -> np.ndarray:
    """The map as RGB, each cell as bright as it is active; a frame around the most active one."""
    side = len(cells)
    active = np.zeros(shape, np.float32)
    if activations is not None:
        active = (activations / activations.max()).reshape(shape).astype(np.float32)
    light = cv2.resize(active, (side, side), interpolation=cv2.INTER_NEAREST)[..., None]
    tint = 255 + (_GLOW - 255) * light
    image = (cells[..., None] * tint * (0.38 + 0.62 * light) + 40 * light * _GLOW / 255).clip(0, 255).astype(np.uint8)
    edges_y, edges_x = (np.round(np.linspace(0, side, n + 1)).astype(int) for n in shape)
    for edge in edges_y[1:-1]:
        image[edge] = GROUND
    for edge in edges_x[1:-1]:
        image[:, edge] = GROUND
    if activations is not None:
        row, column = np.unravel_index(np.argmax(active), shape)
        corner, end = (edges_x[column], edges_y[row]), (edges_x[column + 1], edges_y[row + 1])
        cv2.rectangle(image, corner, end, WHITE, 1)
    return image


class GatePanel:
    """Who decides where to look, eq. 6.8, and how the last shift from the face to an object ended."""

    def __init__(self, canvas: np.ndarray, box: Box, names: tuple[str, ...], inks: list[Colour]):
        canvas[box.y : box.y + box.height, box.x : box.x + box.width] = PANEL
        write(canvas, box.x + 12, box.y + 8, "Who says where to look after the face?", WHITE, 14, True)
        write(canvas, box.x + 12, box.y + 30, "its eyes (visual feedback)", GREY, 12)
        write(canvas, box.x + box.width - 12, box.y + 30, "what it has learned", LEARNED, 12, align="right")
        self._box = box
        self._inks = dict(zip(names, inks, strict=True))
        self._last: ShiftRow | None = None
        self._counted = 0

    def draw(self, canvas: np.ndarray, session: SessionRun) -> None:
        """The bar is full when the learner always decides."""
        x, y, width, _ = self._box
        bar = Box(x + 12, y + 48, width - 24, 12)
        chance = gate_probability(session.config.robot.gaze, session.robot.iterations)
        bar.of(canvas)[:] = FAINT
        filled = round(bar.width * chance)
        bar.of(canvas)[:, bar.width - filled :] = LEARNED
        lessons = session.robot.iterations
        text = f"learning decides {round(100 * chance)} % of the time, after {lessons} lesson{'s' * (lessons != 1)}"
        write(canvas, x + 12, y + 64, text, GREY, 12)
        for row in session.shifts[self._counted :]:
            self._last = row if row.face_to_object else self._last
        self._counted = len(session.shifts)
        if self._last is not None:
            self._draw_last(canvas, self._last)

    def _draw_last(self, canvas: np.ndarray, row: ShiftRow) -> None:
        x, y = self._box.x + 12, self._box.y + 84
        who, ink = ("learned guess", LEARNED) if row.commanded_by == "learner" else ("its eyes", WHITE)
        x = write(canvas, x, y, "last time:", WHITE, 13) + 6
        x = write(canvas, x, y, who, ink, 13, True) + 6
        if row.on_nothing or row.nearest is None:
            x = write(canvas, x, y, "led to nothing", GREY, 13) + 14
        else:
            x = write(canvas, x, y, "led to", WHITE, 13) + 6
            x = write(canvas, x, y, row.nearest, self._inks[row.nearest], 13, True) + 14
        mark, ink = (tick, GREEN) if row.success else (cross, RED)
        mark(canvas, np.array([x, y + 9.0]), 13, ink, 3)


class SuccessPanel:
    """Rate of success over the session so far, eq. 6.9, and every single shift as a small mark."""

    def __init__(self, canvas: np.ndarray, box: Box, minutes: float, objects: int):
        canvas[box.y : box.y + box.height, box.x : box.x + box.width] = PANEL
        write(canvas, box.x + 12, box.y + 8, "Does it look where the person looks?", WHITE, 14, True)
        self._box, self._minutes = box, minutes
        self._plot = Box(box.x + 50, box.y + 54, box.width - 64, box.height - 92)
        plot = self._plot
        for rate, label in ((0.0, "0 %"), (0.5, "50 %"), (1.0, "100 %")):
            y = plot.y + round((1 - rate) * plot.height)
            write(canvas, plot.x - 6, y - 8, label, GREY, 11, align="right")
            canvas[y, plot.x : plot.x + plot.width] = FAINT
        chance = plot.y + round((1 - 1 / objects) * plot.height)
        for x in range(plot.x, plot.x + plot.width - 4, 9):
            canvas[chance, x : x + 4] = GREY
        write(canvas, plot.x + plot.width, chance - 15, "by chance", GREY, 11, align="right")
        write(canvas, plot.x, box.y + box.height - 18, "start", GREY, 11)
        write(canvas, plot.x + plot.width, box.y + box.height - 18, f"{minutes:g} min", GREY, 11, align="right")
        self._blank = box.of(canvas).copy()
        self._image = self._blank
        self._counted = -1

    def draw(self, canvas: np.ndarray, session: SessionRun) -> None:
        """Redraws only when a shift has landed."""
        if len(session.shifts) != self._counted:
            self._counted = len(session.shifts)
            self._image = self._blank.copy()
            counts = session.shifts.column("face_to_object") == 1
            at, success = (session.shifts.column(name)[counts] for name in ("landing_s", "success"))
            self._redraw(self._image, at / 60, success == 1, session.frame / FRAMES_PER_MINUTE)
        self._box.of(canvas)[:] = self._image

    def _redraw(self, image: np.ndarray, at: np.ndarray, success: np.ndarray, now: float) -> None:
        x = write(image, 12, 30, f"{success.sum()} of {len(success)}", GREEN, 13, True) + 6
        write(image, x, 30, "looks from the face to an object", WHITE, 13)
        left, top = self._plot.x - self._box.x, self._plot.y - self._box.y
        scale = self._plot.width / self._minutes
        for minute, right in zip(at, success, strict=True):
            x, y = left + minute * scale, top + self._plot.height + (5 if right else 10)
            lines(image, [np.array([(x, y), (x, y + 5)])], GREEN if right else RED, 1)
        times = np.linspace(0, now, max(2, round(4 * now)))
        rate = rate_of_success(times, at, success)
        known = ~np.isnan(rate)
        if known.any():
            curve = np.column_stack([left + times * scale, top + (1 - rate) * self._plot.height])[known]
            lines(image, [curve], GREEN, 2)
