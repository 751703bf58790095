"""What commands share when they run."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol, TypeVar

from jointattn_mj.errors import CheckpointError, JointAttnError
from jointattn_mj.io.progress import Progress


def one_thread() -> None:
    """Keep OpenCV to one thread: images are small, and handing them round threads costs more than it gains."""
    import cv2

    cv2.setNumThreads(1)


@contextmanager
def going_on_from(out: Path, started: str, resumed: bool) -> Iterator[None]:
    """When the block is interrupted, say on stderr how to go on, and let KeyboardInterrupt pass.

    Args:
        out: Folder of the run.
        started: What would have begun, such as "the session".
        resumed: Whether it goes on from a checkpoint.

    Raises:
        CheckpointError: As ``of_a_checkpoint``.
    """
    try:
        with of_a_checkpoint(out, resumed):
            yield
    except KeyboardInterrupt:
        if (out / "checkpoint.bin").exists():
            print(f"jointattn: stopped; the same command with --resume goes on from {out}", file=sys.stderr)
        else:
            print(f"jointattn: stopped before {started} began; nothing was written", file=sys.stderr)
        raise


@contextmanager
def of_a_checkpoint(out: Path, resumed: bool) -> Iterator[None]:
    """Name the checkpoint in ``out`` where a run that was ``resumed`` breaks in a way that no code has foreseen.

    Not every number in a checkpoint is checked: one that was changed by hand can break a run much later.

    Raises:
        CheckpointError: The run has broken so.
    """
    try:
        yield
    except JointAttnError:
        raise
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        if not resumed:
            raise
        said = f"{type(error).__name__}: {' '.join(str(error).split())[:200]}".removesuffix(": ")
        raise CheckpointError(
            f"{out / 'checkpoint.bin'} does not fit: the run that it holds cannot go on ({said}); begin anew in "
            "another folder, or report this as a fault of jointattn if nobody has changed the file"
        ) from error


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
