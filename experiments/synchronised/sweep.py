"""How the learner grows with l when robot and caregiver keep time (section 6.4.1, Fig. 6.7).

    python -m experiments.synchronised.sweep --out out --runs 20

A cell is one file ``<out>/<setting>/seed_<seed>.npz``, there whole or not at all. Running again computes what is
missing.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro
from joblib import Parallel, delayed

from jointattn_mj.recording.files import write_whole
from jointattn_mj.recording.provenance import write_config
from jointattn_mj.session import SessionConfig
from jointattn_mj.synchronised import Gazes, SynchronisedSession, synchronised

ITERATIONS = np.unique(np.concatenate([np.arange(0, 100, 5), np.arange(100, 401, 10)]))
"""l at which the learner is tested."""
GAZES = 400
"""Test gazes, the same all through a run."""


def setting(cues: bool, directions: str = "both") -> SessionConfig:
    """A synchronised session from the simulator's state, up to an hour (it ends when the last l is reached)."""
    config = synchronised(SessionConfig(minutes=60.0, perception="truth"))
    robot = replace(
        config.robot,
        attention=replace(config.robot.attention, motion_cues=cues),
        learner=replace(config.robot.learner, directions=directions),  # type: ignore[arg-type]
    )
    return replace(config, robot=robot)


SETTINGS: dict[str, SessionConfig] = {
    "synchronised/cues": setting(True),
    "synchronised/no_cues": setting(False),
    "synchronised/no_cues_face_to_object_only": setting(False, "face_to_object"),
}
"""By string id. With motion cues the handled object is more interesting, and so more often the one that is chosen."""


@dataclass(frozen=True)
class Options:
    """What to run."""

    out: Path
    """Folder of all cells."""
    only: str = ""
    """Settings whose id begins with this."""
    runs: int = 20
    """Seeds a setting, from 0."""
    jobs: int = 1
    """Processes."""


def learning_curve(
    config: SessionConfig, iterations: np.ndarray = ITERATIONS, gazes: int = GAZES
) -> dict[str, np.ndarray]:
    """Accuracy and error (deg) of the learner at each of ``iterations``; NaN for those that were not reached.

    Also, of the pairs from face to object until then, the share in which the object was the caregiver's.
    """
    session = SynchronisedSession(config)
    session.begin()
    rng = np.random.default_rng(np.random.SeedSequence(config.seed).spawn(5)[4])
    tests = Gazes(config.world, gazes, config.truth.pattern_noise_deg, rng)
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


def run_cell(out: Path, name: str, seed: int) -> None:
    """One run in its own file; nothing to do if it is there."""
    path = out / name / f"seed_{seed}.npz"
    if path.exists():
        return
    config = replace(SETTINGS[name], seed=seed)
    curve = learning_curve(config)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_config(path.parent / "config.yaml", SETTINGS[name])
    write_whole(path, lambda temporary: np.savez_compressed(temporary, **curve))
    print(f"{name} {seed}: {curve['accuracy'][-1]:.2f} right, {curve['error_deg'][-1]:.1f} deg at the end", flush=True)


def main() -> None:
    """Run the cells."""
    options = tyro.cli(Options, description=__doc__)
    names = [name for name in SETTINGS if name.startswith(options.only)]
    Parallel(n_jobs=options.jobs)(
        delayed(run_cell)(options.out, name, seed) for name in names for seed in range(options.runs)
    )


if __name__ == "__main__":
    main()
