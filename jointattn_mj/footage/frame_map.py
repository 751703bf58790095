"""From a video's images to the robot's own, 320x240 pixels, and back.

The whole image goes in, its sides in proportion as they are seen (pixels need not be square), and black bars fill the
rest; or its middle fills all, and what lies beyond is cut off. The robot's eye for faces and its sense of motion were
made for a face about 32 pixels wide (section 6.4.1), so an image with larger faces is made smaller still.
"""

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from jointattn_mj.errors import FootageError

IMAGE_WIDTH, IMAGE_HEIGHT = 320, 240  # section 6.4.1
MOST_PIXELS = 60_000_000
"""Of a video that is made larger or smaller: twice those of 8K."""
Fit = Literal["whole", "fill"]


@dataclass(frozen=True)
class FrameMap:
    """Place (u, v) of the video, pixels, is at x = (u + .5) scale_x - .5 + left, y = (v + .5) scale_y - .5 + top."""

    width: int  # of the video, pixels
    height: int
    scale_x: float
    scale_y: float
    left: int
    top: int

    @classmethod
    def fitted(cls, width: int, height: int, aspect: float = 1.0, fit: Fit = "whole") -> "FrameMap":
        """The map after which a video's image just fits into the robot's, or just fills it.

        Args:
            width: Of the video, pixels.
            height: Of the video, pixels.
            aspect: Width of its pixels over their height.
            fit: Whether all of it is to be seen, or nothing else.
        """
        ratios = IMAGE_WIDTH / (width * aspect), IMAGE_HEIGHT / height
        return cls.scaled(width, height, aspect, min(ratios) if fit == "whole" else max(ratios))

    @classmethod
    def scaled(cls, width: int, height: int, aspect: float, scale: float) -> "FrameMap":
        """The map with ``scale`` pixels of the robot's image for the height of one of the video, to the middle.

        Raises:
            FootageError: The video would become larger than memory is made for.
        """
        wide, high = max(1, round(width * aspect * scale)), max(1, round(height * scale))
        if wide * high > MOST_PIXELS:
            raise FootageError(
                f"a video of {width}x{height} pixels would become one of {wide}x{high}, and {MOST_PIXELS:,} pixels are "
                "the most; choose a smaller --scale, or --fit whole"
            )
        return cls(width, height, wide / width, high / height, (IMAGE_WIDTH - wide) // 2, (IMAGE_HEIGHT - high) // 2)

    def image(self, video: np.ndarray, times: int = 1) -> np.ndarray:
        """The robot's image, (240, 320, 3) RGB of a video's, (height, width, 3) BGR, uint8; ``times`` as large."""
        size = round(self.width * self.scale_x) * times, round(self.height * self.scale_y) * times
        left, top, wide, high = (times * side for side in (self.left, self.top, IMAGE_WIDTH, IMAGE_HEIGHT))
        cut_x, cut_y = max(0, -left), max(0, -top)
        smaller = size[0] < self.width or size[1] < self.height
        whole = cv2.resize(video, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)
        part = whole[cut_y : cut_y + high, cut_x : cut_x + wide]
        canvas = np.zeros((high, wide, 3), np.uint8)
        x, y = max(0, left), max(0, top)
        canvas[y : y + part.shape[0], x : x + part.shape[1]] = part[..., ::-1]
        return canvas

    def to_video(self, px: np.ndarray) -> np.ndarray:
        """Where places (..., 2) of the robot's image are in the video, pixels; NaN stays NaN."""
        scale, offset = np.array([self.scale_x, self.scale_y]), np.array([self.left, self.top])
        return (np.asarray(px, float) + 0.5 - offset) / scale - 0.5

    def to_image(self, px: np.ndarray) -> np.ndarray:
        """Where places (..., 2) of the video are in the robot's image, pixels."""
        scale, offset = np.array([self.scale_x, self.scale_y]), np.array([self.left, self.top])
        return (np.asarray(px, float) + 0.5) * scale - 0.5 + offset
