"""Meanings of the columns of frames.parquet and gaze_shifts.parquet, written into the files as fields' descriptions.

Directions are degrees in the robot's frame (pan to its left, tilt upwards). Locations are metres in the world's frame.
Pixels are x right and y down.
"""

from collections.abc import Mapping

import pyarrow as pa

FRAME = {
    "time_s": "time in the session",
    "phase": "what the caregiver is doing",
    "target": "object that the caregiver is occupied with and looks at",
    "held": "object in the caregiver's hand",
    "attended": "candidate that the robot fixates; while its head turns, the last one fixated",
    "head_moves": "a gaze shift is under way, from its first command to the frame before landing",
    "rendered": "an image was rendered for this frame",
    "perceived": "the robot perceived this frame during a fixation; if not, the columns of the percept are empty",
    "landed": "a gaze shift ended in this frame",
    "iterations": "learning iterations so far, l of eq. 6.8",
    "pan_deg": "robot's head, pan",
    "tilt_deg": "robot's head, tilt",
    "face_yaw_deg": "caregiver's head, yaw to the caregiver's left",
    "face_pitch_deg": "caregiver's head, pitch, nose down",
    "face_error_px": "distance of the face in the percept from its true pixel",
}
CANDIDATE = {
    "x_m": "object's centre, away from the robot",
    "y_m": "object's centre, to the robot's left",
    "z_m": "object's centre, upwards",
    "saliency": "saliency S_i, eq. 6.5 and 6.6",
    "motion": "degree of motion m_i, eq. 6.3, frames",
    "interest": "interest measure I_i, eq. 6.1",
    "visible": "detected in the image",
    "moves": "detected to move, eq. 6.3",
    "x_px": "pixel at which it was detected",
    "y_px": "pixel at which it was detected",
    "really_moves": "ground truth: moved since the frame before, faster than state.*_moves_above_*",
}
"""Columns of each candidate; their names begin with the object's name or face, as in ``red_x_m``."""
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
    "face_to_object": "the shift left the face; the columns after this one apply to such shifts only",
    "nearest": "ground truth: object nearest to the centre of view after landing",
    "nearest_off_deg": "its angle from the centre of view",
    "on_nothing": "that angle is greater than gaze.centre_radius_deg",
    "success_at_launch": "by locations at launch, the object nearest to the centre of view is the target at launch",
    "success_at_landing": "the object nearest to the centre of view after landing is the target at landing",
    "success": "joint attention, by the target at launch, at landing or at either, as the option success says",
    "pan_error_deg": "landing minus direction of the target at launch (infants follow horizontal displacement first)",
    "tilt_error_deg": "landing minus direction of the target at launch",
    "map_error_deg": "angle between the learner's suggestion at launch and the target then, whoever commanded",
}


def described(table: pa.Table, meanings: Mapping[str, str], candidates: tuple[str, ...] = ()) -> pa.Table:
    """The table with each column's meaning as its field's description.

    Args:
        table: Any table.
        meanings: Of its columns.
        candidates: Whose columns, named as in ``red_x_m``, have the meanings of CANDIDATE.
    """
    meanings = {
        **{f"{candidate}_{name}": meaning for candidate in candidates for name, meaning in CANDIDATE.items()},
        **meanings,
    }
    fields = [field.with_metadata({"description": meanings[field.name]}) for field in table.schema]
    return pa.Table.from_arrays(table.columns, schema=pa.schema(fields))
