"""The paragraph on methods that can be pasted into a paper: what was done, with every number and setting."""

from typing import TYPE_CHECKING

import numpy as np

from jointattn_mj.io.progress import count
from jointattn_mj.io.provenance import versions
from jointattn_mj.io.results import bracket, number
from jointattn_mj.recordings.delays import delay_in_steps
from jointattn_mj.recordings.dyads import MOST_EXACT
from jointattn_mj.recordings.methods import WORDS

if TYPE_CHECKING:
    from jointattn_mj.recordings.report import RecordingReport


def p_words(p: float) -> str:
    """A p-value as papers have it: ``p = .012``, ``p < .001``."""
    return "p < .001" if p < 0.001 else f"p = {p:.3f}".replace("0.", ".", 1)


def wilson(count: int, of: int) -> tuple[float, float]:
    """95% interval of a share (Wilson 1927)."""
    z, share = 1.959964, count / of
    middle, half = share + z * z / (2 * of), z * np.sqrt(share * (1 - share) / of + z * z / (4 * of * of))
    return float((middle - half) / (1 + z * z / of)), float((middle + half) / (1 + z * z / of))


def methods_paragraph(report: "RecordingReport") -> str:
    """Write the paragraph on methods for an article: what was coded, sampled and tested, and how.

    Args:
        report: The analysis, with its options.
    """
    o, r = report.options, report.options.rules
    seconds = np.array(list(report.attention.seconds.values()))
    lag = delay_in_steps("lag", o.lag, o.step)
    value = "the code at its middle" if o.value_at == "middle" else "the code that lasted for most of it"
    nothing = "has a value of its own" if o.nothing == "none" else "is missing, and recordings were cut there"
    still = " while the partner still looked there" if r.still_looking else ""
    least, most = f"{seconds.min():.0f}", f"{seconds.max():.0f}"
    each = f"{least} s each" if least == most else f"{least} to {most} s each"
    parts = [
        f"Coded events of {count(len(seconds), 'recording')} ({seconds.sum() / 60:.1f} min in all; {each}) on "
        f"{count(len(report.events.tier_names), 'tier')} ({', '.join(report.events.tier_names)}) were sampled to "
        f"steps of {o.step:g} s; each step has {value}; where "
        f"nothing was coded it {nothing} ({report.steps.transitions:,} transitions). {_span_words(report)}",
        f"Shared attention is looking of {r.infant} and {r.partner} at the same target, other than "
        f"{_some([r.infant_at_partner, r.partner_at_infant, *r.nowhere])}. A look follows if it begins within "
        f"{r.follow_within_s:g} s after the partner began to look at the target{still}; looks that begin within "
        f"{r.together_s:g} s of each other begin together. "
        + (f"Mutual gaze lasts at least {r.least_mutual_s:g} s. " if r.least_mutual_s else "")
        + f"Engagement is shared attention of at least {r.least_engagement_s:g} s with breaks of up to {r.bridge_s:g} "
        f"s bridged (after Bakeman and Adamson, 1984); it is coordinated with at least "
        f"{count(r.glances, 'look')} of {r.infant} at the partner's face.",
        f"Contingency is transfer entropy in bits (Schreiber, 2000) from one tier to another at a lag of "
        f"{lag * o.step:.4g} s ({count(lag, 'step')}), less the mean of {o.surrogates:,} surrogates. "
        f"{_surrogates(report)} "
        + _unit_words(report)
        + f"P-values of {len(report.pairs)} pairs of tiers were corrected by Holm's method; over lags of {o.step:g} to "
        f"{o.lags * o.step:.4g} s ({count(o.lags, 'lag')}) by the maximum over lags in each surrogate (Westfall and "
        f"Young, 1993). Transitions at the same lag are adjusted residuals (Bakeman and Quera, 2011), tested by "
        f"{o.surrogates:,} circular shifts"
        + (", and means of the recordings' Yule's Q, with Student's t." if report.over_recordings else ".")
        + " Which look answers which are shares of transfer entropy; p of each is from the same surrogates, corrected "
        "by the maximum over all combinations of looks in each.",
        *_events_words(report),
        *_group_words(report),
        f"The level of significance is {o.alpha:g}.",
        *_results(report),
    ]
    if report.agreements:
        parts.append(_agreement_words(report))
    known = versions()
    parts.append(f"Computed by jointattn_mj {known.get('jointattn_mj', '')} (seed {o.seed}).".replace("  ", " "))
    return " ".join(parts)


