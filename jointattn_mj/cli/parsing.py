"""From the words of a command line to a call: help, ``--config``, names of the last version, then tyro.

A command is the function ``NAME`` of ``jointattn_mj.cli.NAME``. A module with sub-commands of its own has
``command_for(arguments, file)`` besides, which gives one of them and the words that follow it; ``file`` is that of
--config.
"""

import inspect
import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from functools import partial, wraps
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, get_type_hints

import tyro

from jointattn_mj.cli.given import GIVEN
from jointattn_mj.cli.help import HELP, help_text
from jointattn_mj.cli.old_names import with_names_of_today
from jointattn_mj.cli.usage import complaint, without_class
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.configs import read_config

CONFIG = "config"
"""Name of the parameter and of the option that --config FILE gives defaults to."""


def module_of(name: str) -> ModuleType:
    """The module of a command."""
    return import_module(f"jointattn_mj.cli.{name}")


def parsed(name: str, arguments: Sequence[str]) -> Callable[[], None]:
    """What a command has been asked for, to be called.

    Args:
        name: The command.
        arguments: What follows it on the command line.

    Raises:
        ConfigError: No such option, or a value that it may not have.
        SystemExit: Help was asked for, and has been printed.
    """
    file, words = _config_file(arguments)
    module = module_of(name)
    prog = f"jointattn {name}"
    if hasattr(module, "command_for"):
        command, words = module.command_for(words, file)
        prog += " WORLD" if command.__name__ == name else f" {command.__name__}"
    else:
        command = getattr(module, name)
        command = command if file is None else with_defaults(command, **{CONFIG: _read(command, file, name)})
    with GIVEN:
        if any(word in HELP for word in words):
            print(help_text(command, prog, words))
            raise SystemExit(0)
        return by_tyro(command, prog, with_names_of_today(words, command))


def by_tyro(command: Callable[..., None], prog: str, arguments: Sequence[str]) -> Callable[[], None]:
    """A command with its parameters from the command line, to be called.

    Args:
        command: Its annotations say which options there are.
        prog: What stands before the options.
        arguments: The options.

    Raises:
        ConfigError: What is wrong with them, in one line.
    """

    @wraps(command)
    def with_parameters(*positional: Any, **named: Any) -> Callable[[], None]:
        return partial(command, *positional, **named)

    said = io.StringIO()
    try:
        with redirect_stderr(said):
            made: Callable[[], None] = tyro.cli(with_parameters, prog=prog, args=list(arguments))
        return made
    except ConfigError as error:
        raise ConfigError(without_class(str(error))) from error
    except SystemExit as stop:
        if stop.code == 0:
            raise
        raise ConfigError(complaint(said.getvalue())) from None


def with_defaults(command: Callable[..., None], **defaults: Any) -> Callable[..., None]:
    """A command whose parameters have other defaults.

    Args:
        command: The function.
        defaults: Values by the names of parameters.
    """

    @wraps(command)
    def same(*positional: Any, **named: Any) -> None:
        command(*positional, **named)

    signature = inspect.signature(command)
    parameters = [
        one.replace(default=defaults.get(one.name, one.default), kind=inspect.Parameter.KEYWORD_ONLY)
        for one in signature.parameters.values()
    ]
    same.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return same


def _config_file(arguments: Sequence[str]) -> tuple[Path | None, list[str]]:
    """The file of --config, and all other words."""
    words = list(arguments)
    for place, word in enumerate(words):
        if word == f"--{CONFIG}":
            if place + 1 == len(words):
                raise ConfigError(f"--{CONFIG} expects a file, the config.yaml of a run")
            return Path(words[place + 1]), words[:place] + words[place + 2 :]
        if word.startswith(f"--{CONFIG}="):
            return Path(word.partition("=")[2]), words[:place] + words[place + 1 :]
    return None, words


def _read(command: Callable[..., None], file: Path, name: str) -> Any:
    """The config of a command from a file.

    Raises:
        ConfigError: The command takes none, or the file has none.
    """
    hints = get_type_hints(command)
    if CONFIG not in hints:
        raise ConfigError(f"{name} takes no --{CONFIG}; see jointattn {name} --help")
    return read_config(file, hints[CONFIG])
