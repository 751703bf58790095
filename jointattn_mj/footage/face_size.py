"""How large the face is in a video, measured before the robot looks at it.

The robot's templates are as large as a face at a caregiver's distance. OpenCV's frontal cascade, the innate idea of a
face that the robot starts with anyway, says how large one is here; a much larger one is made smaller.
"""

from itertools import islice

import cv2
import numpy as np

from jointattn_mj.footage.frame_map import Fit, FrameMap
from jointattn_mj.footage.reader import RATE, Footage
from jointattn_mj.perception.faces import PATCH_SIDE, FaceDetectorConfig, haar_faces

CASCADE_PX = 35.0
"""Side of the cascade's box around a face for which a template of 32 pixels was chosen: four rendered people had
medians of 33 to 37."""
TOLERATED = 1.25
"""A face larger than that by this factor is left as it is: templates have room, and every pixel counts."""
EVERY = 10
"""Frames from one try to the next."""
ENOUGH = 9
"""Faces that are measured; the cascade's occasional false face does not move their median."""
LOOK_S = 30.0
"""Seconds of video that are searched for them."""


def face_side(footage: Footage, fit: Fit, config: FaceDetectorConfig) -> float | None:
    """Height of the cascade's box around the face, pixels of the video; None where no frontal face is found."""
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
    """Most that a video may be scaled by, so that a face of ``side`` pixels fits the templates; or ``fitted``."""
    if side is None:
        return fitted
    wanted = CASCADE_PX * config.side_px / PATCH_SIDE / side
    return wanted if fitted > TOLERATED * wanted else fitted
