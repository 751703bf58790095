"""What somebody should check: seconds in which the face of interest is lost, jumps, is doubtful or not alone; cuts."""

import numpy as np

from jointattn_mj.footage.people import Sighting
from jointattn_mj.footage.shots import Shots
from jointattn_mj.footage.spans import Spans

CHECK = "check"
CAMERA = "camera"
PERSON = "person"
LOST = "face lost"
LOST_FRAMES = 9
"""Frames for which a face must be lost to be on the list."""
LOW_SCORE = 0.75
"""Score of a face below which it is doubtful."""
RIVAL = 0.6
"""Height of another face, as a share of that of interest, from which the two may be mixed up."""
FAR = 1.0
"""Distance, in face heights, that no head moves from one image to the next."""
NEXT = 5
"""Frames within which two sightings follow upon one another."""


def note_checks(
    spans: Spans, frame: int, faces: list[Sighting], chosen: Sighting | None, shots: Shots, cut: bool, last: list[float]
) -> list[float]:
    """Note who is there, and what should be checked.

    Args:
        spans: Takes the notes.
        frame: Number of the frame.
        faces: The faces in it.
        chosen: The face of interest among them.
        shots: Have seen the frame.
        cut: Whether it follows upon a cut.
        last: Frame, centre x, y and height of the face of interest, where it was last; empty before.

    Returns:
        The same, now.
    """
    for face in faces:
        spans.note(PERSON, f"track {face.track}", frame, face.score)
    if cut:
        spans.note(CAMERA, "cut", frame)
        spans.note(CHECK, "cut", frame)
    if shots.camera_moves:
        spans.note(CAMERA, "moves", frame)
    if chosen is None:
        if last:
            spans.note(CHECK, LOST, frame)
        return last
    if chosen.score < LOW_SCORE:
        spans.note(CHECK, "low score", frame, chosen.score)
    if chosen.judged and not chosen.sure:
        spans.note(CHECK, "unsure who it is", frame)
    if any(face.smooth[3] > RIVAL * chosen.smooth[3] for face in faces if face is not chosen):
        spans.note(CHECK, "several faces", frame)
    x, y = (float(value) for value in chosen.face[:2] + chosen.face[2:4] / 2)
    if last and not cut and frame - last[0] <= NEXT and np.hypot(x - last[1], y - last[2]) > FAR * last[3]:
        spans.note(CHECK, "face jumps", frame)
    return [float(frame), x, y, float(chosen.face[3])]
