"""What every column of the two tables means; it goes into the Parquet files themselves, as each field's description.

Directions are degrees in the robot's frame (pan to its left, tilt upwards), places metres in the world's frame, pixels
x right and y down.
"""

from collections.abc import Mapping

import pyarrow as pa

FRAME = {
    "time_s": "time in the session",
    "phase": "what the caregiver is doing",
    "target": "object that the caregiver is occupied with and looks at",
    "held": "object in her hand",
    "attended": "candidate that the robot fixates, or fixated last while its head turns",
    "head_moves": "a gaze shift is under way, from its first command to the frame before landing",
    "rendered": "an image was rendered for this frame",
    "looked": "the robot perceived this frame while fixating; the percept's columns are empty where not",
    "landed": "a gaze shift ended in this frame",
    "iterations": "l of eq. 6.8",
    "pan_deg": "robot's head, pan",
    "tilt_deg": "robot's head, tilt",
    "face_yaw_deg": "caregiver's head, yaw to her left",
    "face_pitch_deg": "caregiver's head, pitch, nose down",
    "face_error_px": "distance of the face as seen from where it really was",
}
CANDIDATE = {
    "x_m": "object's centre, away from the robot",
    "y_m": "object's centre, to the robot's left",
    "z_m": "object's centre, upwards",
    "saliency": "S_i, eq. 6.5 and 6.6",
    "motion": "m_i, eq. 6.3, frames",
    "interest": "I_i, eq. 6.1",
    "seen": "found in the image",
    "moves": "seen to move, eq. 6.3",
    "x_px": "where it was seen",
    "y_px": "where it was seen",
    "really_moves": "really moved since the frame before, faster than state.*_moves_above_*",
}
"""Of the columns whose names begin with a candidate's: an object's name, or face."""
SHIFT = {
    "launch_s": "time at which the shift was decided",
    "landing_s": "time at which the head was still again",
    "source": "candidate attended before",
    "chosen": "candidate drawn by eq. 6.7",
    "reached": "candidate within gaze.centre_radius_deg of the centre of view after landing, as the robot saw it",
    "commanded_by": "visual_feedback or learner (eq. 6.8)",
    "phase_at_launch": "what the caregiver was doing",
    "phase_at_landing": "what the caregiver was doing",
    "target_at_launch": "object that the caregiver was occupied with",
    "target_at_landing": "object that the caregiver was occupied with",
    "start_pan_deg": "robot's head at launch",
    "start_tilt_deg": "robot's head at launch",
    "command_pan_deg": "direction commanded, as last corrected",
    "command_tilt_deg": "direction commanded, as last corrected",
    "landing_pan_deg": "robot's head at landing",
    "landing_tilt_deg": "robot's head at landing",
    "learned": "the shift gave the learner a pair",
    "iterations": "l of eq. 6.8 after landing",
    "face_to_object": "the shift left the face; all columns below apply to such shifts only",
    "nearest": "object nearest to the centre of view after landing, in truth",
    "nearest_off_deg": "how far from the centre it was",
    "on_nothing": "it was farther off than gaze.centre_radius_deg",
    "success_at_launch": "by the places at launch, the object nearest to the landing was the target at launch",
    "success_at_landing": "the nearest object at landing was the target at landing",
    "success": "joint attention, by the moment that the option success names",
    "pan_error_deg": "landing minus direction of the target at launch (infants follow horizontal displacement first)",
    "tilt_error_deg": "landing minus direction of the target at launch",
    "map_error_deg": "angle between the learner's suggestion at launch and the target then, whoever commanded",
}


def described(table: pa.Table, meanings: Mapping[str, str], candidates: tuple[str, ...] = ()) -> pa.Table:
    """``table`` with each column's meaning in its field's metadata; ``candidates`` begin names as ``red_x_m`` does."""
    meanings = {
        **{f"{candidate}_{name}": meaning for candidate in candidates for name, meaning in CANDIDATE.items()},
        **meanings,
    }
    fields = [field.with_metadata({"description": meanings[field.name]}) for field in table.schema]
    return table.cast(pa.schema(fields))
