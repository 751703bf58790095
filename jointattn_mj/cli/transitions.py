"""``jointattn transitions``: what follows what in coded interaction."""

from typing import Annotated

from jointattn_mj.options import FLAT
from jointattn_mj.recordings.transitions import TransitionOptions, run_transitions

LESS = "fewer surrogates, a longer step, or a shorter file"


def transitions(options: Annotated[TransitionOptions, FLAT]) -> None:
    """Count what follows what in coded interaction: lag-sequential analysis.

    Prints joint and conditional frequencies, adjusted residuals, odds ratios with intervals and Yule's Q, p by circular
    shifts, and of several recordings the mean of Yule's Q. Leaves with --out: transitions.csv, transitions.json.
    """
    print(run_transitions(options).text())
