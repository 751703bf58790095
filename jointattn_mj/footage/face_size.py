"""Size of the face in a video, measured before perception begins.

The robot's templates are as large as a face at the caregiver's distance. OpenCV's frontal cascade, with which the
robot's own detection of faces starts, measures the face here; a video with a much larger one is made smaller.
"""

from itertools import islice

import cv2
import numpy as np

from jointattn_mj.footage.frame_map import Fit, FrameMap
from jointattn_mj.footage.reader import RATE, Footage
from jointattn_mj.perception.faces import PATCH_SIDE, FaceDetectorConfig, haar_faces

CASCADE_PX = 35.0
"""Side of the cascade's box around a face that fits a template of 32 pixels; four rendered people had medians of 33 to
37."""
TOLERATED = 1.25
"""A face larger by up to this factor is left as it is: templates have room, and every pixel counts."""
EVERY = 10
"""Search for a face every N frames."""
ENOUGH = 9
"""Number of faces measured; an occasional false one does not move their median."""
LOOK_S = 30.0
"""Seconds of video that are searched."""


def face_side(footage: Footage, fit: Fit, config: FaceDetectorConfig) -> float | None:
    """Height of the cascade's box around the face, pixels of the video; None where no frontal face is found.

    Args:
        footage: The video.
        fit: How it comes into the robot's image.
        config: Settings of the face detector.
    """
    sides = []
    for still in islice(footage, 0, round(LOOK_S * RATE), EVERY):
        height, width = still.image.shape[:2]
        mapped = FrameMap.fitted(width, height, footage.aspect, fit)
        gray = cv2.cvtColor(mapped.image(still.image), cv2.COLOR_RGB2GRAY)
        faces = haar_faces(gray, config)
        if len(faces):
            sides.append(float(faces[0, 2]) / mapped.scale_y)
        if len(sides) == ENOUGH:
            break
    return float(np.median(sides)) if sides else None


def largest_scale(side: float | None, fitted: float, config: FaceDetectorConfig) -> float:
    """Largest scale of a video with which the face fits the templates.

    Args:
        side: Height of the face, pixels of the video; None if unknown.
        fitted: Scale with which the video fits into the robot's image, returned where it does.
        config: Settings of the face detector.
    """
    if side is None:
        return fitted
    wanted = CASCADE_PX * config.side_px / PATCH_SIDE / side
    return wanted if fitted > TOLERATED * wanted else fitted
