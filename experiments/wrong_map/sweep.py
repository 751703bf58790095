"""Why do some sessions without motion cues hold on to a wrong map? One component at a time is replaced by truth.

    python -m experiments.wrong_map.sweep --out out/wrong_map --runs 20
    python -m experiments.wrong_map.analysis out/wrong_map --figure experiments/figures/wrong_map.png

Every setting is a session without cues, from the simulator's state, in which one thing is as good as it can be: one
part of perception without errors, the time of the shifts, the pairs that are learned, or who commands. A setting that
mends the map names the link that breaks it.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro
from joblib import Parallel, delayed

from experiments.sessions.sweep import setting
from jointattn_mj.recording.files import write_whole
from jointattn_mj.robots.gaze_follower import GazeFollower, GazeShift
from jointattn_mj.scene.camera import directions_to, off_centre
from jointattn_mj.session import Session, SessionConfig

BASE = setting("truth", cues=False)
TOLERANCE_DEG = 3.5
"""A pair is right when its command leads to within this angle of what the caregiver looks at."""


def with_truth(**noise: float) -> SessionConfig:
    """The base with other errors of perception."""
    return replace(BASE, truth=replace(BASE.truth, **noise))


def only_right_pairs(
    session: Session, pair: Callable, shift: GazeShift, activations: np.ndarray, command: np.ndarray
) -> None:
    """Leave out the pairs that lead elsewhere than to the caregiver's target."""
    if _is_right(session, command):
        pair(shift, activations, command)


def only_still_pairs(
    session: Session, pair: Callable, shift: GazeShift, activations: np.ndarray, command: np.ndarray
) -> None:
    """Leave out the pairs whose face was turning, or whose object was moving, when they were learned."""
    truth = session.config.truth
    moving = session.world.moving(truth.face_moves_above_deg_s, truth.object_moves_above_m_s)
    if not moving.any():
        pair(shift, activations, command)


def wrong_pairs_scattered(
    session: Session, pair: Callable, shift: GazeShift, activations: np.ndarray, command: np.ndarray
) -> None:
    """Send wrong pairs to a fresh random place on the table: as many wrong ones, but none that come again and again."""
    if not _is_right(session, command):
        layout = session.config.world.layout
        spot = np.random.default_rng([session.config.seed, session.frame]).random(2)
        ranges = (layout.x_range, layout.y_range)
        x, y = (low + part * (high - low) for part, (low, high) in zip(spot, ranges, strict=True))
        height = session.world.caregiver.objects[:, 2].min()
        command = directions_to(np.array([[x, y, height]]))[0] - _face(session)
    pair(shift, activations, command)


def _is_right(session: Session, command: np.ndarray) -> bool:
    caregiver = session.world.caregiver
    if caregiver.target is None:
        return False
    target = directions_to(caregiver.objects[caregiver.target : caregiver.target + 1])[0]
    return off_centre(target, command + _face(session)) <= TOLERANCE_DEG


def _face(session: Session) -> np.ndarray:
    return directions_to(session.world.candidate_points()[-1:])[0]


@dataclass(frozen=True)
class Setting:
    """A session's config, and what is done to the pairs before they are learned."""

    config: SessionConfig
    filter: Callable | None = None


SETTINGS: dict[str, Setting] = {
    "as_it_is": Setting(BASE),
    "with_cues": Setting(setting("truth", cues=True)),
    "exact_face_pattern": Setting(with_truth(pattern_noise_deg=0.0)),
    "exact_places": Setting(with_truth(face_noise_px=0.0, face_miss=0.0, object_noise_px=0.0, object_miss=0.0)),
    "feedback_commands": Setting(setting("truth", cues=False, gaze={"gate": "shut"})),
    "only_still_pairs": Setting(BASE, only_still_pairs),
    "wrong_pairs_scattered": Setting(BASE, wrong_pairs_scattered),
    "only_right_pairs": Setting(BASE, only_right_pairs),
}


@dataclass(frozen=True)
class Options:
    """What to run."""

    out: Path
    """Folder of all cells."""
    runs: int = 20
    """Seeds a setting."""
    jobs: int = 1
    """Processes."""


def run_cell(out: Path, name: str, seed: int) -> None:
    """One session; writes its summary and the share of its pairs that were right. Nothing to do if it is there."""
    path = out / f"{name}_{seed}.json"
    if path.exists():
        return
    chosen = SETTINGS[name]
    session = Session(replace(chosen.config, seed=seed))
    right = _watch_pairs(session, session.robot, chosen.filter)
    session.begin()
    while session.frame < session.total:
        session.step()
    result = {**session.summary(0.0), "right_pairs": float(np.mean(right)), "pairs": len(right)}
    session.close()
    out.mkdir(parents=True, exist_ok=True)
    write_whole(path, lambda temporary: temporary.write_text(json.dumps(result)))
    print(f"{name} {seed}: map error {result['map_error_deg']['median']:.1f} deg", flush=True)


def _watch_pairs(session: Session, robot: GazeFollower, pair_filter: Callable | None) -> list[bool]:
    """Note of every pair that is offered whether it is right, and let the filter have its way with it."""
    right: list[bool] = []
    learn = robot._pair

    def pair(shift: GazeShift, activations: np.ndarray, command: np.ndarray) -> None:
        right.append(_is_right(session, command))
        if pair_filter is None:
            learn(shift, activations, command)
        else:
            pair_filter(session, learn, shift, activations, command)

    robot._pair = pair  # type: ignore[method-assign]
    return right


def main() -> None:
    """Run the cells."""
    options = tyro.cli(Options, description=__doc__)
    Parallel(n_jobs=options.jobs)(
        delayed(run_cell)(options.out, name, seed) for name in SETTINGS for seed in range(options.runs)
    )


if __name__ == "__main__":
    main()
