"""Map from a video's images to the robot's, 320x240 pixels, and back.

With ``whole`` all of the video's image is in the robot's, with black bars; with ``fill`` its middle fills the robot's.
Pixels of the video need not be square. Perception is made for a face about 32 pixels wide (section 6.4.1), so a video
with larger faces is made smaller still.
"""

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from jointattn_mj.errors import FootageError

IMAGE_WIDTH, IMAGE_HEIGHT = 320, 240  # section 6.4.1
MOST_PIXELS = 60_000_000
"""Most pixels of a scaled video: twice those of 8K."""
Fit = Literal["whole", "fill"]


@dataclass(frozen=True)
class FrameMap:
    """Pixel (u, v) of the video is at x = (u + .5) scale_x - .5 + left, y = (v + .5) scale_y - .5 + top.

    Sizes are pixels; left and top are pixels of the robot's image.
    """

    width: int  # of the video, pixels
    height: int
    scale_x: float
    scale_y: float
    left: int
    top: int

    @classmethod
    def fitted(cls, width: int, height: int, aspect: float = 1.0, fit: Fit = "whole") -> "FrameMap":
        """The map with which a video's image just fits into the robot's, or just fills it.

        Args:
            width: Of the video, pixels.
            height: Of the video, pixels.
            aspect: Width of its pixels over their height.
            fit: Whether all of the video is in the image, or its middle fills it.
        """
        ratios = IMAGE_WIDTH / (width * aspect), IMAGE_HEIGHT / height
        return cls.scaled(width, height, aspect, min(ratios) if fit == "whole" else max(ratios))

    @classmethod
    def scaled(cls, width: int, height: int, aspect: float, scale: float) -> "FrameMap":
        """The map with a given scale, to the middle of the robot's image.

        Args:
            width: Of the video, pixels.
            height: Of the video, pixels.
            aspect: Width of its pixels over their height.
            scale: Pixels of the robot's image for the height of one of the video.

        Raises:
            FootageError: The scaled video would have more than ``MOST_PIXELS``.
        """
        wide, high = max(1, round(width * aspect * scale)), max(1, round(height * scale))
        if wide * high > MOST_PIXELS:
            raise FootageError(
                f"a video of {width}x{height} pixels would become one of {wide}x{high}, and {MOST_PIXELS:,} pixels are "
                "the most; choose a smaller `scale`, or `fit='whole'`"
            )
        return cls(width, height, wide / width, high / height, (IMAGE_WIDTH - wide) // 2, (IMAGE_HEIGHT - high) // 2)

    def image(self, video: np.ndarray, times: int = 1) -> np.ndarray:
        """The robot's image, (240 times, 320 times, 3) uint8 RGB.

        Args:
            video: Image of the video, (height, width, 3) uint8 BGR.
            times: Factor on the size, for drawing.
        """
        size = round(self.width * self.scale_x) * times, round(self.height * self.scale_y) * times
        left, top, wide, high = (times * side for side in (self.left, self.top, IMAGE_WIDTH, IMAGE_HEIGHT))
        cut_x, cut_y = max(0, -left), max(0, -top)
        smaller = size[0] < self.width or size[1] < self.height
        whole = cv2.resize(video, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)
        part = whole[cut_y : cut_y + high, cut_x : cut_x + wide]
        canvas = np.zeros((high, wide, 3), np.uint8)
        x, y = max(0, left), max(0, top)
        cv2.cvtColor(part, cv2.COLOR_BGR2RGB, dst=canvas[y : y + part.shape[0], x : x + part.shape[1]])
        return canvas

    def to_video(self, px: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the video for pixels of the robot's image; NaN stays NaN."""
        scale, offset = np.array([self.scale_x, self.scale_y]), np.array([self.left, self.top])
        video_px: np.ndarray = (np.asarray(px, float) + 0.5 - offset) / scale - 0.5
        return video_px

    def to_image(self, px: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of the robot's image for pixels of the video."""
        scale, offset = np.array([self.scale_x, self.scale_y]), np.array([self.left, self.top])
        image_px: np.ndarray = (np.asarray(px, float) + 0.5) * scale - 0.5 + offset
        return image_px
