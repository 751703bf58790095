"""Turn taking with 1 to 10 objects, in view and outside (reference [19]; the baseline that chapter 6 relaxes)."""

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Annotated

import numpy as np

from jointattn_mj.baselines.turn_taking.agent import TurnTaker, TurnTakerConfig
from jointattn_mj.baselines.turn_taking.attempts import AttemptSituations, Outcomes, run_attempts
from jointattn_mj.baselines.turn_taking.faces import FaceBank, FaceBankConfig, FaceInputs, render_faces
from jointattn_mj.baselines.turn_taking.layouts import ObjectTableConfig, draw_tables
from jointattn_mj.options import Checked, Whole
from jointattn_mj.sweeps.claim import Setting

BINS = 60
"""Stretches of a run over which successes are counted."""
TEST_FACES = FaceBankConfig(faces=1000)


@dataclass(frozen=True)
class AttemptsConfig(Checked):
    """Settings of a run of turn taking."""

    table: ObjectTableConfig = field(default_factory=ObjectTableConfig)
    """Objects and where they lie."""
    robot: TurnTakerConfig = field(default_factory=TurnTakerConfig)
    """The robot."""
    faces: FaceBankConfig = field(default_factory=FaceBankConfig)
    """The faces it sees."""
    attempts: Annotated[int, Whole("[1, 1e10]")] = 300_000
    """Learning time; the axis of the earlier work."""
    tables: Annotated[int, Whole("[1, 1e8]")] = 10_000
    """Tables that attempts draw from."""
    tests: Annotated[int, Whole("[1, 1e8]")] = 3000
    """Test attempts at the end, with the gate open and without learning, on new tables; then with new faces."""


def reading(objects: int, **robot: object) -> Setting:
    """A robot that differs from the default."""
    return Setting(AttemptsConfig(ObjectTableConfig(objects=objects), TurnTakerConfig(**robot)), 8)  # type: ignore[arg-type]


SETTINGS = {
    **{f"objects_{n}": Setting(AttemptsConfig(ObjectTableConfig(objects=n)), 20) for n in (1, 3, 5, 10)},
    "in_view_5": Setting(AttemptsConfig(ObjectTableConfig(objects=5, region="in_view")), 20),
    "outside_3": Setting(AttemptsConfig(ObjectTableConfig(objects=3, region="outside")), 20),
    "readings/feedback_alone_5": reading(5, gate="shut"),
    "readings/executed_5": reading(5, reference="executed"),
    "readings/first_step_5": reading(5, learns_from="first_step"),
    "readings/gate_once_5": reading(5, gate_draws="attempt"),
    "readings/kept_10": reading(10, feedback="kept"),
    "readings/interest_10": reading(10, feedback="interest"),
    "readings/ends_first_10": reading(10, ends="first", steps=12),
    "readings/half_way_10": reading(10, gain=0.5, steps=10),
}
"""By string id. ``objects_n``: anywhere on the table, so some in the first view and some outside; ``readings``: other
readings of the earlier work, one at a time."""


def counts(outcomes: Outcomes, bins: int) -> dict[str, np.ndarray]:
    """Outcomes counted in ``bins`` equal stretches of time, each (bins,)."""
    stretch = np.arange(len(outcomes.right)) * bins // len(outcomes.right)

    def count(which: np.ndarray) -> np.ndarray:
        return np.bincount(stretch, which, minlength=bins)

    visible = outcomes.in_view
    return {
        "attempts": count(np.ones(len(stretch))),
        "reached": count(outcomes.reached),
        "right": count(outcomes.right),
        "in_view": count(visible),
        "right_in_view": count(outcomes.right & visible),
        "right_outside": count(outcomes.right & ~visible),
        "movements": count(outcomes.movements),
    }


def live_one(run: AttemptsConfig, faces: FaceBank, strange: FaceBank, seed: int) -> dict[str, np.ndarray]:
    """A run and its tests, as counts.

    Args:
        run: Settings.
        faces: Faces of the run.
        strange: Other images of the same face, for the tests.
        seed: Seed of the run.
    """
    tables, weights, attempts, after = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(4))
    known = faces.inputs(run.robot.face_length)
    new = strange.inputs(run.robot.face_length, known.mean, known.scale)
    robot = TurnTaker(run.robot, known.patterns.shape[1], weights)
    situations = _situations(run, run.tables, known, tables)
    results = counts(run_attempts(robot, situations, known, run.attempts, attempts), BINS)
    robot.config = replace(run.robot, gate="open")
    for name, inputs in (("known", known), ("new", new)):
        situations = _situations(run, run.tests, inputs, after)
        test = run_attempts(robot, situations, inputs, run.tests, after, learning=False)
        results |= {f"test_{name}_{key}": value for key, value in counts(test, 1).items()}
    return results


def _situations(run: AttemptsConfig, count: int, faces: FaceInputs, rng: np.random.Generator) -> AttemptSituations:
    locations = draw_tables(run.table, count, rng)
    return AttemptSituations.of_locations(locations, faces, run.faces.jitter_deg, rng)


@cache
def face_banks(config: FaceBankConfig) -> tuple[FaceBank, FaceBank]:
    """The faces of a run, and others of the same caregiver; rendered once in every process."""
    known, new = (np.random.default_rng(child) for child in np.random.SeedSequence(0).spawn(2))
    return render_faces(config, known), render_faces(TEST_FACES, new)


def trial(run: AttemptsConfig, seed: int) -> dict[str, list[int]]:
    """Trial: outcomes of a run, counted in stretches, and of its tests."""
    outcomes = live_one(run, *face_banks(run.faces), seed)
    return {name: values.astype(int).tolist() for name, values in outcomes.items()}
