"""Ctrl-C, SIGTERM and SIGHUP, put off until a frame is over: what is saved then is never half of one."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from jointattn_mj.io.terminal import STOPS


class Interrupts:
    """Remembers that somebody asked to stop. Asked twice, it stops at once."""

    def __init__(self) -> None:
        self.requested = False

    def __call__(self, signum: int, frame: FrameType | None) -> None:
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True


@contextmanager
def deferred() -> Iterator[Interrupts]:
    """While the block runs, stop signals only set ``requested``; outside the main thread nothing is changed."""
    interrupts = Interrupts()
    if threading.current_thread() is not threading.main_thread():
        yield interrupts
        return
    kept = {number: signal.getsignal(number) for number in STOPS}
    kept = {number: handler for number, handler in kept.items() if handler is not signal.SIG_IGN}  # by nohup, say
    for number in kept:
        signal.signal(number, interrupts)
    try:
        yield interrupts
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
