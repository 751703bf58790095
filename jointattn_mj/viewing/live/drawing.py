"""The two images of the live view: the robot's, with what it perceives, and the wide image with its frame."""

import cv2
import numpy as np

from jointattn_mj.footage.sessions.session import FootageSessionRun
from jointattn_mj.gaze_following.film.overlay import RobotsView
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.video.paint import PERSON, ROBOT, Box, Colour, ink_of
from jointattn_mj.video.percepts import SCALE

WIDTH, HEIGHT = SCALE * IMAGE_WIDTH, SCALE * IMAGE_HEIGHT
WIDE_WIDTH = 640
"""Width of the wide image on the page, pixels."""
QUALITY = 80
_CORNERS = np.array([[0, 0, 1], [IMAGE_WIDTH - 1, 0, 1], [IMAGE_WIDTH - 1, IMAGE_HEIGHT - 1, 1],
                     [0, IMAGE_HEIGHT - 1, 1]], float).T  # fmt: skip


class LiveDrawing:
    """Draws a session before a person."""

    def __init__(self, session: FootageSessionRun, rgb: np.ndarray):
        """Prepare.

        Args:
            session: What is drawn.
            rgb: (n, 3) colours of the objects, 0..1.
        """
        inks: list[Colour] = [*(ink_of(colour) for colour in rgb), PERSON]
        self._view = RobotsView(session.names, inks, Box(0, 0, WIDTH, HEIGHT))
        self._canvas = np.zeros((HEIGHT, WIDTH, 3), np.uint8)

    def image(self, session: FootageSessionRun) -> np.ndarray:
        """The robot's image with its percept, (480, 640, 3) uint8 RGB; it holds until the next call."""
        self._view.draw(self._canvas, session)
        return self._canvas

    @staticmethod
    def wide_image(session: FootageSessionRun) -> np.ndarray:
        """The wide image, made smaller, with the frame of what the robot sees: uint8 RGB."""
        whole, world = session.wide.wide_frame.image, session.wide
        scale = WIDE_WIDTH / whole.shape[1]
        small = cv2.resize(whole, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        x, y, ahead = world.lens.homography(np.degrees(world.head_angles())) @ _CORNERS
        if (ahead > 0).all():
            corners = np.column_stack([x / ahead, y / ahead]) * scale
            cv2.polylines(small, [np.round(corners).astype(np.int32)], True, ROBOT[::-1], 2, cv2.LINE_AA)
        return np.asarray(small[..., ::-1])


def jpeg(image: np.ndarray) -> bytes:
    """An image (h, w, 3) uint8 RGB as JPEG."""
    return cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
