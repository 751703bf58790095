"""What the robot perceives in one picture: the only thing that passes from eye to mind."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Percept:
    """One look at the scene (boxes "face detection", "object detection" and "optical flow" of Fig. 6.2).

    Pixels have x to the right and y down, from the upper left corner of the picture. ``n`` is the number of objects
    that the robot knows. Arrays belong to the perceiver and hold until its next look.
    """

    face_seen: bool
    face_px: np.ndarray  # (2,) centre of the face; NaN when not seen
    face_moves: bool  # |f_i| > epsilon_i for the face, eq. 6.3
    object_seen: np.ndarray  # (n,) bool
    object_px: np.ndarray  # (n, 2) centre of each object's colour area; NaN when not seen
    object_moves: np.ndarray  # (n,) bool, eq. 6.3
