"""The program ``jointattn``. What takes long to import waits until a stop signal no longer ends in a traceback."""

import gc
import os
import sys
from collections.abc import Sequence

from jointattn_mj.cli.images import needs_images
from jointattn_mj.io.terminal import stopped_at_once


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command.

    Exits with 2 where what was asked for cannot be done, 1 where it failed, 130 when interrupted. Errors are one line
    on stderr.

    Args:
        arguments: Words of the command line, without the program's name; by default those of the process, which then
            belongs to the command: a stop signal before or after it ends the process at once.
    """
    if arguments is None:
        stopped_at_once()
        gc.disable()  # until all is imported: .4 s of a session's start
        os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")  # pyarrow's own keeps 20 to 40 MiB
        if not needs_images(sys.argv[1:]):
            os.environ["MUJOCO_GL"] = "disable"
    from jointattn_mj.cli.execution import execute

    try:
        code = execute(sys.argv[1:], _collect_again) if arguments is None else execute(arguments)
    finally:
        if arguments is None:
            gc.enable()  # after a wrong option, too
    if code:
        sys.exit(code)


def _collect_again() -> None:
    """Collect garbage from now on, but never look through what was imported, which stays."""
    gc.freeze()
    gc.enable()


if __name__ == "__main__":
    main()
