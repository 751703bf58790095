"""A command line carried out: exit codes, and errors on one line. Commands stand in ``commands``."""

import os
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from jointattn_mj import __version__
from jointattn_mj.cli.argument_names import with_options
from jointattn_mj.cli.commands import COMMANDS, overview
from jointattn_mj.errors import (
    CheckpointError,
    ConfigError,
    ExtraError,
    FootageError,
    JointAttnError,
    OutputError,
    SeriesError,
)
from jointattn_mj.io.terminal import INTERRUPTED, stopped_like_ctrl_c, unbroken_streams

BAD_USAGE, FAILED = 2, 1
TRACEBACK = "JOINTATTN_TRACEBACK"
"""Environment variable: 1 shows the traceback of an unforeseen error."""


def execute(arguments: Sequence[str], begin: Callable[[], object] = lambda: None) -> int:
    """Run a command; returns its exit code.

    Args:
        arguments: Words of the command line, without the program's name.
        begin: Is called when all that the command needs has been imported, before it runs.
    """
    with unbroken_streams() as output:
        code = _run(arguments, begin)
        output.flush()
        trouble = output.trouble
        if trouble is not None and not isinstance(trouble, BrokenPipeError):  # who reads no further needs no message
            _say(f"cannot write to the standard output: {getattr(trouble, 'strerror', None) or trouble}")
            code = code or FAILED
    return code


def _run(arguments: Sequence[str], begin: Callable[[], object]) -> int:
    """The exit code of a command line."""
    try:
        with stopped_like_ctrl_c():
            with _old_names_on_one_line():
                command = _command_of(arguments)
            begin()
            with _old_names_on_one_line():
                command()
        return 0
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else FAILED if stop.code else 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except (ConfigError, OutputError, CheckpointError, SeriesError, FootageError, ExtraError) as error:
        _say(str(error))
        return BAD_USAGE
    except JointAttnError as error:
        _say(str(error))
    except MemoryError as error:
        _say(f"this machine has too little memory{f' ({error})' if str(error) else ''}; ask for {_less(arguments[0])}")
    except OSError as error:
        _say(f"{error.filename}: {error.strerror}" if error.filename is not None else str(error))
    except Exception as error:
        _say(_unforeseen(error))
    return FAILED


def _command_of(arguments: Sequence[str]) -> Callable[[], None]:
    """What the command line asks for.

    Raises:
        ConfigError: There is no such command, or it has no such option or value.
    """
    if not arguments or arguments[0] in ("-h", "--help", "--help-all"):
        return lambda: print(overview())
    if arguments[0] == "--version":
        return lambda: print(f"jointattn-mj {__version__}")
    if arguments[0] not in COMMANDS:
        from jointattn_mj.options import meant, shown

        if arguments[0] == "help":
            raise ConfigError("for help: jointattn --help, or jointattn COMMAND --help")
        if arguments[0].startswith("-"):
            general = ("--help", "--help-all", "--version")
            near = meant(arguments[0], general)
            raise ConfigError(f"no option {shown(arguments[0])}{near}; before a command stand {', '.join(general)}")
        known = ", ".join(COMMANDS)
        raise ConfigError(f"no command {shown(arguments[0])}{meant(arguments[0], COMMANDS)}; there are {known}")
    from jointattn_mj.cli.parsing import parsed

    return parsed(arguments[0], arguments[1:])


def _less(name: str) -> str:
    """What to ask a command for where memory is short."""
    from jointattn_mj.cli.parsing import module_of

    less: str = module_of(name).LESS
    return less


@contextmanager
def _old_names_on_one_line() -> Iterator[None]:
    """Say all names of the last version that are used while the block runs on one line, when it ends."""
    changes: dict[str, None] = {}
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *where: object) -> None:
            if category.__name__ == "RenamedWarning":  # by name, for its module may not be imported yet
                changes[str(message).partition("; ")[0].replace(" is now called ", " is now ")] = None
            else:
                usual(message, category, *where)  # type: ignore[arg-type]

        warnings.showwarning = show  # type: ignore[assignment]
        try:
            yield
        finally:
            if changes:
                _say(f"warning: old names: {'; '.join(changes)}; they go with the next version")


def _unforeseen(error: Exception) -> str:
    """One line for a fault of this program; the traceback is kept in a file, or shown where that is asked for."""
    told = "".join(traceback.format_exception(error))
    where = f"{TRACEBACK}=1 shows where"
    if os.environ.get(TRACEBACK):
        print(told, end="", file=sys.stderr)
        where = "its traceback stands above"
    else:
        try:
            with tempfile.NamedTemporaryFile("w", prefix="jointattn-", suffix=".txt", delete=False) as file:
                file.write(f"{sys.argv}\n{told}")
            where = f"its traceback is in {file.name}"
        except OSError:
            pass
    said = f"{type(error).__name__}: {' '.join(str(error).split())[:300]}".removesuffix(": ")
    return f"{said}. This is a fault of jointattn; please report it, {where}"


def _say(message: str) -> None:
    print(f"jointattn: {' '.join(with_options(message).split())}", file=sys.stderr)
