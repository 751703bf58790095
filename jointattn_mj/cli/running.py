"""What commands share when they run."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol, TypeVar

from jointattn_mj.io.progress import Progress


def one_thread() -> None:
    """Keep OpenCV to one thread: images are small, and handing them round threads costs more than it gains.

    It need not be imported for that, and is not by all commands.
    """
    if "cv2" in sys.modules:
        sys.modules["cv2"].setNumThreads(1)
    else:
        os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")


@contextmanager
def going_on_from(out: Path, started: str) -> Iterator[None]:
    """When the block is interrupted, say on stderr how to go on, and let KeyboardInterrupt pass.

    Args:
        out: Folder of the run.
        started: What would have begun, such as "the session".
    """
    try:
        yield
    except KeyboardInterrupt:
        if (out / "checkpoint.bin").exists():
            print(f"jointattn: stopped; the same command with --resume goes on from {out}", file=sys.stderr)
        else:
            print(f"jointattn: stopped before {started} began; nothing was written", file=sys.stderr)
        raise


class _Draws(Protocol):
    @property
    def draws(self) -> int: ...


class _Readable(Protocol):
    def text(self) -> str: ...


Options = TypeVar("Options", bound=_Draws)


def print_result(run: Callable[[Options, Callable[[int], object]], _Readable], options: Options) -> None:
    """Print what an analysis finds, with progress on stderr.

    Args:
        run: The analysis; it is given the options, and what to call with the number of surrogates that it has drawn.
        options: Its options, with the number of ``draws``.
    """
    with Progress("reading", options.draws, "surrogates") as shown:
        result = run(options, lambda done: shown.add(done, "drawing"))
    print(result.text())
