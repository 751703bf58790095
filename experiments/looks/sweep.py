"""A caregiver before a camera that never turns, and what the coder of looks, and simpler ones, make of that."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np

from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.footage.looks.coding import PARTNER, ObservedLooks, code_looks
from jointattn_mj.footage.looks.config import LooksConfig
from jointattn_mj.options import Checked, Real, Share, Whole
from jointattn_mj.perception.som import SOM, SOMConfig
from jointattn_mj.perception.state import StateConfig, StatePerception
from jointattn_mj.recordings.agreement import kappa
from jointattn_mj.scene.camera import pixels_of_points
from jointattn_mj.scene.caregiver import FRAME_S, Phase, TransferScript
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.people import IDENTITIES
from jointattn_mj.scene.world import World, WorldConfig, WorldObservation
from jointattn_mj.sweeps.claim import Setting

from ..cross_situational.caregivers import CarelessScript, CarelessWorld
from .rendered import film, perceived

CAMERA = np.array([0.0, -0.16])
"""Pan and tilt of the camera, rad: face and table are in view."""
HEIGHT_PX = 41.0
"""Height of the caregiver's face in the image."""
PX_PER_CM = 1.64
"""Of the image at the caregiver's face, which is 25 cm high."""
LEAN_LOOKS = 50
"""Looks for which the caregiver leans in one way."""
HIDDEN_LOOKS = 15
"""Looks for which an object is hidden."""
MINUTES = (3.0, 6.0, 13.0, 26.0)
LABELLED = 5.0
"""Minutes that somebody codes, from the beginning."""
PARTNER_AT = np.array([1.0, 0.5, 1.0])
"""Where another person's face is, world frame, m: beside the table, in view of the camera."""
PARTNER_SWAY_PX = 3.0
"""Standard deviation of its location, which changes every ten seconds."""
APART_DEG = 9.0
"""Angle from the nearest object from which a look away is at something clearly else."""
FIRST_SEED = 340_000
"""Held-out seeds; numbers of ``LooksConfig`` were chosen on 40 to 43, 100 and 101."""
VERSION = 4


@dataclass(frozen=True)
class FilmedTable(Checked):
    """A caregiver at a table, and how the camera sees them."""

    world: WorldConfig = field(default_factory=WorldConfig)
    looks_away: Share = 0.0
    """Probability, in each phase after turning to an object, of looking at an empty position instead."""
    at_partner: bool = False
    """Whether it is another person's face instead of an empty position."""
    handles: Share = 1.0
    """Share of looks at an object after which it is handled."""
    hidden: Annotated[float, Real("[0, 0.9]")] = 0.0
    """Share of the time in which each object is hidden, in spells of three seconds."""
    lean_cm: Annotated[float, Real("[0, 100]")] = 0.0
    """Standard deviation of the head's location, which changes every ten seconds."""
    state: StateConfig = field(default_factory=StateConfig)
    """Errors of perception."""
    looks: LooksConfig = field(default_factory=LooksConfig)


@dataclass(frozen=True)
class Webcam(Checked):
    """A caregiver who is filmed as by a webcam: one of the six people, by the seed."""

    world: WorldConfig = field(default_factory=WorldConfig)
    minutes: Annotated[float, Real("[3, 1000]")] = 26.0
    """Length of the video."""
    fps: Annotated[int, Whole("[1, 30]")] = 15
    """Images a second, as of a webcam in the light of a room; a divisor of 30."""
    noise: Annotated[float, Real("[0, 100]")] = 4.0
    """Standard deviation of each pixel's noise, grey values. The video is compressed with H.264."""
    looks: LooksConfig = field(default_factory=LooksConfig)


def table(objects: int = 4, head_share: float | None = None, **more: Any) -> Setting:
    """Three sessions with some settings changed.

    Args:
        objects: How many there are on the table.
        head_share: Share of the head in a turn of gaze; None for the usual one.
        more: Fields of ``FilmedTable``.
    """
    world = WorldConfig()
    behaviour = world.behaviour if head_share is None else replace(world.behaviour, head_share=head_share)
    scene = replace(world.scene, objects=OBJECTS[:objects])
    return Setting(FilmedTable(replace(world, scene=scene, behaviour=behaviour), **more), 3)


