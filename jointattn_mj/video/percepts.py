"""A percept drawn on the image that it comes from: candidates, optical flow, and the attended candidate.

Coordinates of percepts are pixels of the robot's image, 320x240; the drawing is twice that size. Candidates are
numbered as in ``Percept``, the face last.
"""

import numpy as np

from jointattn_mj.perception.motion import Motion
from jointattn_mj.perception.percept import Percept
from jointattn_mj.video.paint import GROUND, TEXT, WHITE, Colour, brackets, disc, lines, paler, shade, width_of, write

SCALE = 2
FACE_HALF_PX = 16  # half the side of the face's 32x32 patch
OBJECT_HALF_PX = 13
FLOW_GAIN = 5  # arrows are longer than the flow by this factor; that of two frames is a pixel or less
FLOW_FROM_PX = 0.12  # shorter flow is not drawn
FLOW_TO_PX = 6.0  # longest arrow, pixels of the image


class PerceptInk:
    """Draws percepts, each candidate in a colour of its own.

    Attributes:
        face_half_px: Half the side of the face's box, pixels of the robot's image.
    """

    def __init__(self, inks: list[Colour]):
        self._inks = inks
        self.face_half_px: float = FACE_HALF_PX

    def draw(self, area: np.ndarray, percept: Percept, attended: int | None, motion: Motion | None) -> None:
        """Draw a percept on an image.

        Args:
            area: The image, uint8 (at most 480, 640, 3), in place.
            percept: What is drawn.
            attended: Candidate that is fixated, or None.
            motion: Optical flow of the frame, or None where there is none.
        """
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

    def _half(self, number: int) -> float:
        """Half the side of a candidate's box in the drawing."""
        return (self.face_half_px if number == len(self._inks) - 1 else OBJECT_HALF_PX) * SCALE

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
    """Pixels (..., 2) of the drawing for pixels of the robot's image."""
    return (np.asarray(pixel, float) + 0.5) * SCALE - 0.5


def caption(area: np.ndarray, top: np.ndarray, text: str, ink: Colour) -> None:
    """Write on a dark plate, centred below the point ``top`` (x, y) and moved so that all of it is in ``area``.

    Args:
        area: Part of an image (h, w, 3) uint8, drawn on.
        top: (2,) x and y of the middle of the upper edge, pixels.
        text: One line.
        ink: Red, green and blue, 0 to 255.
    """
    height, width = 24, width_of(text, TEXT) + 10
    x = round(min(max(float(top[0]) - width / 2, 0), area.shape[1] - width))
    y = round(min(max(float(top[1]), 0), area.shape[0] - height))
    shade(area[y : y + height, x : x + width], GROUND, 0.75)
    write(area, x + 5, y + 2, text, ink, TEXT)
