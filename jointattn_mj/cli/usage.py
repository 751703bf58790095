"""Errors of a command line on one line, instead of in tyro's boxes."""

import re

from jointattn_mj.options import meant


def complaint(box: str) -> str:
    """An error of tyro on one line: its first part, the suggestion, and where help is.

    Args:
        box: What tyro printed to stderr. The box's title is left out: the first part says it again.
    """
    lines = [line.strip("│ ") for line in re.sub(r"\x1b\[[0-9;]*m", "", box).splitlines()]
    first, *others = re.split(r" ─+ ", " ".join(line for line in lines if line[:1] not in ("╭", "╰")))
    first = re.sub(r" (?=[.,])", "", first)  # where a line was broken before a full stop
    first = re.sub(r"for argument '(?:\w+\.)?(\S+)'\.", r"for \1.", first)
    help_hint = others[-1].partition("For full helptext, ")[2] if others else ""
    return f"{_placed(first)}{_commands(others)}{_suggestion(first, others)} ({help_hint or 'see jointattn --help'})"


def without_class(message: str) -> str:
    """An error of a config without the name of its class, which nobody has typed."""
    return re.sub(r"^[A-Z]\w*\.", "", message)


def _placed(text: str) -> str:
    """``Error parsing LOCATION: MESSAGE`` as the option, or its dotted name, and the message."""
    match = re.match(r"Error parsing (\S+): (.*)", text)
    if match is None:
        return text
    location, message = match.groups()
    if without_class(message) != message:
        part = location.partition(".")[2]  # after the parameter of the command
        return f"{part}.{without_class(message)}".removeprefix(".")
    return f"{location}: {message}" if location.startswith("-") else message


def _commands(parts: list[str]) -> str:
    known = [re.match(r"Available subcommands: ([\w, -]+)$", part) for part in parts]
    return "".join(f"; there are {match[1]}" for match in known if match)


def _suggestion(text: str, parts: list[str]) -> str:
    choice = re.match(r"invalid choice '(.*)' for .* Expected one of \((.*)\)", text)
    if choice:
        return meant(choice[1], re.findall(r"'([^']*)'", choice[2]))
    near = [option for part in parts if part.startswith("Perhaps you meant") for option in re.findall(r"--\S+", part)]
    options = [option for option in near if option != "--help"][:2]
    return f" (perhaps you meant {' or '.join(options)})" if options else ""