def _span_words(report: "RecordingReport") -> str:
    """From when to when there are steps, and what happened to overlaps and gaps."""
    o = report.options
    spans = {
        "all": "from the first onset to the last offset in a recording, or as its file says",
        "coded": "from the first onset to the last offset in a recording, or as its file says, but no longer than each "
        "tier that is coded without gaps",
        "common": "as long as all tiers have events",
    }
    words = [f"There are steps {spans[o.span]}"]
    if o.coded is not None:
        words.append(f"only during events of {o.coded}")
    slack = report.events.resolution if o.slack is None else o.slack
    words.append(f"overlaps and gaps of up to {slack:g} s between events of one tier were closed")
    if o.overlaps == "combine":
        words.append("longer overlaps were combined into values of their own")
    if o.absent != "error":
        nothing = "were taken as if nothing happened on it" if o.absent == "nothing" else "were left out"
        words.append(f"recordings without a tier {nothing}")
    if o.missing == "break":
        words.append("recordings were cut at missing codes")
    return "; ".join(words) + "."


def _agreement_words(report: "RecordingReport") -> str:
    """Kappa of two coders: how, of how many recordings, and what was found."""
    first = report.agreements[0]
    kappas = "; ".join(
        f"{agreed.tier}: {agreed.kappa:.2f}"
        + ("" if np.isnan(agreed.interval[0]) else f" [{agreed.interval[0]:.2f}, {agreed.interval[1]:.2f}]")
        for agreed in report.agreements
    )
    both = len(report.events.recordings) - len(set(first.alone) & set(report.events.recordings))
    intervals = f", with {first.level:.0%} intervals from block bootstraps" if report.options.resamples else ""
    return (
        f"Agreement of two coders of {count(both, 'recording')} is Cohen's kappa by units of {first.step:g} s with a "
        f"tolerance of {first.tolerance_s:g} s{intervals}: {kappas}."
    )


def _results(report: "RecordingReport") -> list[str]:
    """The values of the two directions of looks."""
    sentences = []
    for source, target in (report.options.looks, report.options.looks[::-1]):
        row = next(entry for entry in report.ranking() if (entry["source"], entry["target"]) == (source, target))
        p = report.p_adjusted[source, target]
        sentences.append(
            f"{source} to {target}: {number(row['effective'])} bits {bracket((row['low'], row['high']))}, {p_words(p)}"
        )
    results = "; ".join([*sentences, *report.following(), *report.over_lags()])
    return [f"Found: {results}.".replace("->", "to")]


def _events_words(report: "RecordingReport") -> list[str]:
    """Events by their SAC: how, and what was found."""
    if not report.sac:
        return []
    values = "; ".join(
        f"({row['sensor']}, {row['action']}) to {row['result']}: {number(row['effective'])} bits "
        f"{bracket((row['low'], row['high']))}, {p_words(row['p_adjusted'])}"
        for row in report.events_ranked()
    )
    return [
        f"State-action contingency (SAC) is what two tiers together say about the next value of a third, beyond what "
        f"each says alone, at the same lag and tested likewise; p of {count(len(report.sac), 'event')} was corrected "
        f"by Holm's method: {values}."
    ]


def _group_words(report: "RecordingReport") -> list[str]:
    """How groups were compared, and what came of the two directions of looks."""
    if report.group_of is None:
        return []
    lines = []
    for source, target in (report.options.looks, report.options.looks[::-1]):
        told = [line.split(", ", 1)[1] for line in report.pairs[source, target].group_lines()]
        lines.append(f"{source} to {target}, {'; '.join(told)}")
    return [
        f"Recordings were compared by {report.options.by} by permutation of recordings over groups (two-sided; all "
        f"ways where there are at most {MOST_EXACT:,}, otherwise {report.options.surrogates:,} random ones): "
        f"{'. '.join(lines)}."
    ]


def _surrogates(report: "RecordingReport") -> str:
    methods = {row["method"] for result in report.pairs.values() for row in result.rows()[:1]}
    inflation = [result.rows()[0]["inflation"] for result in report.pairs.values()]
    chosen = " or ".join(WORDS[method] for method in sorted(methods))
    why = (
        f", chosen by the measured autocorrelation (variance by chance {min(inflation):.2f} to {max(inflation):.2f} "
        "times that of permutations)"
        if report.options.method == "auto"
        else ""
    )
    return f"Surrogates are {chosen}{why}."


def _unit_words(report: "RecordingReport") -> str:
    """Whether values are of recordings or of steps."""
    dyads = next((result.dyads[0].groups[0].dyads for result in report.pairs.values() if result.dyads), None)
    if dyads is not None:
        return (
            f"Values are means over {dyads} recordings, with 95% intervals over recordings and two-sided p, both from "
            "the distribution of t in the recordings' surrogates; curves over lags are means over recordings, held "
            "against means of their surrogates. "
        )
    resamples = report.options.resamples
    return f"Intervals (95%) come from {resamples:,} block bootstrap resamples. " if resamples else ""


def _some(names: list[str]) -> str:
    return ", ".join(dict.fromkeys(names))
