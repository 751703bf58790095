"""Yaw of a head from the five landmarks of its face.

A head that turns moves the tip of the nose, which stands out, against eyes and corners of the mouth. With the offset s
of the nose from their middle, along the line of the eyes, and their mean width w, yaw is atan(k s / w): the nose stands
out by w / k.
"""

import numpy as np

NOSE = 1.6
"""k. Face meshes of people (MediaPipe, 8 clips) give 1.3 to 1.7; heads of the simulator, with small noses, about 2."""
MOUTH = 1.25
"""Distance of the eyes over that of the corners of the mouth, in a frontal face."""
MOST_DEG = 60.0
"""Yaw beyond which the hidden eye is a guess, so that no yaw is told."""
LEAST_PX = 24.0
"""Height of a face below which landmarks are no more exact than the nose moves."""


def yaw_of(landmarks: np.ndarray, height: float) -> tuple[float, float]:
    """Yaw of a head against the line to the camera, and its expected error.

    Args:
        landmarks: (5, 2) right eye, left eye, nose, right and left corner of the mouth, pixels.
        height: Of the face's box, pixels.

    Returns:
        Yaw, degrees, positive where the head turns to the right of the image, and the error that two of three yaws do
        not exceed; NaN both where the yaw cannot be measured.
    """
    eyes, mouth = landmarks[1] - landmarks[0], landmarks[4] - landmarks[3]
    axis = eyes + mouth
    length = float(np.hypot(*axis))
    if height < LEAST_PX or length < 1e-3:
        return float("nan"), float("nan")
    axis = axis / length
    width = float(eyes @ axis + MOUTH * (mouth @ axis)) / 2
    middle = (landmarks[0] + landmarks[1] + landmarks[3] + landmarks[4]) / 4
    yaw = float(np.degrees(np.arctan2(NOSE * float((landmarks[2] - middle) @ axis), max(width, 1e-3))))
    if abs(yaw) > MOST_DEG:
        return float("nan"), float("nan")
    return yaw, float(np.hypot(3.0 + 100.0 / height, 0.3 * yaw))
