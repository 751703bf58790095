"""One image of the session's video: it explains itself to somebody who has never heard of the project.

Left what the robot perceives and what interests it, right the same moment from outside with both lines of sight, the
map of faces, who decides where to look, and how often it was right.
"""

import numpy as np

from jointattn_mj.gaze_following.film.interest import FRAMES, InterestPanel
from jointattn_mj.gaze_following.film.overlay import RobotsView
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
    WHITE,
    Box,
    Colour,
    cross,
    ink_of,
    shade,
    tick,
    width_of,
    write,
)
from jointattn_mj.video.percepts import SCALE

WIDTH, HEIGHT = 1280, 720
VERDICT_S = 1.2
"""How long the verdict on a shift from the face to an object stays in the image."""
_EYE = Box(16, 76, IMAGE_WIDTH * SCALE, IMAGE_HEIGHT * SCALE)
_OUTSIDE = Box(672, 76, 592, 340)
_INTEREST = Box(16, 564, 640, 148)
_MAP = Box(672, 424, 212, 288)
_GATE = Box(892, 424, 372, 110)
_SUCCESS = Box(892, 542, 372, 170)
DOES = {
    Phase.GREET: ("greets the robot", ""),
    Phase.TURN: ("turns to", ""),
    Phase.REACH: ("reaches for", ""),
    Phase.LIFT: ("lifts", ""),
    Phase.OBSERVE: ("looks closely at", ""),
    Phase.PUT: ("puts", "elsewhere"),
    Phase.GAZE: ("gazes at", ""),
}
"""What the person does, in words, before and after the name of her target."""


class Composer:
    """Puts all parts into one image, uint8 (720, 1280, 3)."""

    def __init__(self, session: SessionRun):
        config, self._names = session.config, session.names
        self._inks: list[Colour] = [*(ink_of(item.rgb) for item in config.world.scene.objects), PERSON]
        self._blank = blank = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
        end = write(blank, 16, 11, "A robot learns to look where somebody else is looking", WHITE, 21, True)
        write(blank, end + 16, 17, "Nobody tells it where: it only watches.", GREY, 14)
        write(blank, _EYE.x, 50, "What the robot sees", WHITE, 16, True)
        write(blank, _EYE.x + _EYE.width, 53, "30 images a second, 320 x 240", GREY, 13, align="right")
        write(blank, _OUTSIDE.x, 50, "The same moment from outside", WHITE, 16, True)
        write(blank, _OUTSIDE.x + _OUTSIDE.width, 53, "truth, not known to the robot", GREY, 13, align="right")
        self._eye = RobotsView(self._names, self._inks, _EYE)
        self._interest = InterestPanel(blank, _INTEREST, self._names, self._inks, config.robot.attention)
        self._parts = (
            self._eye,
            MapPanel(blank, _MAP),
            GatePanel(blank, _GATE, self._names, self._inks),
            SuccessPanel(blank, _SUCCESS, config.minutes, len(config.world.scene.objects)),
        )
        self._onlooker: Onlooker | None = None
        self._total = _clock(config.minutes * 60)
        self._canvas = blank.copy()

    def compose(self, session: SessionRun) -> np.ndarray:
        """The image of this frame; it holds until the next one."""
        canvas = self._canvas
        np.copyto(canvas, self._blank)
        now = f"{_clock(session.frame * FRAME_S)} of {self._total} simulated"
        write(canvas, WIDTH - 16, 14, now, WHITE, 16, align="right")
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
        area[:] = self._onlooker.look()
        before, after = DOES[session.world.caregiver.phase]
        bar = area[:28]
        shade(bar, GROUND, 0.6)
        x = write(bar, 12, 5, "The person", PERSON, 14, True) + 5
        x = write(bar, x, 5, before, WHITE, 14) + 5
        target = session.world.caregiver.target
        if target is not None:
            x = write(bar, x, 5, self._names[target], self._inks[target], 14, True) + 5
        write(bar, x, 5, after, WHITE, 14)
        if self._onlooker.together:
            write(bar, _OUTSIDE.width - 12, 5, "both look at the same thing", GREEN, 14, True, align="right")

    def _draw_verdict(self, canvas: np.ndarray, row: ShiftRow, still: bool) -> None:
        """A line that says how the shift ended, and a frame around both views as long as the robot looks there."""
        ink = GREEN if row.success else RED
        if still:
            for x, y, width, height in (_EYE, _OUTSIDE):
                area = canvas[y - 5 : y + height + 5, x - 5 : x + width + 5]
                edge = 5 if row.success else 2
                area[:edge], area[-edge:], area[:, :edge], area[:, -edge:] = ink, ink, ink, ink
        text = verdict_in_words(row)
        wide = width_of(text, 16, True) + 56
        x, y = _OUTSIDE.x + (_OUTSIDE.width - wide) // 2, _OUTSIDE.y + _OUTSIDE.height - 48
        plate = canvas[y : y + 34, x : x + wide]
        shade(plate, GROUND, 0.85)
        mark = tick if row.success else cross
        mark(canvas, np.array([x + 22.0, y + 17.0]), 17, ink, 4)
        write(canvas, x + 42, y + 7, text, ink, 16, True)
        if row.success and still:
            centre = np.array([_EYE.x + _EYE.width - 44.0, _EYE.y + 44.0])
            tick(canvas, centre, 50, GREEN, 8)


def recent(session: SessionRun) -> ShiftRow | None:
    """The last shift from the face to an object, if it landed just now."""
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
        return f"Joint attention: {row.target_at_launch} was there when the robot set out"
    if row.on_nothing:
        return "The robot found nothing there"
    return f"Missed: the robot looks at {at}, the person at {target or 'the robot'}"


def _clock(seconds: float) -> str:
    return f"{int(seconds // 60):02d}:{int(seconds % 60):02d}"
