"""Standard streams that may be closed or full, and signals that end a command; neither ends in a traceback."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

TYPE_CHECKING = False  # as in typing, whose import takes long enough to be interrupted in
if TYPE_CHECKING:
    from typing import Any, TextIO

INTERRUPTED = 130
AGAIN_S = 0.05
"""After how long an interruption that Python discarded is repeated."""
STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Ctrl-C, the first signal that schedulers send, and the end of the terminal."""


class Unbroken:
    """A text stream that never raises: what is written after the first failure is lost.

    Args:
        stream: Where to write.

    Attributes:
        trouble: The first failure; None while there is none.
    """

    def __init__(self, stream: TextIO):
        self._stream = stream
        self.trouble: OSError | ValueError | None = None

    def write(self, text: str) -> int:
        """Write if possible; return the length of ``text``."""
        self._attempt("write", text)
        return len(text)

    def flush(self) -> None:
        """Flush the stream, if possible."""
        self._attempt("flush")

    def isatty(self) -> bool:
        """Whether the stream is a terminal."""
        return self._attempt("isatty") or False

    def _attempt(self, method: str, *arguments: str) -> Any:
        if self.trouble is not None:
            return None
        try:
            return getattr(self._stream, method)(*arguments)
        except (OSError, ValueError) as error:  # ValueError: it is closed
            self.trouble = error
            return None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def unbroken_streams() -> Iterator[Unbroken]:
    """While the block runs, printing cannot fail; yields standard output, whose ``trouble`` is known at the end.

    Closed streams are opened on the null device, so that no file takes their number. Characters that a stream's
    encoding does not have are written as escapes.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    kept = sys.stdout, sys.stderr
    streams = [os.fdopen(os.open(os.devnull, os.O_WRONLY), "w") if stream is None else stream for stream in kept]
    for stream in streams:
        with suppress(AttributeError, OSError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    output = sys.stdout = Unbroken(streams[0])
    errors = sys.stderr = Unbroken(streams[1])
    try:
        yield output
    finally:
        for wrapped, stream in zip((output, errors), streams, strict=True):
            wrapped.flush()
            if wrapped.trouble is not None:
                _forget(stream)
        sys.stdout, sys.stderr = kept


def _forget(stream: TextIO) -> None:
    """Discard what is still buffered: Python would complain of it when it exits."""
    with suppress(OSError, ValueError, AttributeError):
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, stream.fileno())
        os.close(nothing)


@contextmanager
def stopped_like_ctrl_c() -> Iterator[None]:
    """While the block runs, SIGTERM and SIGHUP raise KeyboardInterrupt as Ctrl-C does; ignored signals stay ignored.

    So does an error after such a signal: libraries make errors of their own of an interruption while they are imported.
    An interruption that Python discards, as in a finaliser or while a module is locked, comes again a moment later.
    After an interruption each signal ends the process at once with 130, so that a second one cannot break off an
    orderly end.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    kept = _heeded()
    interrupted: int | None = None
    report = sys.unraisablehook

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal interrupted
        interrupted = number
        raise KeyboardInterrupt

    def discarded(unraisable: Any) -> None:
        if interrupted and issubclass(unraisable.exc_type, KeyboardInterrupt):
            threading.Timer(AGAIN_S, os.kill, (os.getpid(), interrupted)).start()
        else:
            report(unraisable)

    _handle(kept, stop)
    sys.unraisablehook = discarded
    ended = False
    try:
        yield
    except BaseException as error:
        ended = bool(interrupted) or isinstance(error, KeyboardInterrupt)
        if interrupted and not isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt from error
        raise
    finally:
        sys.unraisablehook = report
        for number, handler in kept.items():
            signal.signal(number, _end_at_once if ended else handler)
        if ended:
            eval("None")  # if the last code from text was interrupted, as in a dataclass, python -m ends by the signal


def stopped_at_once() -> None:
    """From now on a stop signal ends this process at once with 130, and none does when Python clears up at its end."""
    if threading.current_thread() is threading.main_thread():
        heeded = _heeded()
        _handle(heeded, _end_at_once)
        atexit.register(_handle, heeded, signal.SIG_IGN)


def _heeded() -> dict[signal.Signals, Any]:
    """The stop signals that are not ignored, as by nohup, and what handles them."""
    handlers = {number: signal.getsignal(number) for number in STOPS}
    return {number: handler for number, handler in handlers.items() if handler is not signal.SIG_IGN}


def _handle(numbers: Iterable[signal.Signals], handler: Any) -> None:
    for number in numbers:
        signal.signal(number, handler)


def _end_at_once(number: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)
