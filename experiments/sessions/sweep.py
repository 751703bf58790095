"""Sessions of chapter 6 under the conditions that the text compares, and with one open choice changed at a time
(section 6.4.3)."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.sweeps.claim import Setting


def session_config(
    perception: str, cues: bool, gaze: dict[str, Any] | None = None, learner: dict[str, Any] | None = None
) -> SessionConfig:
    """The default session with some settings changed.

    Args:
        perception: ``pixels`` or ``state``.
        cues: Whether motion cues attract attention.
        gaze: Changed fields of the robot's ``gaze``.
        learner: Changed fields of the robot's ``learner``.
    """
    config = SessionConfig(perception=perception)
    robot = replace(
        config.robot,
        attention=replace(config.robot.attention, motion_cues=cues),
        gaze=replace(config.robot.gaze, **(gaze or {})),
        learner=replace(config.robot.learner, **(learner or {})),
    )
    return replace(config, robot=robot)


SETTINGS = {
    "state/cues": Setting(session_config("state", True), 20),
    "state/no_cues": Setting(session_config("state", False), 20),
    "pixels/cues": Setting(session_config("pixels", True), 20),
    "pixels/no_cues": Setting(session_config("pixels", False), 20),
    "state/cues_feedback_alone": Setting(session_config("state", True, gaze={"gate": "shut"}), 8),
    "state/no_cues_feedback_alone": Setting(session_config("state", False, gaze={"gate": "shut"}), 8),
    "state/cues_linear": Setting(session_config("state", True, learner={"code": "linear", "rate": 0.1}), 8),
    "state/cues_hidden_layer": Setting(session_config("state", True, learner={"code": "network"}), 8),
    "state/no_cues_without_context": Setting(session_config("state", False, learner={"context": 0.0}), 8),
    "state/cues_open_loop": Setting(session_config("state", True, gaze={"feedback_frames": ()}), 8),
    "state/cues_face_to_object_only": Setting(
        session_config("state", True, learner={"directions": "face_to_object"}), 8
    ),
}
"""Under string ids: perception, a slash, and what the robot has or lacks."""
FIRST_SEED = 1000
"""Open choices were made while looking at seeds from 0 on; these seeds are fresh."""
FILM = Path(__file__).with_name("gaze_following.mp4")
"""Half a minute after a session of learning, made smaller:
``jointattn session --minutes 0.5 --seed 7 --start-from assets/trained/robin.npz --video --video-every 2``."""


def trial(config: SessionConfig, seed: int) -> dict[str, Any]:
    """Trial: a session's summary, and for every shift from the face to an object its landing time (s), success, and
    errors in pan and tilt (deg)."""
    session = SessionRun(replace(config, seed=seed))
    try:
        session.begin()
        session.finish()
        return result_of(session)
    finally:
        session.close()


def result_of(session: SessionRun) -> dict[str, Any]:
    """The result kept of a session, without its wall time."""
    rows = [row for row in session.shifts if row.face_to_object]
    columns = ("landing_s", "success", "pan_error_deg", "tilt_error_deg")
    summary = session.summary(0.0).by_old_keys()
    del summary["wall_seconds"]
    return {**summary, "shifts": {name: [getattr(row, name) for row in rows] for name in columns}}
