"""Turn taking with 1 to 10 objects, in view and outside (reference [19]; the baseline that chapter 6 relaxes).

    python -m experiments.turn_taking.sweep --out out --runs 20

A cell, one life of 300,000 attempts, is one file ``<out>/<setting>/seed_<seed>.npz``, there whole or not at all.
Running again computes what is missing. Faces are rendered once, into ``<out>/turn_taking/faces_*.npz``.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import tyro
from joblib import Parallel, delayed

from jointattn_mj.recording.files import write_whole
from jointattn_mj.recording.provenance import write_config
from jointattn_mj.robots.turn_taker import TurnTaker, TurnTakerConfig
from jointattn_mj.turn_taking.attempts import Outcomes, Situations, live
from jointattn_mj.turn_taking.faces import FaceBank, FaceBankConfig, FaceInputs, load_or_render
from jointattn_mj.turn_taking.tables import TableConfig, draw_tables

BINS = 60
"""Stretches of a life over which successes are counted."""
TEST_FACES = FaceBankConfig(faces=1000)


@dataclass(frozen=True)
class Setting:
    """A life."""

    table: TableConfig = field(default_factory=TableConfig)
    """What lies where."""
    robot: TurnTakerConfig = field(default_factory=TurnTakerConfig)
    """The robot."""
    faces: FaceBankConfig = field(default_factory=FaceBankConfig)
    """The faces it sees."""
    attempts: int = 300_000
    """Learning time; the axis of the earlier work."""
    tables: int = 10_000
    """Tables that attempts draw from."""
    tests: int = 3000
    """Attempts at the end of a life with the gate open, nothing learned, on new tables, before and with new faces."""


def reading(objects: int, **robot: object) -> Setting:
    """A robot that differs from the default."""
    return Setting(TableConfig(objects=objects), TurnTakerConfig(**robot))  # type: ignore[arg-type]


SETTINGS: dict[str, Setting] = {
    **{f"turn_taking/objects_{n}": Setting(TableConfig(objects=n)) for n in (1, 3, 5, 10)},
    "turn_taking/in_view_5": Setting(TableConfig(objects=5, region="in_view")),
    "turn_taking/outside_3": Setting(TableConfig(objects=3, region="outside")),
    "turn_taking/readings/feedback_alone_5": reading(5, gate="shut"),
    "turn_taking/readings/executed_5": reading(5, reference="executed"),
    "turn_taking/readings/first_step_5": reading(5, learns_from="first_step"),
    "turn_taking/readings/gate_once_5": reading(5, gate_draws="attempt"),
    "turn_taking/readings/kept_10": reading(10, feedback="kept"),
    "turn_taking/readings/interest_10": reading(10, feedback="interest"),
    "turn_taking/readings/ends_first_10": reading(10, ends="first", steps=12),
    "turn_taking/readings/half_way_10": reading(10, gain=0.5, steps=10),
}
"""By string id. ``objects_n``: anywhere on the table, so some in the first view and some outside; ``readings``: other
readings of the earlier work, one at a time."""


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


def counts(outcomes: Outcomes, bins: int) -> dict[str, np.ndarray]:
    """Outcomes counted in ``bins`` equal stretches of time, each (bins,)."""
    stretch = np.arange(len(outcomes.right)) * bins // len(outcomes.right)

    def count(which: np.ndarray) -> np.ndarray:
        return np.bincount(stretch, which, minlength=bins)

    seen = outcomes.in_view
    return {
        "attempts": count(np.ones(len(stretch))),
        "reached": count(outcomes.reached),
        "right": count(outcomes.right),
        "in_view": count(seen),
        "right_in_view": count(outcomes.right & seen),
        "right_outside": count(outcomes.right & ~seen),
        "movements": count(outcomes.movements),
    }


def live_one(setting: Setting, faces: FaceBank, strange: FaceBank, seed: int) -> dict[str, np.ndarray]:
    """A life and its tests, as counts; ``strange`` are pictures of the same face that the life does not hold."""
    tables, weights, attempts, after = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(4))
    known = faces.inputs(setting.robot.face_length)
    new = strange.inputs(setting.robot.face_length, known.mean, known.scale)
    robot = TurnTaker(setting.robot, known.patterns.shape[1], weights)
    situations = _situations(setting, setting.tables, known, tables)
    results = counts(live(robot, situations, known, setting.attempts, attempts), BINS)
    robot.config = replace(setting.robot, gate="open")
    for name, inputs in (("known", known), ("new", new)):
        situations = _situations(setting, setting.tests, inputs, after)
        test = live(robot, situations, inputs, setting.tests, after, learning=False)
        results |= {f"test_{name}_{key}": value for key, value in counts(test, 1).items()}
    return results


def _situations(setting: Setting, count: int, faces: FaceInputs, rng: np.random.Generator) -> Situations:
    places = draw_tables(setting.table, count, rng)
    return Situations.of_places(places, faces, setting.faces.jitter_deg, rng)


def run_cell(out: Path, name: str, seed: int) -> None:
    """One life in its own file; nothing to do if it is there."""
    path = out / name / f"seed_{seed}.npz"
    if path.exists():
        return
    setting = SETTINGS[name]
    faces, strange = face_banks(out, setting)
    results = live_one(setting, faces, strange, seed)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_config(path.parent / "config.yaml", setting)
    write_whole(path, lambda temporary: np.savez_compressed(temporary, **results))
    print(f"{name} {seed}: {results['right'][-1] / results['attempts'][-1]:.2f} right at the end", flush=True)


def face_banks(out: Path, setting: Setting) -> tuple[FaceBank, FaceBank]:
    """The faces of a life, and others of the same caregiver."""
    seeds = np.random.SeedSequence(0).spawn(2)
    folder = out / "turn_taking"
    return (
        load_or_render(folder / "faces_known.npz", setting.faces, np.random.default_rng(seeds[0])),
        load_or_render(folder / "faces_new.npz", TEST_FACES, np.random.default_rng(seeds[1])),
    )


def main() -> None:
    """Run the cells."""
    options = tyro.cli(Options, description=__doc__)
    names = [name for name in SETTINGS if name.startswith(options.only)]
    if names:
        face_banks(options.out, SETTINGS[names[0]])
    Parallel(n_jobs=options.jobs)(
        delayed(run_cell)(options.out, name, seed) for name in names for seed in range(options.runs)
    )


if __name__ == "__main__":
    main()
