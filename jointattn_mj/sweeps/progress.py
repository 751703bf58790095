"""Progress of a run: on a terminal one line that changes, elsewhere a line now and then."""

import sys
import time
from typing import Any, TextIO

from jointattn_mj.io.progress import LINE_S, count, duration
from jointattn_mj.io.terminal import Unbroken
from jointattn_mj.sweeps.run import SweepWatcher, Tally

SCREEN_S = 0.1
"""Seconds between two changes of the line on a terminal."""
MOST_FAILURES = 20
"""Number of failed trials that are listed one by one."""


class SweepProgress(SweepWatcher):
    """Writes progress to a stream, stderr by default."""

    def __init__(self, stream: TextIO | None = None):
        self.stream: Any = Unbroken(stream or sys.stderr)
        self.live = self.stream.isatty()
        self._width = 0
        self._started = self._told = time.monotonic()

    def begin(self, tally: Tally, slots: int) -> None:
        self._started = time.monotonic()
        self._line(f"{count(tally.todo, 'trial')} to compute, {tally.stored} stored already")
        self._told = time.monotonic()

    def tick(self, tally: Tally, slots: int) -> None:
        now = time.monotonic()
        if now - self._told < (SCREEN_S if self.live else LINE_S):
            return
        self._told = now
        text = self.state(tally, slots, now - self._started)
        if self.live:
            print("\r" + text.ljust(self._width), end="", file=self.stream, flush=True)
            self._width = len(text)
        else:
            self._line(text)

    def end(self, tally: Tally) -> None:
        if self.live and self._width:
            print("\r" + " " * self._width + "\r", end="", file=self.stream)
        self._line(self.state(tally, None, time.monotonic() - self._started))
        for task, error, alone in tally.failed[:MOST_FAILURES]:
            self._line(f"  {task}: {' '.join(error.split())}\n    alone: {alone}")
        if len(tally.failed) > MOST_FAILURES:
            self._line(f"  and {len(tally.failed) - MOST_FAILURES} more; the folder failed/ has the traceback of each")

    def state(self, tally: Tally, slots: int | None, seconds: float) -> str:
        """The progress in one line.

        Args:
            tally: Trials done, running and failed.
            slots: Trials that can run at once; None when the run is over.
            seconds: Time since the run began.
        """
        ended = tally.done + len(tally.failed)
        parts = [f"{ended}/{tally.todo} trials"]
        if slots is not None:
            parts.append(f"{tally.running} running" if slots else "no worker yet")
        parts.append(f"{len(tally.failed)} failed")
        if tally.deaths:
            parts.append(f"{count(tally.deaths, 'death')} of workers")
        if ended and seconds > 0:
            parts.append(rate(ended / seconds))
        work = tally.work_left_s()
        if slots and work is not None:
            parts.append(f"{duration(work / slots)} left")
        if slots is None:
            parts.append(f"in {duration(seconds)}")
        return ", ".join(parts)

    def _line(self, text: str) -> None:
        print(text, file=self.stream, flush=True)


def rate(per_second: float) -> str:
    """Trials per second, minute or hour: the first unit in which at least one ends."""
    for unit, seconds in (("s", 1), ("min", 60)):
        if per_second * seconds >= 1:
            return f"{per_second * seconds:.3g}/{unit}"
    return f"{per_second * 3600:.2g}/h"
