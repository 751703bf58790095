"""One frame of fixation: shared by the session robot, the watcher of videos and the real-time run (eq. 6.1 to 6.7)."""

from jointattn_mj.gaze_following.attention import Attention
from jointattn_mj.perception.percept import Percept


def attend(attention: Attention, attended: int | None, percept: Percept, fixating: bool = True) -> int | None:
    """Update the interests for a frame, and ask whether the gaze shifts now.

    Args:
        attention: The attention selector; candidates are numbered as in ``Percept``.
        attended: Candidate that is fixated, or None.
        percept: What is perceived in this frame.
        fixating: False in the frame in which a gaze shift ends: interests do not change then.

    Returns:
        The candidate to which the gaze shifts; None if it stays.
    """
    if fixating:
        attention.advance(attended, percept.moves)
    chosen = attention.consider(percept.visible)
    return None if chosen == attended else chosen
