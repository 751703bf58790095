"""Codes of where a person looks: an object, away, or that it cannot be seen; and how far they can be trusted."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from jointattn_mj.footage.looks.away import probability_away
from jointattn_mj.footage.looks.config import LooksConfig
from jointattn_mj.footage.looks.learning import aside, learn_evidence, posterior, smoothed
from jointattn_mj.footage.looks.locations import MOVED_HEIGHTS, known_locations, last_locations, placements

AWAY, UNSURE, UNSEEN = "away", "unsure", "cannot be seen"
"""Codes beside the candidates' names."""
PARTNER = "partner"
"""Name of the candidate that is another person's face."""
LEVELS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8)
"""Values of ``LooksConfig.away`` that labels choose from."""
BLOCK_S = 30.0
"""Seconds that are learned from, or judged, as one."""


@dataclass(frozen=True, eq=False)
class ObservedLooks:
    """What is seen of a person and of candidates, look by look.

    Attributes:
        names: Of the k candidates.
        faces: (n, u) activations of a map of faces; zeros where the face is not seen.
        face_px: (n, 2) the face; NaN where it is not seen.
        px: (n, k, 2) the candidates; NaN where one is not seen.
        yaw_deg: (n,) yaw of the head, positive to the right of the image; NaN where it is not known.
        cut: (n,) whether the image was cut since the look before.
        height_px: Height of the face's square, pixels: the unit of distance.
        step_s: Seconds from look to look.
    """

    names: tuple[str, ...]
    faces: np.ndarray
    face_px: np.ndarray
    px: np.ndarray
    yaw_deg: np.ndarray
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


def code_looks(looks: ObservedLooks, config: LooksConfig, labels: np.ndarray | None = None) -> LooksCoded:
    """Code every look of a video, learned from all of them.

    Args:
        looks: What was seen.
        config: How looks are learned and coded.
        labels: (n,) what a person has coded in some looks, as index among the candidates, and their number k for away;
            -1 where nobody has. Learning takes these for granted.
    """
    n, k = looks.px.shape[:2]
    visible = np.isfinite(looks.face_px).all(-1)
    face = last_locations(looks.face_px[:, None], looks.cut)
    locations = (known_locations(looks.px, looks.cut, MOVED_HEIGHTS * looks.height_px) - face) / looks.height_px
    given = labels is not None and bool((labels[visible] >= 0).any())
    # locations of the image, not from the face: a person who moves puts nothing down
    counts = placements(looks.px / looks.height_px)
    is_partner = np.array([name == PARTNER for name in looks.names], bool)
    evidence, away = np.zeros((n, k)), [np.zeros(n)]
    if visible.any():
        first = aside(looks.yaw_deg[visible], locations[visible]) if config.start == "yaw" else None
        coded = labels[visible] if labels is not None and given else None
        block = round(BLOCK_S / looks.step_s)
        learned = learn_evidence(looks.faces[visible], locations[visible], config, first, coded, block)
        evidence[visible] = learned.looks
        if config.away is not None and k:
            known, still = np.isfinite(locations[visible]).all((1, 2)), is_partner | (counts <= 1)
            last = np.maximum(np.cumsum(visible) - 1, 0)
            levels = LEVELS if given else (config.away,)
            away = [probability_away(learned, known, still, level)[last] for level in levels]
    alone = posterior(evidence).max(axis=1, initial=0) if k else np.zeros(n)
    hidden = visible[:, None] & ~np.isfinite(locations).all(-1) & np.isfinite(looks.px).all(-1).any(axis=0)
    stay = max(1 - looks.step_s / config.dwell_s, 1 / (k + 1))
    told = np.where(visible, labels, -1) if given and labels is not None else None
    likely = _likely(np.where(hidden, config.hidden, evidence), stay, config.trust, away, told)
    best = likely.argmax(axis=1)
    lost = _long_runs(~visible, max(1, round(config.lost_s / looks.step_s)))
    moved = int(counts[~is_partner].sum())
    if moved and not given:
        believed = moved / (moved + config.half_sure)
        likely = believed * likely + (1 - believed) / max(k + (config.away is not None), 1)
    names = (*looks.names, AWAY, UNSURE, UNSEEN)
    doubt = _doubt(moved, alone[visible], config, given)
    codes = np.where((likely.max(axis=1, initial=0) < config.least) | bool(doubt), names.index(UNSURE), best)
    codes[lost] = names.index(UNSEEN)
    likely[lost | bool(doubt)] = np.nan
    alone[~visible] = np.nan
    return LooksCoded(names, codes, best, likely, alone, counts, doubt)


def _likely(
    evidence: np.ndarray, stay: float, trust: float, away: list[np.ndarray], labels: np.ndarray | None
) -> np.ndarray:
    """Posterior (n, k + 1) of all targets, away being the last.

    Args:
        evidence: (n, k) for each candidate.
        stay: See ``smoothed``.
        trust: See ``smoothed``.
        away: Probability (n,) of looking at none of them, by several judgements of which labels choose one.
        labels: (n,) what a person has coded; None without.
    """
    n, k = evidence.shape
    if not n or not k:
        return np.zeros((n, k + 1))
    targets = smoothed(evidence, stay, trust)
    judged = [np.column_stack([targets * (1 - share[:, None]), share]) for share in away]
    if labels is None:
        return judged[0]
    told = np.flatnonzero(labels >= 0)
    return max(judged, key=lambda likely: float(np.log(np.maximum(likely[told, labels[told]], 1e-3)).mean()))


def _doubt(moved: int, alone: np.ndarray, config: LooksConfig, labelled: bool) -> str:
    """Why the looks of a video should not be coded; empty if they may be.

    Args:
        moved: Locations at which objects have rested in all.
        alone: Posterior of the best object by each look alone.
        config: What is asked for.
        labelled: Whether a person has coded some looks, so that objects need not be moved.
    """
    if not len(alone):
        return "the face was not seen"
    if moved < config.placements and not labelled:
        return (
            f"objects rested at {moved} locations in all, and {config.placements} are asked for: where little is "
            "moved, nothing tells at what somebody looks"
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
