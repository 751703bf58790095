"""Codes of where a person looks: an object, away, or that it cannot be seen; and how far they can be trusted."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from jointattn_mj.footage.looks.config import LooksConfig
from jointattn_mj.footage.looks.learning import learn_evidence, posterior, smoothed
from jointattn_mj.footage.looks.locations import last_locations, placements

AWAY, UNSURE, UNSEEN = "away", "unsure", "cannot be seen"
"""Codes beside the candidates' names."""


@dataclass(frozen=True, eq=False)
class ObservedLooks:
    """What is seen of a person and of candidates, look by look.

    Attributes:
        names: Of the k candidates.
        faces: (n, u) activations of a map of faces; zeros where the face is not seen.
        face_px: (n, 2) the face; NaN where it is not seen.
        px: (n, k, 2) the candidates; NaN where one is not seen.
        cut: (n,) whether the image was cut since the look before.
        height_px: Height of the face's square, pixels: the unit of distance.
        step_s: Seconds from look to look.
    """

    names: tuple[str, ...]
    faces: np.ndarray
    face_px: np.ndarray
    px: np.ndarray
    cut: np.ndarray
    height_px: float
    step_s: float


@dataclass(frozen=True, eq=False)
class LooksCoded:
    """Codes of looks.

    Attributes:
        labels: What codes mean: the candidates, then away, unsure, cannot be seen.
        codes: (n,) index of the answer among the labels.
        best: (n,) index of the most probable target, also where the answer is unsure or nothing was coded.
        posterior: (n, k + 1) of each target, the last being away, given all looks; NaN where the face is not seen, and
            where nothing was coded.
        alone: (n,) posterior of the best object among the objects, by this look alone; NaN where the face is not seen.
        placements: (k,) locations at which each candidate has rested.
        doubt: Why nothing was coded; empty where something was.
    """

    labels: tuple[str, ...]
    codes: np.ndarray
    best: np.ndarray
    posterior: np.ndarray
    alone: np.ndarray
    placements: np.ndarray
    doubt: str

    def summary(self, config: LooksConfig) -> dict[str, Any]:
        """Numbers that say how far the codes can be trusted."""
        visible = self.codes != self.labels.index(UNSEEN)
        count = max(int(visible.sum()), 1)
        return {
            "looks": len(self.codes),
            "shares": {
                label: round(float((self.codes == code).mean()), 4) if len(self.codes) else 0.0
                for code, label in enumerate(self.labels)
            },
            "placements": dict(zip(self.labels, self.placements.tolist(), strict=False)),
            "sure": round(float((self.posterior[visible] > config.sure).any(axis=1).sum() / count), 4),
            "sure_by_a_look_alone": round(float((self.alone[visible] > config.sure).sum() / count), 4),
            "coded": not self.doubt,
            "why_not": self.doubt or None,
        }


def code_looks(looks: ObservedLooks, config: LooksConfig) -> LooksCoded:
    """Code every look of a video, learned from all of them.

    Args:
        looks: What was seen.
        config: How looks are learned and coded.
    """
    n, k = looks.px.shape[:2]
    visible = np.isfinite(looks.face_px).all(-1)
    face = last_locations(looks.face_px[:, None], looks.cut)
    locations = (last_locations(looks.px, looks.cut) - face) / looks.height_px
    evidence = np.zeros((n, k + 1))
    evidence[visible, :k] = learn_evidence(looks.faces[visible], locations[visible], config)
    evidence[:, k] = -np.inf if config.away is None else np.where(visible, config.away, 0.0)
    stay = max(1 - looks.step_s / config.dwell_s, 1 / (k + 1))
    likely = _smoothed(evidence, stay, config)
    alone = posterior(evidence[:, :k]).max(axis=1, initial=0)
    lost = _long_runs(~visible, max(1, round(config.lost_s / looks.step_s)))
    # locations of the image, not from the face: a person who moves puts nothing down
    counts = placements(looks.px / looks.height_px)
    best = likely.argmax(axis=1)
    labels = (*looks.names, AWAY, UNSURE, UNSEEN)
    doubt = _doubt(counts, alone[visible], config)
    codes = np.where((likely.max(axis=1, initial=0) < config.least) | bool(doubt), labels.index(UNSURE), best)
    codes[lost] = labels.index(UNSEEN)
    likely[lost | bool(doubt)] = np.nan
    alone[~visible] = np.nan
    return LooksCoded(labels, codes, best, likely, alone, counts, doubt)


def _smoothed(evidence: np.ndarray, stay: float, config: LooksConfig) -> np.ndarray:
    """Posterior (n, k + 1) of all targets; 0 for away where that is no answer."""
    if not len(evidence):
        return np.zeros(evidence.shape)
    if config.away is not None:
        return smoothed(evidence, stay, config.trust)
    if evidence.shape[1] == 1:
        return np.zeros(evidence.shape)
    return np.column_stack([smoothed(evidence[:, :-1], stay, config.trust), np.zeros(len(evidence))])


def _doubt(counts: np.ndarray, alone: np.ndarray, config: LooksConfig) -> str:
    """Why the looks of a video should not be coded; empty if they may be."""
    if not len(alone):
        return "the face was not seen"
    if counts.sum() < config.placements:
        return (
            f"objects rested at {counts.sum()} locations in all, and {config.placements} are asked for: where little "
            "is moved, nothing tells at what somebody looks"
        )
    share = float((alone > config.sure).mean())
    if share < config.sure_alone:
        return f"{share:.1%} of the looks are sure by themselves, and {config.sure_alone:.0%} are asked for"
    return ""


def _long_runs(flags: np.ndarray, least: int) -> np.ndarray:
    """(n,) where ``flags`` (n,) are set for at least so many looks in a row."""
    kept = np.zeros(len(flags), bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        kept[start:end] = end - start >= least
    return kept
