"""Joint attention as people report it: mutual gaze, gaze following, who leads, and states of engagement.

All are derived from two tiers that say what each partner looks at, as further tiers of the same events, so that every
measure takes them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.options import Checked, Count, NotNegative, Real
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.intervals import MISSING, Intervals, at_times, intervals_of, overlaps
from jointattn_mj.recordings.sampling import NONE

MUTUAL, SHARED, LEADER, ENGAGEMENT = "mutual gaze", "shared attention", "leader", "engagement"
"""Names of derived tiers. ``PARTNER follows`` come besides, one for each partner."""
SUPPORTED, COORDINATED = "supported", "coordinated"
"""States of engagement, as Bakeman and Adamson (1984) call them: both attend to one object, and the infant does or does
not acknowledge the partner's part in it."""
ROUNDING_S = 5e-7
"""Half of the shortest time that is told apart."""
TOGETHER = "together"
"""Code of the leader tier where both began at the same time."""


@dataclass(frozen=True, kw_only=True)
class JointAttentionRules(Checked):
    """What counts as joint attention."""

    infant: str = "infant"
    """Tier of what the infant, or the robot, looks at."""
    partner: str = "mother"
    """Tier of what the other looks at."""
    infant_at_partner: str = "face"
    """Code of the infant's looks at the partner's face."""
    partner_at_infant: str = "face"
    """Code of the partner's looks at the infant's face."""
    nowhere: tuple[str, ...] = ("away", "off", "none", "(none)")
    """Codes of looks at nothing that could be shared."""
    follow_within_s: Annotated[float, Real("(0, 3600]")] = 3.0
    """A look follows if it begins within so many seconds after the partner began to look there."""
    still_looking: bool = False
    """It follows only while the partner still looks there."""
    together_s: Annotated[float, Real("[0, 60]")] = 0.2
    """Two looks at the same target that begin within so many seconds began together: no one leads. About the time of an
    eye movement, or of a few frames."""
    least_mutual_s: NotNegative = 0.0
    """Shortest mutual gaze that counts."""
    bridge_s: NotNegative = 2.0
    """Breaks in attention to the same target up to so many seconds do not end an episode of engagement."""
    least_engagement_s: NotNegative = 3.0
    """Shortest episode of engagement, as Bakeman and Adamson (1984) coded states of 3 s and more."""
    glances: Count = 1
    """Looks of the infant at the partner's face during an episode from which on it is coordinated."""

    ADVANCED: ClassVar[Sequence[str]] = (
        "still_looking",
        "together_s",
        "least_mutual_s",
        "least_engagement_s",
        "glances",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.infant == self.partner:
            raise ConfigError(f"infant and partner need tiers of their own; both are {self.infant!r}")

    @property
    def no_target(self) -> frozenset[str]:
        """Codes of looks at nothing that could be shared. Where a code is missing, nobody knows the target."""
        return frozenset({self.infant_at_partner, self.partner_at_infant, *self.nowhere, MISSING})


@dataclass(frozen=True)
class GazeFollowing:
    """One look that a partner could follow."""

    recording: str
    follower: str
    """Tier of who could follow."""
    target: str
    onset: float
    """When the partner began to look there (s)."""
    latency: float
    """Seconds until the follower began to look there; NaN: not within the time allowed."""


@dataclass(frozen=True, repr=False)
class JointAttention:
    """Gaze following, mutual gaze and engagement, as derived from two tiers of looks."""

    events: Events
    """All events with the derived tiers."""
    opportunities: tuple[GazeFollowing, ...]
    """Looks that began while the other did not look there yet, followed or not."""
    rules: JointAttentionRules
    seconds: dict[str, float]
    """How long each recording was coded."""

    def __repr__(self) -> str:
        return f"JointAttention({len(self.seconds)} recordings, {len(self.opportunities)} looks that could be followed)"

    def rows(self) -> list[dict[str, Any]]:
        """A row a recording: shares of time, numbers a minute, following and its latency, who leads."""
        return [self._row(name) for name in self.seconds]

    def _row(self, recording: str) -> dict[str, Any]:
        seconds, rules = self.seconds[recording], self.rules
        row: dict[str, Any] = {"recording": recording, "seconds": seconds}
        for tier, codes in ((MUTUAL, ()), (SHARED, ()), (ENGAGEMENT, (SUPPORTED, COORDINATED))):
            spent = intervals_of(self.events, recording, tier)
            for name, kept in [(tier, spent), *((f"{tier}: {code}", spent.coded(code)) for code in codes)]:
                row[f"{name}, share of time"] = float((kept.offset - kept.onset).sum()) / seconds if seconds else 0.0
                row[f"{name}, a minute"] = 60 * len(kept) / seconds if seconds else 0.0
        for follower in (rules.infant, rules.partner):
            chances = [
                opportunity
                for opportunity in self.opportunities
                if (opportunity.recording, opportunity.follower) == (recording, follower)
            ]
            latencies = np.array([opportunity.latency for opportunity in chances])
            followed = latencies[np.isfinite(latencies)]
            row[f"{follower} could follow"] = len(chances)
            row[f"{follower} follows"] = len(followed)
            row[f"{follower} follows, share"] = len(followed) / len(chances) if chances else float("nan")
            row[f"{follower}, median latency (s)"] = float(np.median(followed)) if len(followed) else float("nan")
        leaders = intervals_of(self.events, recording, LEADER)
        for code in (rules.infant, rules.partner, TOGETHER):
            row[f"{code} leads" if code != TOGETHER else "begin together"] = len(leaders.coded(code))
        return row


def joint_attention(events: Events, rules: JointAttentionRules | None = None) -> JointAttention:
    """Derive joint attention from where two partners look.

    Args:
        events: Has a tier of looks of each.
        rules: What counts; None: the defaults of ``JointAttentionRules``.

    Returns:
        The events with derived tiers: mutual gaze, shared attention (code: the target), leader (code: who looked there
        first), who follows whom (code: the target), and engagement (supported or coordinated).

    Raises:
        SeriesError: A tier is not there, or looks overlap on it.

    Examples:
        >>> looks = Events.of(["infant", "infant", "mother"], ["face", "cup", "cup"], [0, 4, 3], [4, 9, 9])
        >>> attention = joint_attention(looks)
        >>> attention.opportunities[0].follower, attention.opportunities[0].latency
        ('infant', 1.0)
    """
    rules = rules or JointAttentionRules()
    for tier in (rules.infant, rules.partner):
        if tier not in events.tier_names:
            raise SeriesError(
                f"there is no tier {tier!r} of looks; there are {', '.join(events.tier_names)}. Name them with infant "
                "and partner"
            )
    derived: list[tuple[str, str, str, float, float]] = []
    opportunities: list[GazeFollowing] = []
    seconds = {}
    for recording in events.recordings:
        infant, partner = (intervals_of(events, recording, tier) for tier in (rules.infant, rules.partner))
        seconds[recording] = _seconds(events, recording, infant, partner)
        for tier, rows in _tiers(infant, partner, rules):
            derived += [(recording, tier, *row) for row in rows]
        for follower, own, other in ((rules.infant, infant, partner), (rules.partner, partner, infant)):
            chances = list(_followed(recording, follower, own, other, rules))
            opportunities += chances
            derived += _follow_rows(chances, own)
    names = (MUTUAL, SHARED, LEADER, ENGAGEMENT, f"{rules.infant} follows", f"{rules.partner} follows")
    added = Events.of(
        [tier for _, tier, *_ in derived],
        [code for *_, code, _, _ in derived],
        [onset for *_, onset, _ in derived],
        [offset for *_, offset in derived],
        [recording for recording, *_ in derived],
        tiers=dict.fromkeys(events.recordings, names),
        resolution=events.resolution,
    )
    return JointAttention(events.joined(added), tuple(opportunities), rules, seconds)


def without_gaps(attention: JointAttention) -> Events:
    """The events with mutual gaze and shared attention said at all times: ``(none)`` where they are not.

    For a derived tier nothing is no missing code, but means that looks do not meet.

    Args:
        attention: What was derived.
    """
    rows: list[tuple[str, str, float, float]] = []
    for recording in attention.events.recordings:
        of = attention.events.table["recording"] == recording
        times = attention.events.table["onset"][of], attention.events.table["offset"][of]
        first, last = attention.events.spans.get(recording, (times[0].min(), times[1].max())) if of.any() else (0, 0)
        for tier in (MUTUAL, SHARED):
            intervals = intervals_of(attention.events, recording, tier)
            starts, ends = np.append(first, intervals.offset), np.append(intervals.onset, last)
            rows += [(recording, tier, a, b) for a, b in zip(starts, ends, strict=True) if b > a]
    recordings, tiers, onset, offset = zip(*rows, strict=True) if rows else ((), (), (), ())
    return attention.events.joined(Events.of(tiers, [NONE] * len(rows), onset, offset, recordings))


def _tiers(
    infant: Intervals, partner: Intervals, rules: JointAttentionRules
) -> Iterator[tuple[str, list[tuple[str, float, float]]]]:
    """Derived tiers: code, onset and offset of each of their events."""
    at_partner, at_infant = infant.coded(rules.infant_at_partner), partner.coded(rules.partner_at_infant)
    mutual = [(on, off) for on, off, _, _ in overlaps(at_partner, at_infant) if off - on >= rules.least_mutual_s]
    yield MUTUAL, [("mutual", on, off) for on, off in mutual]
    shared, leaders = [], []
    for onset, offset, i, j in overlaps(infant, partner):
        target = str(infant.code[i])
        if target == str(partner.code[j]) and target not in rules.no_target:
            shared.append((target, onset, offset))
            ahead = partner.onset[j] - infant.onset[i]
            leader = TOGETHER if abs(ahead) <= rules.together_s else rules.infant if ahead > 0 else rules.partner
            leaders.append((leader, onset, offset))
    yield SHARED, shared
    yield LEADER, leaders
    yield ENGAGEMENT, _engagement(shared, at_partner, rules)


def _engagement(
    shared: Sequence[tuple[str, float, float]], at_partner: Intervals, rules: JointAttentionRules
) -> list[tuple[str, float, float]]:
    """Episodes of attention to one target, with short breaks bridged."""
    episodes: list[tuple[str, float, float]] = []
    for target, onset, offset in shared:
        if episodes and episodes[-1][0] == target and onset - episodes[-1][2] <= rules.bridge_s:
            episodes[-1] = target, episodes[-1][1], offset
        else:
            episodes.append((target, onset, offset))
    states = []
    for _, onset, offset in episodes:
        if offset - onset >= rules.least_engagement_s:
            ended, begun = np.searchsorted(at_partner.offset, onset, "right"), np.searchsorted(at_partner.onset, offset)
            glances = int(begun - ended)
            states.append((COORDINATED if glances >= rules.glances else SUPPORTED, onset, offset))
    return states


def _followed(
    recording: str, follower: str, own: Intervals, other: Intervals, rules: JointAttentionRules
) -> Iterator[GazeFollowing]:
    """Each look of ``other`` at a target that ``own`` does not look at yet."""
    already = at_times(own, other.onset) == other.code
    looks = {target: own.coded(target).onset for target in {str(code) for code in other.code} - rules.no_target}
    for onset, offset, code, there_already in zip(other.onset, other.offset, other.code, already, strict=True):
        target = str(code)
        if target in rules.no_target or there_already:
            continue
        until = min(onset + rules.follow_within_s, offset if rules.still_looking else np.inf)
        following = int(np.searchsorted(looks[target], onset, "right"))
        within = following < len(looks[target]) and looks[target][following] <= until + 1e-9
        latency = float(looks[target][following] - onset) if within else float("nan")
        yield GazeFollowing(recording, follower, target, float(onset), latency)


def _follow_rows(chances: Sequence[GazeFollowing], own: Intervals) -> list[tuple[str, str, str, float, float]]:
    """The looks that follow, as events; a look that follows two is one event."""
    rows = {}
    for chance in chances:
        if chance.latency == chance.latency:
            look = int(np.searchsorted(own.onset, chance.onset + chance.latency - ROUNDING_S))
            rows[look] = (
                chance.recording, f"{chance.follower} follows", chance.target,
                float(own.onset[look]), float(own.offset[look]),
            )  # fmt: skip
    return [rows[look] for look in sorted(rows)]


def _seconds(events: Events, recording: str, *tiers: Intervals) -> float:
    if recording in events.spans:
        start, stop = events.spans[recording]
        return stop - start
    times = np.concatenate([np.concatenate([tier.onset, tier.offset]) for tier in tiers])
    return float(times.max() - times.min()) if len(times) else 0.0
