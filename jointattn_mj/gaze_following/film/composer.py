"""One image of a session's video, made for a viewer who has never heard of the project.

On the left are the robot's percept and its interest in things. On the right are the same moment from outside with both
lines of sight, the map of faces, who decides where to look, and how often the robot looked where the caregiver looked.
"""

import numpy as np

from jointattn_mj.gaze_following.film.interest import FRAMES, InterestPanel
from jointattn_mj.gaze_following.film.overlay import BAR, STATUS, RobotsView
from jointattn_mj.gaze_following.film.panels import GatePanel, MapPanel, SuccessPanel
from jointattn_mj.gaze_following.session import SessionRun
from jointattn_mj.gaze_following.shifts import ShiftRow
from jointattn_mj.scene.caregiver import FRAME_S, Phase
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.video.onlooker import Onlooker
from jointattn_mj.video.paint import (
    GREEN,
    GREY,
    GROUND,
    PERSON,
    RED,
    TEXT,
    WHITE,
    Box,
    Colour,
    cross,
    fitting,
    ink_of,
    shade,
    tick,
    width_of,
    write,
)
from jointattn_mj.video.percepts import SCALE

WIDTH, HEIGHT = 1280, 720
VERDICT_S = 1.2
"""Seconds for which the verdict on a shift from the face to an object stays in the image."""
_EYE = Box(16, 84, IMAGE_WIDTH * SCALE, IMAGE_HEIGHT * SCALE)
_OUTSIDE = Box(672, 84, 592, 340)
_INTEREST = Box(16, 572, 640, 140)
_MAP = Box(672, 432, 212, 280)
_GATE = Box(892, 432, 372, 104)
_SUCCESS = Box(892, 544, 372, 168)
_VERDICT_SIZES = (22, 20, 18, 16)
DOES = {
    Phase.GREET: ("greets the robot", ""),
    Phase.TURN: ("turns to", ""),
    Phase.REACH: ("reaches for", ""),
    Phase.LIFT: ("lifts", ""),
    Phase.OBSERVE: ("looks closely at", ""),
    Phase.PUT: ("puts", "elsewhere"),
    Phase.GAZE: ("gazes at", ""),
}
"""What the caregiver does, in words, before and after the name of the target."""


class Composer:
    """Puts all parts into one image, uint8 (720, 1280, 3)."""

    def __init__(self, session: SessionRun):
        """Draw what stays the same during ``session``."""
        config, self._names = session.config, session.names
        self._inks: list[Colour] = [*(ink_of(item.rgb) for item in config.world.scene.objects), PERSON]
        self._blank = blank = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
        end = write(blank, 16, 8, "A robot learns to look where somebody else is looking", WHITE, 26, True)
        write(blank, end + 18, 12, "Nobody tells it where.", GREY, 21)
        write(blank, _EYE.x, 50, "What the robot sees", WHITE, 22, True)
        write(blank, _OUTSIDE.x, 50, "From outside", WHITE, 22, True)
        self._eye = RobotsView(self._names, self._inks, _EYE)
        self._interest = InterestPanel(blank, _INTEREST, self._names, self._inks, config.robot.attention)
        self._parts = (
            self._eye,
            MapPanel(blank, _MAP),
            GatePanel(blank, _GATE),
            SuccessPanel(blank, _SUCCESS, config.minutes, len(config.world.scene.objects)),
        )
        self._onlooker: Onlooker | None = None
        self._total = _clock(config.minutes * 60)
        self._canvas = blank.copy()

    def compose(self, session: SessionRun) -> np.ndarray:
        """The image of this frame; it holds until the next one."""
        canvas = self._canvas
        np.copyto(canvas, self._blank)
        write(canvas, WIDTH - 16, 12, f"{_clock(session.frame * FRAME_S)} of {self._total}", WHITE, 21, align="right")
        for part in self._parts:
            part.draw(canvas, session)
        self._interest.draw(canvas, session.frames.recent(FRAMES))
        self._draw_outside(canvas, session)
        verdict = recent(session)
        if verdict is not None:
            self._draw_verdict(canvas, verdict, session.robot.shift is None)
        return canvas

    def close(self) -> None:
        """Free the onlooker's rendering context."""
        if self._onlooker is not None:
            self._onlooker.close()
            self._onlooker = None

    def _draw_outside(self, canvas: np.ndarray, session: SessionRun) -> None:
        if self._onlooker is None:
            self._onlooker = Onlooker(session.world, _OUTSIDE.width, _OUTSIDE.height)
        area = _OUTSIDE.of(canvas)
        area[:] = self._onlooker.render()
        before, after = DOES[session.world.caregiver.phase]
        bar = area[-BAR:]
        shade(bar, GROUND, 0.88)
        x = write(bar, 12, 7, "The caregiver", PERSON, STATUS, True) + 7
        x = write(bar, x, 7, before, WHITE, STATUS) + 7
        target = session.world.caregiver.target
        if target is not None:
            x = write(bar, x, 7, self._names[target], self._inks[target], STATUS, True) + 7
        write(bar, x, 7, after, WHITE, STATUS)
        right = _OUTSIDE.x + _OUTSIDE.width
        if self._onlooker.together:
            write(canvas, right, 52, "both look at the same thing", GREEN, STATUS, True, align="right")
        else:
            write(canvas, right, 54, "the robot does not know this view", GREY, TEXT, align="right")

    def _draw_verdict(self, canvas: np.ndarray, row: ShiftRow, still: bool) -> None:
        """Write how a shift ended; while the robot looks there (``still``), draw a frame around both views."""
        ink = GREEN if row.success else RED
        if still:
            for x, y, width, height in (_EYE, _OUTSIDE):
                area = canvas[y - 5 : y + height + 5, x - 5 : x + width + 5]
                edge = 5 if row.success else 2
                area[:edge], area[-edge:], area[:, :edge], area[:, -edge:] = ink, ink, ink, ink
        text = verdict_in_words(row)
        size = fitting(text, _OUTSIDE.width - 84, _VERDICT_SIZES, True)
        wide = width_of(text, size, True) + 68
        x, y = _OUTSIDE.x + (_OUTSIDE.width - wide) // 2, _OUTSIDE.y + _OUTSIDE.height - BAR - 52
        shade(canvas[y : y + 44, x : x + wide], GROUND, 0.88)
        mark = tick if row.success else cross
        mark(canvas, np.array([x + 28.0, y + 22.0]), 24, ink, 5)
        write(canvas, x + 52, y + 21 - 0.6 * size, text, ink, size, True)
        if row.success and still:
            centre = np.array([_EYE.x + _EYE.width - 44.0, _EYE.y + 44.0])
            tick(canvas, centre, 50, GREEN, 8)


def recent(session: SessionRun) -> ShiftRow | None:
    """The last shift from the face to an object, if it landed within ``VERDICT_S``; else None."""
    row = session.shifts[-1] if session.shifts else None
    if row is None or not row.face_to_object:
        return None
    return row if session.frame * FRAME_S - row.landing_s < VERDICT_S else None


def verdict_in_words(row: ShiftRow) -> str:
    """How a shift from the face to an object ended."""
    at, target = row.nearest, row.target_at_landing
    if row.success:
        if row.success_at_landing:
            return f"Joint attention at {at}"
        return f"Joint attention: {row.target_at_launch} was just there"
    if row.on_nothing:
        return "Missed: nothing is there"
    return f"Missed: robot at {at}, person at {target or 'the robot'}"


def _clock(seconds: float) -> str:
    return f"{int(seconds // 60):02d}:{int(seconds % 60):02d}"
