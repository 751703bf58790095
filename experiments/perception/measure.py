"""How well the pixel path perceives, in closed loop: the numbers that ``StateConfig`` stands in for.

python -m experiments.perception.measure --out experiments/perception/measured.json
"""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.io.files import write_whole
from jointattn_mj.options import Checked, Choice, Real, Whole
from jointattn_mj.perception.som import standardised
from jointattn_mj.scene.camera import in_image, pixels_of_points
from jointattn_mj.scene.people import IDENTITIES

NEIGHBOURS = 5
"""Patterns that a read-out averages over."""


@dataclass(frozen=True)
class PerceptionOptions(Checked):
    """Where the measured errors go."""

    out: Path | None = None
    """JSON file for the result."""
    minutes: Annotated[float, Real("(0, 1e6]")] = 8.0
    """Simulated minutes a session."""
    seeds: Annotated[int, Whole("[1, 1e6]")] = 2
    """Sessions a caregiver."""
    caregivers: tuple[Annotated[str, Choice(IDENTITIES)], ...] = ("robin", "noa", "kai", "amara", "elin", "tove")
    """Whose faces."""


def watch_session(config: SessionConfig) -> dict[str, np.ndarray]:
    """Run a session and collect errors, misses, flags and face patterns of every look."""
    session = SessionRun(config)
    session.begin()
    world, robot, face = session.world, session.robot, session.robot.face
    off, in_view, detected, said, real, patterns, angles = [], [], [], [], [], [], []

    def look(session: SessionRun) -> None:
        percept = robot.percept
        if percept is None:
            return
        pixels = pixels_of_points(world.candidate_points(), np.degrees(world.head_angles()))
        off.append(percept.px - pixels)
        in_view.append(in_image(pixels))
        detected.append(percept.visible.copy())
        if robot.landed is None:
            said.append(percept.moves.copy())
            real.append(world.moving(config.state.face_moves_above_deg_s, config.state.object_moves_above_m_s))
        if robot.attended == face and percept.visible[face] and session.frame % 3 == 0:
            patterns.append(standardised(robot.perceiver.face_pattern()))
            angles.append(world.face_angles_deg())

    while session.frame < session.total:
        session.step(look)
    session.close()
    looks = {"off": off, "in_view": in_view, "detected": detected, "said": said, "real": real}
    return {name: np.array(values) for name, values in {**looks, "patterns": patterns, "angles": angles}.items()}


def read_out_error(patterns: np.ndarray, angles: np.ndarray) -> float:
    """Error (deg, each axis) of head yaw and pitch read off the ``NEIGHBOURS`` most similar patterns of the first half,
    for the patterns of the second."""
    half = len(angles) // 2
    known, test = patterns[:half], patterns[half:]
    apart = np.square(known).sum(axis=1) - 2 * test @ known.T
    nearest = np.argsort(apart, axis=1)[:, :NEIGHBOURS]
    return float(np.sqrt(np.mean((angles[nearest].mean(axis=1) - angles[half:]) ** 2)))


def pattern_noise(pixels: dict[str, np.ndarray], exact: dict[str, np.ndarray]) -> float:
    """Noise (deg) on exact head angles with which they would be read out as badly as from images.

    With noise s the mean of k neighbours adds s^2 (1 + 1/k) to the squared error.
    """
    worse, best = (read_out_error(run["patterns"], run["angles"]) for run in (pixels, exact))
    return float(np.sqrt(max(worse**2 - best**2, 0.0) / (1 + 1 / NEIGHBOURS)))


def measure(options: PerceptionOptions) -> dict[str, float]:
    """The rates and standard deviations, pooled over caregivers and seeds; names are those of ``StateConfig``."""
    runs, noise = [], []
    for caregiver in options.caregivers:
        for seed in range(options.seeds):
            config = SessionConfig(minutes=options.minutes, seed=1000 + seed)
            scene = replace(config.world.scene, caregiver=caregiver)
            runs.append(watch_session(replace(config, world=replace(config.world, scene=scene))))
            exact = replace(config, perception="state", state=replace(config.state, pattern_noise_deg=0.0))
            noise.append(pattern_noise(runs[-1], watch_session(exact)))
            print(f"{caregiver} {seed}: pattern noise {noise[-1]:.2f} deg")

    def pooled(name: str) -> np.ndarray:
        return np.concatenate([run[name] for run in runs])

    def spread(errors: np.ndarray) -> float:
        return float(np.sqrt(np.nanmean(np.square(errors - np.nanmean(errors, axis=0)))))

    in_view, detected, said, real = (pooled(name) for name in ("in_view", "detected", "said", "real"))
    return {
        "face_noise_px": float(np.mean([spread(run["off"][:, -1]) for run in runs])),
        "face_miss": 1 - float(detected[:, -1][in_view[:, -1]].mean()),
        "object_noise_px": float(np.nanmedian(np.abs(pooled("off")[:, :-1]))) * 1.4826,
        "object_miss": 1 - float(detected[:, :-1][in_view[:, :-1]].mean()),
        "pattern_noise_deg": float(np.mean(noise)),
        "face_motion_hit": float(said[:, -1][real[:, -1]].mean()),
        "face_motion_false_alarm": float(said[:, -1][~real[:, -1]].mean()),
        "object_motion_hit": float(said[:, :-1][real[:, :-1]].mean()),
        "object_motion_false_alarm": float(said[:, :-1][~real[:, :-1]].mean()),
        "looks": len(in_view),
        "minutes": options.minutes * len(runs),
    }


def main() -> None:
    """Measure, print, and write."""
    options = tyro.cli(PerceptionOptions, description=__doc__)
    text = json.dumps({name: round(value, 4) for name, value in measure(options).items()}, indent=1) + "\n"
    print(text)
    if options.out is not None:
        write_whole(options.out, lambda path: path.write_text(text))


if __name__ == "__main__":
    main()
