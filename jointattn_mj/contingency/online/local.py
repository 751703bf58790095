"""Stop rule ``local``: finds the event that is most contingent where it holds, situation by situation.

SAC (eq. 5.2) of an event weighs every situation (r, s) by how often it comes. What is strong but rare then looks weak:
looking back after having followed a gaze says much about the next look at the face, in few of all steps. Here an
event's value is the mean of the local values D(r, s) (see ``contingency.situations``) over those of its situations that
are surest to be contingent, as long as these fill a share of the time. The posterior of D says how much is known. An
event is found when

- its value is above 0, surely enough,
- no rival is probably much higher; one for which there is no evidence hardly counts,
- what is sensed and what is done together foresee its result better than either alone, by more than chance would let
  any of the events do, and
- a module of it would offer something.

Events are tried from the highest value down. Two more conditions keep apart what is the same contingency seen from two
sides. What the modules that bring about a result say of it already does not count again: the result is conditioned on
their use. And of two events that mirror each other, because what brings one result about takes another away, the one
that brings about comes first.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.experience import EventColumns, PastSteps, beyond_last
from jointattn_mj.contingency.online.local_values import (
    Weighing,
    count,
    event_values,
    log_evidence,
    next_first,
    predictive_evidence,
)
from jointattn_mj.options import Checked, Count, NotNegative, Positive, Real, Share


@dataclass(frozen=True)
class LocalConfig(Checked):
    """How stop rule ``local`` ranks events and when it claims the first; how maps follow what is learned later."""

    condition: Literal["joint", "own"] = "joint"
    """What r stands for where p(r' | r, s, a) is asked for. ``own``: the event's own result, as in the text. ``joint``:
    all results together. What lasts, such as a gaze that stays, is then known from r and no longer looks contingent."""
    policy: Literal["both", "actual", "reference"] = "both"
    """Over which actions a situation's contingency is taken. ``actual``: as often as each was done since the last
    module. ``reference``: each equally, in the whole run. ``both``: what is surer to be contingent."""
    smallest_share: Annotated[float, Real("(0, 1]")] = 0.05
    """Share of steps that an event's situations must fill together. 1 ranks by SAC of the whole."""
    concentration: Positive = 2.0
    """Transitions that the prior "s says nothing" is worth."""
    deviations: NotNegative = 3.0
    """Standard deviations of the posterior by which the first value must be above 0."""
    best: Share = 0.9
    """Least probability that no rival is higher by more than ``tolerance``."""
    tolerance: NotNegative = 0.25
    """Share of the first value by which a rival may be higher. Telling nearly equal events apart takes for ever."""
    doubt: NotNegative = 10.0
    """Odds, before anything is known, that a rival is not contingent at all. Its value counts only as far as the
    evidence says that it is. 0: a rival is always believed; events of rare situations then hold others up."""
    false_alarm: Annotated[float, Real("(0, 1]")] = 0.005
    """Accepted chance that an event is ever found in which there is nothing. The evidence, a Bayes factor, must reach
    the number of events divided by this."""
    evidence_overall: Positive = 1.0
    """Bayes factor that all steps together must reach for an event whose result has no module yet. The evidence above
    is that of the steps since the last module; what lasts for some of them must not be taken for contingency."""
    again: Literal["beyond_last", "equally"] = "beyond_last"
    """What is asked of an event whose result has a module already. ``beyond_last``: all steps together must reach the
    full evidence even if it is known what came of the same action the last time that it was done, so that nothing is
    found in what merely lasts. ``equally``: the same as of any other."""
    given_modules: bool = True
    """Whether the result is conditioned on the use of the modules that bring it about: what they say of it already is
    not found again."""
    unserved_first: bool = False
    """Whether an event must wait whose result a module brings about, until every result has a module; in place of
    ``given_modules``."""
    increasing_first: bool = True
    """Whether an event that makes its result rarer waits for events of the same sensor and action that make another
    result more frequent, and is no rival to any."""
    waits_deviations: NotNegative = 1.0
    """With ``increasing_first``: standard deviations by which the value of an event must be above 0 to be waited for.
    With two spots, looking at one finds what looking at the other misses, so that chance decides which of the two a
    result seems to become; at 0 an event may wait for ever for one that is nothing."""
    needs_offers: bool = True
    """Whether an event is passed over as long as its module would offer nothing."""
    hindsight: bool = True
    """Whether a module counts as used (S_Pi) wherever the robot did what its present map offers, even before it was
    made. In the text it counts as used where it drove."""
    maps: Literal["follow", "frozen"] = "follow"
    """Whether maps are read anew at each look, or stay as they were made."""
    offer_gain: Annotated[float, Real("[0, 1)")] = 0.25
    """Share of the largest gain of a map that each offer must exceed (see ``followed_maps``)."""
    offer_deviations: NotNegative = 1.0
    """Standard deviations by which the gain of an offer must be above 0."""
    when_served: Literal["go_on", "stop"] = "go_on"
    """What happens when every result has a module: search on, or stop."""
    first_look: Count = 150
    """Steps before the first look."""
    look_every: Count = 40
    """Fewest steps from one look to the next."""
    look_again: Positive = 0.04
    """Share of further steps after which to look again, if that is more."""


def search(
    steps: PastSteps,
    events: Sequence[Event],
    served: Sequence[Event],
    known: np.ndarray,
    since: int,
    config: LocalConfig,
    offers: Callable[[Event], bool],
) -> tuple[int, np.ndarray]:
    """Look for the most contingent event.

    Args:
        steps: All steps so far.
        events: The E events that are ranked.
        served: Events that have a module, in the order of these.
        known: (E,) whether each event was found before, with or without a module; it is not found again.
        since: Step at which the last module was made.
        config: Settings.
        offers: Whether the module of an event would offer anything.

    Returns:
        Number of the event that is found, or NOTHING; and every event's value (E,), nats.
    """
    columns = steps.columns(events, config.condition == "joint", _alike(steps, served, config))
    lead, hoped = np.zeros((2, len(events), 2))
    rise = np.zeros(len(events))
    event_values(columns, since, _weighing(config), lead, hoped, rise)
    values, sure = lead[:, 0].copy(), lead[:, 0] > config.deviations * lead[:, 1]
    evidence = np.full(len(events), np.nan)
    waited_for = (rise > 0) & (values > config.waits_deviations * lead[:, 1])
    ranked = _candidates(events, served, known, rise > 0, waited_for, config)
    ranked = ranked[np.argsort(-values[ranked], kind="stable")]
    if config.needs_offers:
        while len(ranked) and not offers(events[ranked[0]]):
            ranked = ranked[1:]
    limits = float(config.tolerance), float(config.doubt), float(config.best)
    tried = ranked[sure[ranked]]
    at = next_first(columns, tried, 0, ranked, lead, hoped, evidence, limits)
    while at < len(tried):
        number = int(tried[at])
        is_offered = number == ranked[0] or not config.needs_offers or offers(events[number])
        if is_offered and _is_evident(steps, columns, number, events, served, since, config):
            return number, values
        at = next_first(columns, tried, at + 1, ranked, lead, hoped, evidence, limits)
    return NOTHING, values


def _weighing(config: LocalConfig) -> Weighing:
    """The settings of values, for compiled code."""
    return Weighing(
        concentration=float(config.concentration),
        smallest_share=float(config.smallest_share),
        deviations=float(config.deviations),
        actual=config.policy != "reference",
        reference=config.policy != "actual",
    )


def _alike(steps: PastSteps, served: Sequence[Event], config: LocalConfig) -> Mapping[int, Sequence[int]]:
    """Sensors of the modules that bring about each result, on whose use it is conditioned."""
    alike: dict[int, list[int]] = {}
    for number, event in enumerate(served if config.given_modules else ()):
        alike.setdefault(event.result, []).append(steps.of_world + number)
    return alike


def _is_evident(
    steps: PastSteps,
    columns: EventColumns,
    number: int,
    events: Sequence[Event],
    served: Sequence[Event],
    since: int,
    config: LocalConfig,
) -> bool:
    """Whether the evidence says that an event (its number) is contingent, over all steps and since the last module."""
    event, series = events[number], columns.of(number)
    begin, enough = steps.begin(event), np.log(len(events) / config.false_alarm)
    least, overall = np.log(config.evidence_overall), series
    if config.again == "beyond_last" and event.result in {earlier.result for earlier in served}:
        least, overall = enough, beyond_last(series)
    table = np.zeros(overall.sizes)
    count(*overall.columns, (begin, steps.n_steps), table)
    if log_evidence(table) < least:
        return False
    return bool(predictive_evidence(*series.columns, max(since, begin), series.sizes) >= enough)


def _candidates(
    events: Sequence[Event],
    served: Sequence[Event],
    known: np.ndarray,
    rises: np.ndarray,
    waited_for: np.ndarray,
    config: LocalConfig,
) -> np.ndarray:
    """Numbers of the events that may be found, and are rivals of each other.

    Args:
        events: The E events that are ranked.
        served: Those that have a module.
        known: (E,) whether each was found before.
        rises: (E,) whether each makes its result more frequent.
        waited_for: (E,) whether events that make their results rarer wait for it.
        config: Settings.
    """
    done = {event.result for event in served}
    all_served = done >= {event.result for event in events}
    if all_served and config.when_served == "stop":
        return np.zeros(0, np.int64)
    waits_for = {event[:2] for event, up in zip(events, waited_for & ~known, strict=True) if up}
    return np.array([
        number
        for number, (event, up, old) in enumerate(zip(events, rises, known, strict=True))
        if not old
        and not (config.unserved_first and not all_served and event.result in done)
        and not (config.increasing_first and not up and event[:2] in waits_for)
    ], np.int64)  # fmt: skip
