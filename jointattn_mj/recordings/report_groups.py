"""Groups of recordings on the page about coded interaction: joint attention and contingency of each, compared."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from jointattn_mj.recordings.dyads import compare, kinds_of

if TYPE_CHECKING:
    from jointattn_mj.recordings.measure import MeasureResult
    from jointattn_mj.recordings.report import RecordingReport

Rows = list[dict[str, Any]]


def compared(report: "RecordingReport") -> tuple[Rows, Rows]:
    """Each group's mean of each value, and comparisons of groups by permutation of recordings over them.

    Args:
        report: What was found.

    Returns:
        A row a value and group, and a row a value and comparison; none where recordings are not compared.
    """
    if report.group_of is None:
        return [], []
    groups, comparisons = _joint_attention(report)
    named: list[tuple[str, MeasureResult]] = [
        *((f"transfer entropy: {a} → {b}", result) for (a, b), result in report.pairs.items()),
        *((f"SAC: ({s}, {a}) → {r}", result) for (s, a, r), result in report.sac.items()),
    ]
    for name, result in named:
        for of_dyads in result.dyads[:1]:
            groups += [
                {"value": name, "group": of_group.name, "recordings": of_group.dyads, "mean": of_group.mean,
                 "sd": of_group.sd, "low": of_group.interval[0], "high": of_group.interval[1]}
                for of_group in of_dyads.groups[1:]
            ]  # fmt: skip
            comparisons += [{"value": name} | asdict(comparison) for comparison in of_dyads.comparisons]
    return groups, comparisons


def _joint_attention(report: "RecordingReport") -> tuple[Rows, Rows]:
    """Groups compared by what articles report of joint attention, a row a measure; and tests of the differences."""
    assert report.group_of is not None
    rows = [row for row in report.attention.rows() if row["recording"] in report.group_of]
    labels = np.array([report.group_of[row["recording"]] for row in rows])
    groups: Rows = []
    comparisons: Rows = []
    rng = np.random.default_rng(np.random.SeedSequence([report.options.seed, 0]))
    by = report.options.by or ""
    for name in rows[0] if rows else ():
        if name in ("recording", "seconds"):
            continue
        values = np.array([float(row[name]) for row in rows])
        known = np.isfinite(values)  # a recording without looks to follow has no latency
        kinds = kinds_of(labels[known])
        for kind in kinds:
            own = values[known & (labels == kind)]
            sd = float(own.std(ddof=1)) if len(own) > 1 else float("nan")
            groups.append(
                {"value": name, "group": f"{by} {kind}", "recordings": len(own), "mean": float(own.mean()), "sd": sd}
            )
        comparisons += [
            {"value": name} | asdict(comparison)
            for comparison in compare(values[known], labels[known], kinds, by, report.options.surrogates, rng)
        ]
    return groups, comparisons