SETTINGS = {
    "usual": table(),
    "leans_3_cm": table(lean_cm=3.0),
    "looks_away": table(looks_away=0.25),
    "looks_at_partner": table(looks_away=0.25, at_partner=True),
    "objects_hidden_30%": table(hidden=0.3),
    "six_objects": table(objects=6),
    "eyes_half_of_the_turn": table(head_share=0.5),
    "face_noise_3_deg": table(state=StateConfig(pattern_noise_deg=3.0)),
    "face_noise_6_deg": table(state=StateConfig(pattern_noise_deg=6.0)),
    "handles_every_5th": table(handles=0.2),
    "handles_every_20th": table(handles=0.05),
    "handles_nothing": table(handles=0.0),
    "webcam": Setting(Webcam(), 6),
}
"""All but the last are perceived from the state; the last is rendered, filmed, and perceived as any video."""


class SeldomScript(CarelessScript):
    """Looks at objects, and handles some of them; ``handles`` is the share. May look at a partner's face."""

    handles = 1.0
    at_partner = False

    def _anywhere(self) -> np.ndarray:
        return PARTNER_AT if self.at_partner else super()._anywhere()

    def _begin(self, phase: Phase) -> None:
        if phase is Phase.REACH and self.handles < 1 and self._rng.random() >= self.handles:
            phase = Phase.GAZE
        super()._begin(phase)

    @property
    def apart_deg(self) -> float:
        """Angle between the line of sight and the nearest object."""
        return float(np.degrees(np.hypot(*(self._sight(self.objects) - self._gaze).T).min()))

    @property
    def aim(self) -> tuple[int | None, Phase | None]:
        """What changes when the head turns to something else: each look away is at a position of its own."""
        return self.target, self.phase if self.target is None else None


def world_of(asked: FilmedTable) -> type[World]:
    """A class of worlds with the caregiver that is asked for."""
    attributes = {"looks_away": asked.looks_away, "handles": asked.handles, "at_partner": asked.at_partner}
    script: type[TransferScript] = type("Script", (SeldomScript,), attributes)
    return type("ScriptedWorld", (CarelessWorld,), {"script": script})


@dataclass(frozen=True, eq=False)
class FilmedSession:
    """What the camera saw, and the ground truth, look by look: arrays of n looks.

    Attributes:
        faces: (n, 2) yaw and pitch of the head as perceived, deg.
        px: (n, k + 1, 2) candidates and, last, the face; NaN where hidden.
        moves: (n, k) whether each candidate was seen to move.
        target: (n,) number of the candidate that was looked at; k for away.
        settled: (n,) while the head is still, turned to objects and to elsewhere.
        apart_deg: (n,) angle between the line of sight and the nearest object.
    """

    faces: np.ndarray
    px: np.ndarray
    moves: np.ndarray
    target: np.ndarray
    settled: np.ndarray
    apart_deg: np.ndarray


