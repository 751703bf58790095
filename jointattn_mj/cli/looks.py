"""``jointattn looks``: where a robot and its caregiver looked, for coding programs."""

from typing import Annotated

from jointattn_mj.options import FLAT
from jointattn_mj.recordings.looks import LooksOptions, export_looks

LESS = "a shorter run"


def looks(options: Annotated[LooksOptions, FLAT]) -> None:
    """Write the looks of a robot and its caregiver as event files of ELAN, BORIS or Datavyu.

    Takes the folder of a session, a development run or perceive. Leaves in --out: a file for each recording, which
    ELAN and Datavyu open, or one table. `jointattn recordings` shows them on one page with those of infants.
    """
    for path in export_looks(options):
        print(path)
