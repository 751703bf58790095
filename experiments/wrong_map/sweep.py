"""Why do some sessions without motion cues hold on to a wrong map? One component at a time is made exact.

Every setting is a session without cues, from the simulator's state, in which one thing is as good as it can be: one
part of perception without errors, the time of the shifts, the pairs that are learned, or who commands. A setting that
mends the map names the link that breaks it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from jointattn_mj.gaze_following.agent import GazeFollower, GazeShift
from jointattn_mj.gaze_following.learners import Locations
from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.options import Checked
from jointattn_mj.scene.camera import directions_to, off_centre
from jointattn_mj.sweeps.claim import Setting

from ..sessions.sweep import session_config

BASE = session_config("state", cues=False)
TOLERANCE_DEG = 3.5
"""A pair is right when its command leads to within this angle of what the caregiver looks at."""


def exact(**noise: float) -> SessionConfig:
    """The base with other errors of perception."""
    return replace(BASE, state=replace(BASE.state, **noise))


def only_right_pairs(
    session: SessionRun, pair: Callable, shift: GazeShift, face: np.ndarray, locations: Locations
) -> None:
    """Leave out the pairs that lead elsewhere than to the caregiver's target.

    Args:
        session: The session.
        pair: What gives a pair to the learner.
        shift: The gaze shift that has ended.
        face: (d,) description of the face at launch.
        locations: Where it ended, and where objects were in view.
    """
    if _is_right(session, locations):
        pair(shift, face, locations)


def only_still_pairs(
    session: SessionRun, pair: Callable, shift: GazeShift, face: np.ndarray, locations: Locations
) -> None:
    """Leave out the pairs whose face was turning, or whose object was moving, when they were learned.

    Arguments are those of :func:`only_right_pairs`.
    """
    state = session.config.state
    moving = session.world.moving(state.face_moves_above_deg_s, state.object_moves_above_m_s)
    if not moving.any():
        pair(shift, face, locations)


def wrong_pairs_scattered(
    session: SessionRun, pair: Callable, shift: GazeShift, face: np.ndarray, locations: Locations
) -> None:
    """Send each wrong pair to a random position on the table: as many wrong pairs, but none that repeats.

    Arguments are those of :func:`only_right_pairs`.
    """
    if not _is_right(session, locations):
        layout = session.config.world.layout
        spot = np.random.default_rng([session.config.seed, session.frame]).random(2)
        ranges = (layout.x_range, layout.y_range)
        x, y = (low + part * (high - low) for part, (low, high) in zip(spot, ranges, strict=True))
        height = session.world.caregiver.objects[:, 2].min()
        locations = Locations.only(directions_to(np.array([[x, y, height]]))[0] - _face(session))
    pair(shift, face, locations)


def _is_right(session: SessionRun, locations: Locations) -> bool:
    caregiver = session.world.caregiver
    if caregiver.target is None or locations.reached is None:
        return False
    target = directions_to(caregiver.objects[caregiver.target : caregiver.target + 1])[0]
    return off_centre(target, locations.reached + _face(session)) <= TOLERANCE_DEG


def _face(session: SessionRun) -> np.ndarray:
    return directions_to(session.world.candidate_points()[-1:])[0]


@dataclass(frozen=True)
class PairCondition(Checked):
    """A session's config, and what is done to the pairs before they are learned."""

    config: SessionConfig
    pairs: Literal["all", "only_right", "only_still", "wrong_scattered"] = "all"


FILTERS: dict[str, Callable[..., None]] = {
    "only_right": only_right_pairs,
    "only_still": only_still_pairs,
    "wrong_scattered": wrong_pairs_scattered,
}
SETTINGS = {
    "as_it_is": Setting(PairCondition(BASE), 10),
    "with_cues": Setting(PairCondition(session_config("state", cues=True)), 10),
    "exact_face_pattern": Setting(PairCondition(exact(pattern_noise_deg=0.0)), 10),
    "exact_locations": Setting(
        PairCondition(exact(face_noise_px=0.0, face_miss=0.0, object_noise_px=0.0, object_miss=0.0)), 10
    ),
    "feedback_commands": Setting(PairCondition(session_config("state", cues=False, gaze={"gate": "shut"})), 10),
    "only_still_pairs": Setting(PairCondition(BASE, "only_still"), 10),
    "wrong_pairs_scattered": Setting(PairCondition(BASE, "wrong_scattered"), 10),
    "only_right_pairs": Setting(PairCondition(BASE, "only_right"), 10),
}


def trial(condition: PairCondition, seed: int) -> dict[str, Any]:
    """A session's summary, and the share of its pairs that were right."""
    session = SessionRun(replace(condition.config, seed=seed))
    right = _watch_pairs(session, session.robot, FILTERS.get(condition.pairs))
    try:
        session.begin()
        session.finish()
        summary = session.summary(0.0).by_old_keys()
    finally:
        session.close()
    kept = {name: summary[name] for name in ("gaze_shifts", "successes", "late_rate", "map_error_deg")}
    return {**kept, "right_pairs": float(np.mean(right)), "pairs": len(right)}


def _watch_pairs(session: SessionRun, robot: GazeFollower, pair_filter: Callable | None) -> list[bool]:
    """Note of every pair that is offered whether it is right, and let the filter have its way with it."""
    right: list[bool] = []
    learn = robot._pair

    def pair(shift: GazeShift, face: np.ndarray, locations: Locations) -> None:
        right.append(_is_right(session, locations))
        if pair_filter is None:
            learn(shift, face, locations)
        else:
            pair_filter(session, learn, shift, face, locations)

    robot._pair = pair  # type: ignore[method-assign]
    return right