def watch(asked: FilmedTable, seed: int, minutes: float) -> FilmedSession:
    """Watch a caregiver for some minutes.

    Args:
        asked: The caregiver and the camera.
        seed: Of all random draws.
        minutes: Length.
    """
    seeds = np.random.SeedSequence(seed).spawn(3)
    world = world_of(asked).build(asked.world, seeds[0])
    perception = StatePerception(asked.state, world, np.random.default_rng(seeds[1]))
    camera, count = WorldObservation(world), len(asked.world.scene.objects)
    faces, px, moves, target, settled, apart = [], [], [], [], [], []
    turn_frames, before, since = round(asked.world.behaviour.turn_s / FRAME_S), None, 0
    try:
        for frame in range(round(minutes * 60 / FRAME_S)):
            world.step(CAMERA)
            caregiver: Any = world.caregiver
            since = since + 1 if caregiver.aim == before else 0
            before = caregiver.aim
            if frame % asked.looks.every:
                continue
            percept = perception.perceive(camera, landed=False)
            faces.append(perception.face_pattern())
            px.append(np.where(percept.visible[:, None], percept.px, np.nan))
            moves.append(percept.moves[:count])
            target.append(count if caregiver.target is None else caregiver.target)
            settled.append(caregiver.phase not in (Phase.TURN, Phase.GREET) and since >= turn_frames)
            apart.append(caregiver.apart_deg)
    finally:
        world.close()
    rng, seen = np.random.default_rng(seeds[2]), np.array(px)
    leans = rng.normal(0, asked.lean_cm * PX_PER_CM, (len(seen) // LEAN_LOOKS + 1, 2))
    seen[:, -1] += np.repeat(leans, LEAN_LOOKS, axis=0)[: len(seen)]
    seen[:, :-1][hidden(rng, len(seen), count, asked.hidden)] = np.nan
    moving = np.array(moves)
    if asked.at_partner:
        sways = np.repeat(rng.normal(0, PARTNER_SWAY_PX, (len(seen) // LEAN_LOOKS + 1, 2)), LEAN_LOOKS, axis=0)
        partner = pixels_of_points(PARTNER_AT[None], np.degrees(CAMERA)) + sways[: len(seen)]
        seen = np.concatenate([seen[:, :-1], partner[:, None], seen[:, -1:]], axis=1)
        moving = np.column_stack([moving, np.zeros(len(seen), bool)])
    return FilmedSession(np.array(faces), seen, moving, np.array(target), np.array(settled), np.array(apart))


def hidden(rng: np.random.Generator, looks: int, objects: int, share: float) -> np.ndarray:
    """When each object is hidden, (looks, objects), in spells of ``HIDDEN_LOOKS`` that make up ``share``.

    Args:
        rng: Draws when.
        looks: Number of looks.
        objects: Number of objects.
        share: Of the time in which an object is hidden, 0 to 1.
    """
    starts = rng.random((looks, objects)) < -np.log1p(-share) / HIDDEN_LOOKS
    kernel = np.ones(HIDDEN_LOOKS)
    return np.stack([np.convolve(start, kernel)[:looks] > 0 for start in starts.T], axis=1)


def trial(asked: FilmedTable | Webcam, seed: int) -> dict[str, Any]:
    """Trial: by minutes of video, how the codes of all coders agree with where the caregiver looked, head still.

    Of each coder ``kappa`` by seconds; of the coder of looks also how many of the seconds were ``sure``, how many of
    those were ``right``, hits and false alarms of away, hits ``apart`` from all objects, ``placements`` in all, whether
    it was ``coded``, and ``kappa`` of the rest where the first minutes have labels.
    """
    if isinstance(asked, Webcam):
        with TemporaryDirectory() as folder:
            parts = filmed(asked, seed, Path(folder) / "table.mp4")
            return {f"{minutes:g}": compared(*parts[minutes], asked.looks) for minutes in parts}
    whole = watch(asked, seed, MINUTES[-1])
    per_minute = round(60 / (asked.looks.every * FRAME_S))
    return {f"{minutes:g}": _coded(asked, seed, _first(whole, round(minutes * per_minute))) for minutes in MINUTES}


def filmed(asked: Webcam, seed: int, video: Path) -> dict[float, tuple[ObservedLooks, FilmedSession]]:
    """Film a caregiver, and watch the video with ``perceive --looks``; by minutes, what was seen and what was so.

    Args:
        asked: Scene, objects and options.
        seed: Of the session; it also chooses the caregiver.
        video: File that is written.
    """
    seeds = np.random.SeedSequence(seed).spawn(2)
    scene = replace(asked.world.scene, caregiver=sorted(IDENTITIES)[seed % len(IDENTITIES)])
    world = world_of(FilmedTable()).build(replace(asked.world, scene=scene), seeds[0])
    try:
        film(world, video, asked.minutes, CAMERA, asked, np.random.default_rng(seeds[1]))
    finally:
        world.close()
    config = PerceiveConfig(video, objects=tuple(item.name for item in scene.objects), looks=True, coding=asked.looks)
    ends = tuple(minutes for minutes in MINUTES if minutes <= asked.minutes)
    found = {}
    truth = watch(FilmedTable(replace(asked.world, scene=scene), looks=asked.looks), seed, asked.minutes)
    for minutes, seen in perceived(config, ends).items():
        part = _first(truth, len(seen.faces))
        px = np.concatenate([seen.px, seen.face_px[:, None]], axis=1)
        faces = np.column_stack([seen.yaw_deg, seen.yaw_deg])
        found[minutes] = seen, replace(part, faces=faces, px=px)
    return found


def _first(session: FilmedSession, looks: int) -> FilmedSession:
    return FilmedSession(**{name: values[:looks] for name, values in vars(session).items()})


def _coded(asked: FilmedTable, seed: int, session: FilmedSession) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    som = SOM(2, SOMConfig(), rng)
    som.train(session.faces[rng.permutation(len(session.faces))[: som.config.updates]], rng)
    active = np.array([som.activations(face, asked.looks.softness) for face in session.faces])
    names = tuple(item.name for item in asked.world.scene.objects)
    seen = ObservedLooks(
        (*names, PARTNER) if asked.at_partner else names, active, session.px[:, -1], session.px[:, :-1],
        session.faces[:, 0], np.zeros(len(active), bool), HEIGHT_PX, asked.looks.every * FRAME_S,
    )  # fmt: skip
    return compared(seen, session, asked.looks)


def compared(seen: ObservedLooks, session: FilmedSession, config: LooksConfig) -> dict[str, Any]:
    """How all coders agree with where the caregiver looked; see ``trial``.

    Args:
        seen: What was perceived of the caregiver.
        session: Where the caregiver looked, and when the head was still.
        config: Options of the coder.
    """
    coded, count = code_looks(seen, config), seen.px.shape[1]
    settled = np.flatnonzero(session.settled)
    seconds = settled[settled % round(1 / seen.step_s) == 0]
    right = coded.best == session.target
    sure = np.asarray((coded.posterior > config.sure).any(axis=1))
    away, apart = session.target == count, session.apart_deg > APART_DEG
    clear = (away & apart)[seconds]
    others = {
        "last_moved": last_moved(session.moves),
        "nearest": nearest(session.px),
        "yaw": by_yaw(session),
    }
    labelled = round(LABELLED * 60 / seen.step_s)
    labels = np.where(session.settled & (np.arange(len(away)) < labelled), session.target, -1)
    later = seconds[seconds >= labelled]
    helped = code_looks(seen, config, labels) if len(later) else None
    return {
        "kappa": agreed(coded.best, session.target, seconds, count),
        "seconds": len(seconds),
        "sure": float(sure[seconds].mean()),
        "right_if_sure": float(right[seconds][sure[seconds]].mean()) if sure[seconds].any() else None,
        "sure_alone": float((coded.alone > config.sure).mean()),
        "away": float(away[seconds].mean()),
        "away_hits": float(right[seconds][away[seconds]].mean()) if away[seconds].any() else None,
        "away_apart": float(apart[seconds][away[seconds]].mean()) if away[seconds].any() else None,
        "away_hits_apart": float(right[seconds][clear].mean()) if clear.any() else None,
        "away_false": float((coded.best == count)[seconds][~away[seconds]].mean()),
        "placements": int(coded.placements.sum()),
        "coded": not coded.doubt,
        "kappa_after_labels": None if helped is None else agreed(helped.best, session.target, later, count),
        "kappa_without_labels": None if helped is None else agreed(coded.best, session.target, later, count),
        **{name: agreed(codes, session.target, seconds, count) for name, codes in others.items()},
    }


def agreed(codes: np.ndarray, target: np.ndarray, where: np.ndarray, objects: int) -> float:
    """Cohen's kappa of codes (n,) and targets (n,) at some indices; codes are 0 to ``objects``.

    Args:
        codes: (n,) codes, 0 to ``objects``.
        target: (n,) where the caregiver looked, likewise.
        where: Indices that count.
        objects: Number of objects, the highest code.
    """
    size = objects + 1
    counts = np.bincount(codes[where] * size + target[where], minlength=size * size)
    return kappa(counts.reshape(size, size))


def last_moved(moves: np.ndarray) -> np.ndarray:
    """Number of the object that moves, or moved last, (n,), by motion as seen (n, k); the first one until then."""
    last = np.maximum.accumulate(np.where(moves, np.arange(len(moves))[:, None], -1), axis=0)
    numbers: np.ndarray = last.argmax(axis=1)
    return numbers


def nearest(px: np.ndarray) -> np.ndarray:
    """Number of the object nearest to the face in the image, (n,), of pixels (n, k + 1, 2) with the face last."""
    far = np.linalg.norm(px[:, :-1] - px[:, -1:], axis=-1)
    numbers: np.ndarray = np.where(np.isfinite(far), far, np.inf).argmin(axis=1)
    return numbers


def by_yaw(session: FilmedSession) -> np.ndarray:
    """Number of the object nearest in x to what a line makes of yaw, (n,); the line is fitted to the true targets."""
    count = session.px.shape[1] - 1
    across = session.px[:, :-1, 0] - session.px[:, -1:, 0]
    target = across[np.arange(len(across)), np.minimum(session.target, count - 1)]
    yaw = session.faces[:, 0]
    fit = session.settled & (session.target < count) & np.isfinite(target) & np.isfinite(yaw)
    line = np.polyfit(yaw[fit], target[fit], 1)
    off = np.abs(across - np.polyval(line, yaw)[:, None])
    numbers: np.ndarray = np.where(np.isfinite(off), off, np.inf).argmin(axis=1)
    return numbers
