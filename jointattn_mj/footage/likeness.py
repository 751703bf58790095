"""How alike two faces of one video are: shape of the face, colours of the head, colours of the clothes below it.

It tells the few people of one video apart, in the light and the clothes of that video. It recognises nobody elsewhere.
"""

from typing import NamedTuple

import cv2
import numpy as np

from jointattn_mj.footage.yunet import BOX, LANDMARKS

SIDE = 48
"""Side of the upright face whose edges are compared, pixels."""
UPRIGHT = np.array([[16, 18], [32, 18], [24, 28], [17, 36], [31, 36]], np.float32)
"""Where its landmarks come to lie."""
LEVELS = (6, 8, 8)
"""Steps of lightness and of the two axes of colour (CIE Lab)."""
LEAST_SHOWN = 0.3
"""Least share of the region of clothes that must lie in the image."""
WEIGHTS = (0.4, 0.2, 0.4)
"""Of shape, head and clothes."""
SHAPE_SPAN = (0.7, 0.95)
"""Cosine of two shapes that counts 0, and that counts 1: .77 to .90 between people, .92 to .97 for one."""
SAME, OTHER = 0.86, 0.76
"""Likeness from which two faces are one person, and up to which they are two; it is unknown in between. Over a cut,
people who came back had .93 to .97, and two men in black in one room .73; people who are rendered in one set of clothes
are .8 alike."""


class Appearance(NamedTuple):
    """What a face looks like, each part with unit length."""

    shape: np.ndarray
    """(900,) edges of the upright face (histograms of oriented gradients)."""
    head: np.ndarray
    """(384,) square roots of the shares of colours in and around the face."""
    clothes: np.ndarray
    """(384,) the same of the region below; zeros where it is not in the image."""


def _edges() -> cv2.HOGDescriptor:
    return cv2.HOGDescriptor((SIDE, SIDE), (16, 16), (8, 8), (8, 8), 9)


def appearance(image: np.ndarray, face: np.ndarray) -> Appearance:
    """What a face looks like.

    Args:
        image: (h, w, 3) uint8 BGR.
        face: (15,) as of ``yunet``, pixels.
    """
    x, y, wide, high = (float(value) for value in face[BOX])
    landmarks = face[LANDMARKS].reshape(5, 2).astype(np.float32)
    upright = cv2.estimateAffinePartial2D(landmarks, UPRIGHT, method=cv2.LMEDS)[0]
    if upright is None:
        scale = SIDE / max(wide, high)
        upright = np.array([[scale, 0, -x * scale], [0, scale, -y * scale]])
    patch = cv2.cvtColor(cv2.warpAffine(image, upright, (SIDE, SIDE)), cv2.COLOR_BGR2GRAY)
    shape = np.asarray(_edges().compute(cv2.equalizeHist(patch)), np.float32).ravel()
    head = _colours(image, x, y - 0.3 * high, wide, 1.3 * high)
    clothes = _colours(image, x - 0.6 * wide, y + 1.35 * high, 2.2 * wide, 1.3 * high)
    return Appearance(shape / max(float(np.linalg.norm(shape)), 1e-6), head, clothes)


def likeness(first: Appearance, second: Appearance) -> float:
    """How alike two faces are, 0 to 1."""
    low, high = SHAPE_SPAN
    shape = min(max((float(first.shape @ second.shape) - low) / (high - low), 0.0), 1.0)
    head, clothes = float(first.head @ second.head), float(first.clothes @ second.clothes)
    weights = np.array(WEIGHTS) if first.clothes.any() and second.clothes.any() else np.array([*WEIGHTS[:2], 0.0])
    return float(weights @ (shape, head, clothes) / weights.sum())


def _colours(image: np.ndarray, x: float, y: float, wide: float, high: float) -> np.ndarray:
    """Square roots of the shares of colours in a region; zeros where too little of it is in the image."""
    x0, y0 = max(0, round(x)), max(0, round(y))
    x1, y1 = min(image.shape[1], round(x + wide)), min(image.shape[0], round(y + high))
    if x1 - x0 < 2 or y1 - y0 < 2 or (x1 - x0) * (y1 - y0) < LEAST_SHOWN * wide * high:
        return np.zeros(int(np.prod(LEVELS)), np.float32)
    step = max(1, (x1 - x0) // 48)
    lab = cv2.cvtColor(np.ascontiguousarray(image[y0:y1:step, x0:x1:step]), cv2.COLOR_BGR2LAB)
    counts = cv2.calcHist([lab], [0, 1, 2], None, list(LEVELS), [0, 256, 96, 160, 96, 160]).ravel()
    return np.asarray(np.sqrt(counts / max(float(counts.sum()), 1.0)), np.float32)
