"""How the learner grows with l when robot and caregiver keep time (section 6.4.1, Fig. 6.7)."""

from dataclasses import replace

import numpy as np

from jointattn_mj.baselines.synchronised import Gazes, SynchronisedSession, synchronised
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.sweeps.claim import Setting

ITERATIONS = np.unique(np.concatenate([np.arange(0, 100, 5), np.arange(100, 401, 10)]))
"""l at which the learner is tested."""
GAZES = 400
"""Test gazes, the same all through a run."""


def session_config(cues: bool, directions: str = "both") -> SessionConfig:
    """A synchronised session from the simulator's state, up to an hour (it ends when the last l is reached)."""
    config = synchronised(SessionConfig(minutes=60.0, perception="state"))
    robot = replace(
        config.robot,
        attention=replace(config.robot.attention, motion_cues=cues),
        learner=replace(config.robot.learner, directions=directions),  # type: ignore[arg-type]
    )
    return replace(config, robot=robot)


SETTINGS = {
    "cues": Setting(session_config(True), 20),
    "no_cues": Setting(session_config(False), 20),
    "no_cues_face_to_object_only": Setting(session_config(False, "face_to_object"), 20),
}
"""By string id. With motion cues the handled object is more interesting, and so more often the one that is chosen."""


def trial(config: SessionConfig, seed: int) -> dict[str, list[float]]:
    """The learning curve of one run."""
    return {name: values.tolist() for name, values in learning_curve(replace(config, seed=seed)).items()}


def learning_curve(
    config: SessionConfig, iterations: np.ndarray = ITERATIONS, gazes: int = GAZES
) -> dict[str, np.ndarray]:
    """Accuracy and error (deg) of the learner at each of ``iterations``; NaN for those that were not reached.

    Also, of the pairs from face to object until then, the share in which the object was the caregiver's.

    Args:
        config: Scene, robot and seed.
        iterations: (m,) l at which the learner is tested.
        gazes: Number of gazes of each test.
    """
    session = SynchronisedSession(config)
    session.begin()
    rng = np.random.default_rng(np.random.SeedSequence(config.seed).spawn(5)[4])
    tests = Gazes(config.world, gazes, config.state.pattern_noise_deg, rng)
    curve = np.full((3, len(iterations)), np.nan)
    pairs = np.full(len(iterations), np.nan)
    due = 0
    try:
        while due < len(iterations) and session.frame < session.total:
            if session.robot.iterations >= iterations[due]:
                learned = [row for row in session.shifts if row.learned]
                to_objects = [row.success_at_landing for row in learned if row.face_to_object]
                curve[:, due] = *tests.test(session.robot), np.mean(to_objects) if to_objects else np.nan
                pairs[due] = len(learned)
                due += 1
                continue
            session.step()
    finally:
        session.close()
    accuracy, error, right = curve
    return {"iterations": iterations, "accuracy": accuracy, "error_deg": error, "right_pairs": right, "pairs": pairs}
