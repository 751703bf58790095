"""Faces made unrecognisable, for whoever has not agreed to be shown."""

import cv2
import numpy as np

WIDER, UP, DOWN = 0.35, 0.6, 0.35
"""What is hidden beyond a face's box, in its width and height: hair, ears and chin too."""
BLOCKS = 6
"""A head becomes so many blocks wide."""


def blurred(image: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """An image whose faces are unrecognisable.

    Args:
        image: (h, w, 3) uint8.
        boxes: (k, 4) x, y, width and height of the faces, pixels.

    Returns:
        A copy, or the image itself where there is no face.
    """
    if not len(boxes):
        return image
    image = image.copy()
    for x, y, wide, high in boxes:
        x0, x1 = max(0, round(x - WIDER * wide)), min(image.shape[1], round(x + (1 + WIDER) * wide))
        y0, y1 = max(0, round(y - UP * high)), min(image.shape[0], round(y + (1 + DOWN) * high))
        if x1 - x0 < 1 or y1 - y0 < 1:
            continue
        part = image[y0:y1, x0:x1]
        size = BLOCKS, max(1, round(BLOCKS * (y1 - y0) / (x1 - x0)))
        coarse = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
        part[:] = cv2.resize(coarse, (x1 - x0, y1 - y0), interpolation=cv2.INTER_LINEAR)
    return image
