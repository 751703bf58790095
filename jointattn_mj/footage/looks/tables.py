"""Codes of looks as a table, a row a look, and as an event tier."""

import numpy as np
import pyarrow as pa

from jointattn_mj.footage.looks.coding import LooksCoded
from jointattn_mj.footage.spans import Span
from jointattn_mj.gaze_following.columns import described

TIER = "looks at"
MEANINGS = {
    "time_s": "time in the video",
    "looks_at": "where the person looks: an object, away, unsure, or cannot be seen",
    "best": "the most probable target, also where the answer is unsure",
    "posterior": "probability of the best, given all looks of the video",
    "posterior_alone": "probability of the most probable object among the objects, given this look alone",
}


def looks_table(coded: LooksCoded, times: np.ndarray) -> pa.Table:
    """A row a look, with the posterior of every target, as in ``cup_posterior``.

    Args:
        coded: The codes.
        times: (n,) time of each, s.
    """
    targets, unseen = coded.labels[: coded.posterior.shape[1]], np.isnan(coded.posterior).all(axis=1)

    def named(numbers: np.ndarray, missing: np.ndarray | None = None) -> pa.Array:
        return pa.DictionaryArray.from_arrays(pa.array(numbers.astype(np.int8), mask=missing), list(coded.labels))

    def share(values: np.ndarray) -> pa.Array:
        return pa.array(values.astype(np.float32), mask=np.isnan(values))

    columns = {
        "time_s": pa.array(times),
        "looks_at": named(coded.codes),
        "best": named(coded.best, unseen),
        "posterior": share(np.where(unseen, np.nan, coded.posterior.max(axis=1))),
        "posterior_alone": share(coded.alone),
    }
    columns |= {f"{name}_posterior": share(coded.posterior[:, k]) for k, name in enumerate(targets)}
    posteriors = {f"{name}_posterior": f"probability of {name}, given all looks of the video" for name in targets}
    return described(pa.table(columns), MEANINGS | posteriors)


def looks_spans(coded: LooksCoded, frames: np.ndarray, end: int) -> list[Span]:
    """Looks that follow each other with the same code, as events; the score is their mean posterior.

    Args:
        coded: The codes.
        frames: (n,) number of the frame of each look.
        end: Number of the frame after the last one.
    """
    if not len(frames):
        return []
    starts = np.concatenate([[0], np.flatnonzero(np.diff(coded.codes)) + 1])
    ends = np.append(starts[1:], len(frames))
    until = np.append(frames[starts[1:]], end)
    spans = []
    for first, last, stop in zip(starts, ends, until, strict=True):
        best = coded.posterior[first:last].max(axis=1)
        span = Span(TIER, coded.labels[coded.codes[first]], int(frames[first]), int(stop))
        if np.isfinite(best).all():
            span.total, span.frames = float(best.sum()), last - first
        spans.append(span)
    return spans
