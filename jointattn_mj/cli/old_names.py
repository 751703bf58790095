"""Options and choices by their names in the last version, in the words of a command line."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any, get_args, get_type_hints

from jointattn_mj.cli.help import configs_of
from jointattn_mj.options import TOP_LEVEL, Checked, old_choices, old_names, warn_renamed


def with_names_of_today(arguments: Sequence[str], command: Callable[..., Any]) -> list[str]:
    """The words of a command line, each old name replaced by the new one; warns of each.

    Args:
        arguments: The words.
        command: Its annotations say which options there are.
    """
    known = {typed: (now, old) for kind in configs_of(command) for typed, now, old in _options(kind)}
    words: list[str] = []
    option, choices = "", dict[str, str]()
    for word in arguments:
        if word.startswith("--"):
            typed, equals, value = word.partition("=")
            option, choices = _option_of_today(typed, known)
            if option != typed:
                warn_renamed(typed, option)
            words.append(f"{option}{equals}{_choice_of_today(option, value, choices)}")
        else:
            words.append(_choice_of_today(option, word, choices))
    return words


def typed_names(command: Callable[..., Any]) -> set[str]:
    """The options of a command by their names of today, as they are typed; flags without ``no-``."""
    return {f"--{now.replace('_', '-')}" for kind in configs_of(command) for _, now, _ in _options(kind)}


def _option_of_today(typed: str, known: Mapping[str, tuple[str, dict[str, str]]]) -> tuple[str, dict[str, str]]:
    """An option as it is called now, and its choices by their old names."""
    path, _, last = typed.removeprefix("--").replace("-", "_").rpartition(".")
    for no in ("", "no_"):
        name = f"{path}.{last.removeprefix(no)}".lstrip(".")
        if name in known and last.startswith(no):
            current, choices = known[name]
            path, _, last = current.rpartition(".")
            return (
                typed if current == name else f"--{path}.{no}{last}".replace("--.", "--").replace("_", "-")
            ), choices
    return typed, {}


def _choice_of_today(option: str, value: str, choices: dict[str, str]) -> str:
    if value not in choices:
        return value
    warn_renamed(f"{option} {value}", f"{option} {choices[value]}")
    return choices[value]


def _options(kind: type[Checked], typed: str = "", current: str = "") -> Iterator[tuple[str, str, dict[str, str]]]:
    """Every name under which an option can be typed, how it is called now, and its choices by their old names.

    Args:
        kind: Class of the config.
        typed: What stands before the names of its fields, as it can be typed.
        current: The same by its names of today.
    """
    for field in fields(kind):
        hint = get_type_hints(kind, include_extras=True)[field.name]
        before = ("", "") if TOP_LEVEL in get_args(hint) else (typed, current)
        for name in (field.name, *(old for old, new in old_names(kind).items() if new == field.name)):
            here, now = f"{before[0]}{name}", f"{before[1]}{field.name}"
            if isinstance(hint, type) and issubclass(hint, Checked):
                yield from _options(hint, f"{here}.", f"{now}.")
            else:
                yield here, now, dict(old_choices(kind).get(field.name, {}))
