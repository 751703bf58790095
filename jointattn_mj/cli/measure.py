"""``jointattn measure``: what one recorded variable says about another."""

from typing import Annotated

from jointattn_mj.cli.running import print_result
from jointattn_mj.options import FLAT
from jointattn_mj.recordings.measure import MeasureOptions, run_measure

LESS = "fewer surrogates, or a shorter file"


def measure(options: Annotated[MeasureOptions, FLAT]) -> None:
    """Measure how much one recorded variable says about the next value of another.

    Prints transfer entropy, and with --condition combined transfer entropy (T^C, eq. 4.3) and state-action contingency
    (SAC, eq. 5.2), or the --measures that are named, with bias corrections, intervals and p-values. Leaves with --out:
    measures.csv, measures.json.
    """
    print_result(run_measure, options)
