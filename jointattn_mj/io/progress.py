"""Progress of a command on stderr: a bar on a terminal, elsewhere a line now and then."""

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import TextIO

from tqdm import tqdm

from jointattn_mj.io.terminal import Unbroken

FIRST_S, LINE_S = 10.0, 30.0
"""Seconds before the first line, and between two, where there is no terminal."""
QUIET = "JOINTATTN_QUIET"
"""Environment variable: 1 suppresses these lines."""
COMPILING = "compiling, once on this machine, some 20 s"
KNOWN_FROM = 0.02
"""Share of the work after which the time left is said."""


class Progress:
    """Shows progress while the block runs: ``with Progress("playing", 10, "episodes") as shown``.

    Args:
        doing: What is done now, such as "playing".
        total: How much there is to do; None where that is not known.
        unit: Unit of ``total``, such as "episodes".
        digits: Digits after the point of what is done and of ``total``.
        stream: Where to write; stderr by default.

    Attributes:
        live: Whether ``stream`` is a terminal.
    """

    def __init__(
        self, doing: str, total: float | None = None, unit: str = "", digits: int = 0, stream: TextIO | None = None
    ):
        self._out = Unbroken(stream or sys.stderr)
        self.live = self._out.isatty()
        self._doing, self._words, self._done, self._total = doing, "", 0.0, total
        self._unit, self._digits = unit, digits
        self._compiling_s = 0.0
        self._bar: tqdm | None = None
        self._ended = threading.Event()
        self._stack = ExitStack()

    def doing(self, what: str) -> None:
        """Name what is done now."""
        self._doing = what
        self._show()

    def to(self, done: float, words: str = "", total: float | None = None) -> None:
        """Show how much is done.

        Args:
            done: Amount done so far, in the unit.
            words: What else to say.
            total: A new total; None keeps the last one.
        """
        self._done, self._words = done, words
        self._total = self._total if total is None else total
        self._show()

    def add(self, more: float = 1, doing: str | None = None) -> None:
        """Add ``more`` to what is done; ``doing`` names what is done now."""
        self._done += more
        self._doing = doing or self._doing
        self._show()

    def say(self, line: str) -> None:
        """Print a line above the bar; without a bar nothing is printed."""
        if self._bar is not None:
            self._bar.write(line, file=self._out)

    def line(self, seconds: float) -> str:
        """The line of a log after so many seconds."""
        done, ended = f"{self._done:,.{self._digits}f}", self._total is not None and self._done >= self._total
        parts = ["writing results" if ended else self._doing]
        if self._total:
            share = min(self._done / self._total, 1)
            parts.append(f"{done} of {self._total:,.{self._digits}f} {self._unit}".rstrip())
            if KNOWN_FROM <= share < 1:
                parts.append(f"{duration((seconds - self._compiling_s) * (1 / share - 1))} left")
        elif self._done:
            parts.append(f"{done} {self._unit}".rstrip())
        return ", ".join([*parts, *([self._words] if self._words else []), f"{duration(seconds)} so far"])

    def __enter__(self) -> "Progress":
        """Start the bar, or the thread that prints lines."""
        self._stack.enter_context(told_of_compiling(self._compiling))
        if self.live:
            amount = f"{{n:,.{self._digits}f}}"
            total = f"/{{total:,.{self._digits}f}}" if self._total else ""
            self._bar = tqdm(
                total=self._total,
                desc=self._doing,
                bar_format=f"{{l_bar}}{{bar}}| {amount}{total} {self._unit} [{{elapsed}}<{{remaining}}{{postfix}}]",
                file=self._out,
            )
        elif not os.environ.get(QUIET):
            threading.Thread(target=self._tell, daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Stop; the bar stays as it was at the end."""
        self._ended.set()
        self._stack.close()
        if self._bar is not None:
            self._bar.close()

    def _show(self) -> None:
        if self._bar is None:
            return
        self._bar.total = self._total
        self._bar.set_description_str(self._doing, refresh=False)
        self._bar.set_postfix_str(self._words, refresh=False)
        self._bar.update(self._done - self._bar.n)

    def _compiling(self) -> Callable[[], None]:
        before, self._doing = self._doing, COMPILING
        began = time.monotonic()
        if self._bar is not None:
            self._bar.set_description_str(COMPILING)

        def over() -> None:
            self._compiling_s += time.monotonic() - began
            if self._doing == COMPILING:
                self._doing = before
                self._show()

        return over

    def _tell(self) -> None:
        """Print lines now and then; runs in a thread of its own."""
        started, pause = time.monotonic(), FIRST_S
        while not self._ended.wait(pause):
            pause = LINE_S
            print(self.line(time.monotonic() - started), file=self._out, flush=True)


@contextmanager
def told_of_compiling(begin: Callable[[], Callable[[], None]]) -> Iterator[None]:
    """Call ``begin`` when numba begins to compile in the block, and what it returns when compiling is over.

    Functions from numba's cache are not compiled. Nothing is done where numba has not been imported yet.
    """
    if "numba" not in sys.modules:
        yield
        return
    from numba.core import event

    class Listener(event.Listener):
        depth = 0
        over: Callable[[], None] = staticmethod(lambda: None)

        def on_start(self, event: event.Event) -> None:
            self.depth += 1
            if self.depth == 1:
                self.over = begin()

        def on_end(self, event: event.Event) -> None:
            self.depth -= 1
            if self.depth == 0:
                self.over()

    with event.install_listener("numba:compile", Listener()):
        yield


def count(number: int, noun: str) -> str:
    """A number with its noun: ``1 trial``, ``2 trials``."""
    return f"{number} {noun}{'s' * (number != 1)}"


def duration(seconds: float) -> str:
    """A duration to read: ``7 s``, ``3 min 20 s``, ``2 h 5 min``, ``9 days``."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    if whole < 2 * 86400:
        return f"{whole // 3600} h {whole % 3600 // 60} min"
    return f"{whole // 86400:,} days" if whole < 2 * 365 * 86400 else f"{whole // (365 * 86400):,} years"
