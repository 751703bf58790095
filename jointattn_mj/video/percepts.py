"""A percept drawn on the image that it comes from: candidates, flow, and what is attended.

Coordinates of percepts are pixels of the robot's image, 320x240; the drawing is twice that size. Candidates are
numbered as in ``Percept``, the face last.
"""

import numpy as np

from jointattn_mj.perception.motion import Motion
from jointattn_mj.perception.percept import Percept
from jointattn_mj.video.paint import GROUND, WHITE, Colour, brackets, disc, lines, paler, shade, width_of, write

SCALE = 2
FACE_HALF_PX = 16  # half the side of the face's 32x32 patch
OBJECT_HALF_PX = 13
FLOW_GAIN = 5  # flow of two frames is a pixel or less: arrows are so many times longer
FLOW_FROM_PX = 0.12  # shorter flow is not drawn
FLOW_TO_PX = 6.0  # longest arrow, pixels of the image


class PerceptInk:
    """Draws percepts, each candidate in a colour of its own."""

    def __init__(self, inks: list[Colour]):
        self._inks = inks

    def draw(self, area: np.ndarray, percept: Percept, attended: int | None, motion: Motion | None) -> None:
        """Draw on the image ``area``, uint8 (480, 640, 3)."""
        if motion is not None and len(motion.flow):
            self._draw_flow(area, motion)
        locations = location(percept.px)
        for number in np.flatnonzero(percept.visible).tolist():
            half, moves = self._half(number), percept.moves[number]
            brackets(area, locations[number], half, self._inks[number], 3 if moves else 2)
            if number == attended:
                disc(area, locations[number], half * 1.5, WHITE, 2)
        for number in np.flatnonzero(percept.visible & percept.moves).tolist():
            caption(area, locations[number] + np.array([0, self._half(number) + 4]), "moves", paler(self._inks[number]))

    def _half(self, number: int) -> int:
        """Half the side of a candidate's box in the drawing."""
        return (FACE_HALF_PX if number == len(self._inks) - 1 else OBJECT_HALF_PX) * SCALE

    def _draw_flow(self, area: np.ndarray, motion: Motion) -> None:
        """Arrows of optical flow in the colour of what they belong to."""
        length = np.hypot(*motion.flow.T)
        sparse = np.round(motion.blocks / 4).sum(axis=1) % 2 == 0  # half of the blocks, as on a chequered board
        drawn = sparse & (length > FLOW_FROM_PX)
        start, length, owner = location(motion.blocks[drawn]), length[drawn, None], motion.owner[drawn]
        arrow = motion.flow[drawn] / length * np.minimum(length * FLOW_GAIN, FLOW_TO_PX) * SCALE
        side = 0.28 * np.stack([-arrow[:, 1], arrow[:, 0]], axis=1)
        head = start + 0.6 * arrow
        paths = np.stack([start, start + arrow, head + side, start + arrow, head - side], axis=1)
        for number in np.unique(owner):
            lines(area, list(paths[owner == number]), paler(self._inks[number]))


def location(pixel: np.ndarray) -> np.ndarray:
    """Where pixels (..., 2) of the robot's image are in the drawing."""
    return (np.asarray(pixel, float) + 0.5) * SCALE - 0.5


def caption(area: np.ndarray, top: np.ndarray, text: str, ink: Colour) -> None:
    """Small text on a dark plate, centred below a point."""
    width = width_of(text, 13) + 8
    x, y = round(float(top[0])) - width // 2, round(float(top[1]))
    plate = area[max(y, 0) : max(y + 18, 0), max(x, 0) : max(x + width, 0)]
    if plate.size:
        shade(plate, GROUND, 0.7)
        write(area, x + 4, y + 1, text, ink, 13)
