"""From the words of a command line to a call: help, ``--config``, names of the last version, then tyro.

A command is the function ``NAME`` of ``jointattn_mj.cli.NAME``. A module with sub-commands of its own has
``command_for(arguments, file)`` besides, which gives one of them and the words that follow it; ``file`` is that of
--config. A module whose options have defaults that follow from another one, such as --preset, has
``defaults_for(words, config, kind)``, which gives the config of class ``kind`` that the options start from; ``config``
is that of the file. A module with ``in_world(words)`` has another function of the same command for each --world.
"""

import inspect
import io
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stderr
from difflib import get_close_matches
from functools import partial, wraps
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, get_type_hints

import tyro

from jointattn_mj.cli.given import GIVEN
from jointattn_mj.cli.help import ALL, HELP, help_text
from jointattn_mj.cli.old_names import typed_names, with_names_of_today
from jointattn_mj.cli.usage import complaint
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.configs import read_config, values_in
from jointattn_mj.options import without_class

CONFIG = "config"
"""Name of the parameter and of the option that --config FILE gives defaults to."""
MAKERS = {"robot": "session", "video": "perceive"}
"""Commands by a field that the configs of no other command have."""
Config = TypeVar("Config")


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
        if hasattr(module, "in_world"):
            command, words = module.in_world(words)
            prog += "" if command.__name__ == name else f" --world {command.__name__}"
        start = None if file is None else _read(command, file, name)
        if hasattr(module, "defaults_for"):
            start = module.defaults_for(words, start, get_type_hints(command)[CONFIG])
        command = command if start is None else with_defaults(command, **{CONFIG: start})
    with GIVEN:
        words = _gathered(with_names_of_today(words, command))
        if any(word in HELP for word in words):
            print(help_text(command, prog, words))
            raise SystemExit(0)
        return by_tyro(command, prog, words)


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
        raise ConfigError(_strange(command, prog, arguments) or complaint(said.getvalue())) from None


def _strange(command: Callable[..., None], prog: str, arguments: Sequence[str]) -> str | None:
    """What is said of words that are no options of a command, whatever else is wrong with its command line."""
    if arguments[:1] == ["help"]:
        return f"for help: {prog} --help"
    known = {"--help", ALL, f"--{CONFIG}", *typed_names(command)}
    for word in arguments:
        option = word.partition("=")[0].replace("_", "-")
        if option.startswith("--") and not {option, re.sub(r"(^--|\.)no-(?=[^.]*$)", r"\1", option)} & known:
            near = " or ".join(get_close_matches(option, known, n=2, cutoff=0.75))
            return f"no option {option}{f' (perhaps you meant {near})' if near else ''} (run {prog} --help)"
    return None


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
        parameter.replace(default=defaults.get(parameter.name, parameter.default), kind=inspect.Parameter.KEYWORD_ONLY)
        for parameter in signature.parameters.values()
    ]
    same.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return same


def _gathered(words: Sequence[str]) -> list[str]:
    """Objects that are named one by one, ``--object a --object b``, in one option; tyro would take the last alone."""
    single, several = "--object", "--objects"
    if not any(word.partition("=")[0] == single for word in words):
        return list(words)
    rest: list[str] = []
    objects: list[str] = []
    at, inside = len(words), False
    for word in words:
        option, given, value = word.partition("=")
        if option in (single, several):
            at, inside = min(at, len(rest)), not given
            objects += [value] if given else []
        elif inside and not word.startswith("-"):
            objects.append(word)
        else:
            inside = False
            rest.append(word)
    return [*rest[:at], several, *objects, *rest[at:]]


def _config_file(arguments: Sequence[str]) -> tuple[Path | None, list[str]]:
    """The file of --config, and all other words."""
    words = list(arguments)
    for number, word in enumerate(words):
        if word == f"--{CONFIG}":
            if number + 1 == len(words):
                raise ConfigError(f"--{CONFIG} expects a file, the config.yaml of a run")
            return Path(words[number + 1]), words[:number] + words[number + 2 :]
        if word.startswith(f"--{CONFIG}="):
            return Path(word.partition("=")[2]), words[:number] + words[number + 1 :]
    return None, words


def _read(command: Callable[..., None], file: Path, name: str) -> Any:
    """The config of a command from a file.

    Raises:
        ConfigError: The command takes none, or the file has none.
    """
    hints = get_type_hints(command)
    if CONFIG not in hints:
        raise ConfigError(f"{name} takes no --{CONFIG}; see jointattn {name} --help")
    return config_from(file, hints[CONFIG], name)


def config_from(file: Path, kind: type[Config], name: str) -> Config:
    """The config in the file of --config.

    Args:
        file: The config.yaml of a run.
        kind: Class of the config.
        name: The command that is to take it, such as ``develop table``.

    Raises:
        ConfigError: The file cannot be read, is of a run of another command, or holds no such config.
    """
    maker = _maker_of(values_in(file))
    if maker not in (None, name):
        raise ConfigError(f"{file} is of a run of {maker}; this is {name}")
    return read_config(file, kind)


def _maker_of(values: Mapping[str, Any]) -> str | None:
    """The command whose run has left a config; None where that cannot be told."""
    world, mode = values.get("world"), values.get("mode")
    if isinstance(world, str):
        return f"develop {'realtime' if mode == 'realtime' else world}"  # a mode in the last version
    return next((command for field, command in MAKERS.items() if field in values), None)
