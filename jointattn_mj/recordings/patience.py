"""Refuses a computation of hours or days that somebody has asked for by a slip, as soon as its pace is known."""

import time
from collections.abc import Callable

from jointattn_mj.errors import ConfigError
from jointattn_mj.io.progress import duration

LONG_S = 1800.0
"""What would take longer is not gone on with unasked."""
KNOWN_AFTER_S = 1.0
"""Seconds of drawing after which the pace is taken as known."""


def patient(
    progress: Callable[[int], object], total: int, yes: bool, clock: Callable[[], float] = time.monotonic
) -> Callable[[int], object]:
    """``progress`` that also sees how long all ``total`` draws will take; ``yes``: however long that is.

    The first report says when drawing has begun: what was compiled before does not count. A report of more than ever
    before is of draws that were not needed, such as shifts beyond all that there are, and the pace is taken after it.

    Args:
        progress: Is told of each draw.
        total: Number of all draws.
        yes: Go on however long it takes.
        clock: Gives seconds.

    Raises:
        ConfigError: From the progress call, where the rest would take longer than LONG_S.
    """
    if yes:
        return progress
    begun: float | None = None
    first = done = most = 0
    known = False

    def watch(more: int) -> None:
        nonlocal begun, first, done, most, known
        progress(more)
        done += more
        if begun is None or more > most:
            begun, first, most = clock(), done, more
            return
        spent = clock() - begun
        if known or spent < KNOWN_AFTER_S:
            return
        known = True
        left = (total - done) * spent / (done - first)
        if left > LONG_S:
            raise ConfigError(
                f"{total:,} surrogates and resamples would take about {duration(left)} on this machine; ask for fewer, "
                "or say `yes=True` to wait"
            )

    return watch
