"""``jointattn discover``: which events in a recording are contingent."""

from typing import Annotated

from jointattn_mj.cli.running import print_result
from jointattn_mj.options import FLAT
from jointattn_mj.recordings.discover import DiscoverOptions, run_discover

LESS = "fewer surrogates or events, or a shorter file"


def discover(options: Annotated[DiscoverOptions, FLAT]) -> None:
    """Find the contingent events (sensor, action) -> result of a recording, and the values that carry them.

    Prints a ranking of all events, with p-values corrected for their number. Leaves with --out: events.csv,
    events.json.
    """
    print_result(run_discover, options)
