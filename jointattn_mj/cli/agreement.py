"""``jointattn agreement``: how far two coders agree."""

from typing import Annotated

from jointattn_mj.options import FLAT
from jointattn_mj.recordings.coders import CoderOptions, run_agreement

LESS = "a longer step, or a shorter file"


def agreement(options: Annotated[CoderOptions, FLAT]) -> None:
    """Compare two coders of the same recordings: Cohen's kappa by units of time, with tolerance.

    Prints kappa of each tier with its interval, kappa of each code, and what was taken for what. Leaves with --out:
    agreement.csv, agreement.json.
    """
    print(run_agreement(options).text())
