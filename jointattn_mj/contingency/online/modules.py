"""Contingency reproduction modules (section 5.2.2): maps from observables to commands, made of contingent events."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.options import Checked, NotNegative

OFFERS_NOTHING = -1


@dataclass(frozen=True)
class ReproductionConfig(Checked):
    """How the map of a module is made from the counts of its event."""

    reliability_gap: NotNegative = 0.5
    """Z_theta (rule 4 of section 5.2.2), least difference of the two highest z-scores."""
    mean_over: Literal["positive", "not_negative"] = "positive"
    """Saliencies of which rule 1 takes the mean. With "positive or null", as the text has it, the many pairs that never
    occurred pull the mean to 0, and chance passes rule 2."""


@dataclass(frozen=True)
class Module:
    """A contingency reproduction module CM(i, j, k): its map from observables to commands."""

    event: Event
    command: np.ndarray
    """(R, S) command (a*, eq. 5.4); -1 where the module offers none."""
    reliability: np.ndarray
    """(R, S) reliability Z (eq. 5.5); 0 where the module offers no command."""
    expected: np.ndarray
    """(R, S) expected result (r*, eq. 5.4); -1 where the module offers no command."""
    saliency: np.ndarray
    """(R, S, R', A) contingent saliency e (eq. 5.3), nats, from which all others follow."""

    def __repr__(self) -> str:
        offered = int((self.command != OFFERS_NOTHING).sum())
        return f"Module({self.event}, a command under {offered} of {self.command.size} pairs of observables)"


def contingent_saliency(table: np.ndarray) -> np.ndarray:
    """Contingent saliency e(r', a; r, s) of eq. 5.3.

    An action that was never done, or a result that never followed, contributes 0 to the first or to the second term.

    Args:
        table: (R, S, A, R') counts.

    Returns:
        (R, S, R', A) nats; NaN under pairs (r, s) that never occurred.
    """
    counts = np.asarray(table, float)
    rs, ra = counts.sum(axis=(2, 3), keepdims=True), counts.sum(axis=(1, 3), keepdims=True)
    rsa, r = counts.sum(axis=3, keepdims=True), counts.sum(axis=(1, 2, 3), keepdims=True)
    next_rs, next_ra = counts.sum(axis=2, keepdims=True), counts.sum(axis=1, keepdims=True)
    next_r = counts.sum(axis=(1, 2), keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        together = np.where(counts > 0, counts / rs * np.log(counts * rs / (rsa * next_rs)), 0.0)
        alone = np.where(next_ra > 0, next_ra / r * np.log(next_ra * r / (ra * next_r)), 0.0)
    saliency = np.where(rs > 0, together - alone, np.nan).swapaxes(2, 3)
    return np.ascontiguousarray(saliency)  # a copy is restored only if it lies in memory row by row


def make_module(event: Event, table: np.ndarray, config: ReproductionConfig) -> Module:
    """The module of an event, by eq. 5.4, eq. 5.5 and the four rules below it.

    Args:
        event: The contingent event.
        table: (R, S, A, R') its counts.
        config: Thresholds of the rules.
    """
    saliency = contingent_saliency(table)
    results, sensors, _, actions = saliency.shape
    flat = np.nan_to_num(saliency.reshape(results, sensors, -1))
    visible = ~np.isnan(saliency[..., 0, 0])
    counted = (flat > 0 if config.mean_over == "positive" else flat >= 0) & visible[..., None]
    average = flat[counted].mean() if counted.any() else np.inf
    best = flat.argmax(axis=-1)
    second, highest = np.sort(flat, axis=-1)[..., -2:].transpose(2, 0, 1)
    mean, spread = flat.mean(axis=-1), flat.std(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        reliability = (highest - mean) / spread
        offered = visible & (highest > average) & ((highest - second) / spread > config.reliability_gap)
    return Module(
        event=event,
        command=np.where(offered, best % actions, OFFERS_NOTHING),
        reliability=np.where(offered, reliability, 0.0),
        expected=np.where(offered, best // actions, OFFERS_NOTHING),
        saliency=saliency,
    )
