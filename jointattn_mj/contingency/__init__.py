"""Contingency: how much what one senses and does says about what comes next (chapters 4 and 5)."""

import warnings
from importlib import import_module
from typing import Any

from jointattn_mj.contingency.discovery import Finding, discover
from jointattn_mj.contingency.granger import linear_granger
from jointattn_mj.contingency.lagged import Timing
from jointattn_mj.contingency.lead import Lead, LeadOptions
from jointattn_mj.contingency.local import LocalContingency, local_contingency
from jointattn_mj.contingency.measures import (
    combined_transfer_entropy,
    conditional_mutual_information,
    contingent_saliency,
    mutual_information,
    pointwise_combined_transfer_entropy,
    pointwise_conditional_mutual_information,
    pointwise_mutual_information,
    pointwise_state_action_contingency,
    pointwise_transfer_entropy,
    state_action_contingency,
    transfer_entropy,
)
from jointattn_mj.contingency.scan import LagScan, scan_lags
from jointattn_mj.contingency.series import Stacked, joint, recode
from jointattn_mj.contingency.significance import (
    Significance,
    TestOptions,
    adjust,
    assess,
    benjamini_hochberg,
    holm,
)
from jointattn_mj.contingency.situations import PosteriorOptions, Situations, situation_contingency

__all__ = [
    "Finding",
    "LagScan",
    "Lead",
    "LeadOptions",
    "LocalContingency",
    "PosteriorOptions",
    "Significance",
    "Situations",
    "Stacked",
    "TestOptions",
    "Timing",
    "adjust",
    "assess",
    "benjamini_hochberg",
    "combined_transfer_entropy",
    "conditional_mutual_information",
    "contingent_saliency",
    "discover",
    "holm",
    "joint",
    "linear_granger",
    "local_contingency",
    "mutual_information",
    "pointwise_combined_transfer_entropy",
    "pointwise_conditional_mutual_information",
    "pointwise_mutual_information",
    "pointwise_state_action_contingency",
    "pointwise_transfer_entropy",
    "recode",
    "scan_lags",
    "situation_contingency",
    "state_action_contingency",
    "transfer_entropy",
]


def __getattr__(name: str) -> Any:
    """Names that have moved up to ``jointattn_mj``, for one version more; nothing here needs them."""
    if name in ("Recordings", "read_recordings"):
        warnings.warn(f"contingency.{name} is now called jointattn_mj.{name}", DeprecationWarning, stacklevel=2)
        return getattr(import_module("jointattn_mj.recordings.reader"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
