"""Errors of a command line on one line, instead of in tyro's boxes."""

import re

from jointattn_mj.options import meant, without_class


def complaint(box: str) -> str:
    """An error of tyro on one line: its first part, the suggestion, and where help is.

    Args:
        box: What tyro printed to stderr. The box's title is left out: the first part says it again.
    """
    box = re.sub(r"\x1b\[[0-9;]*m", "", box)  # colours
    lines = [line.strip("│ ") for line in box.splitlines()]
    inside = [line for line in lines if line[:1] not in ("╭", "╰")]
    first, *others = re.split(r" ─+ ", " ".join(inside))
    first = re.sub(r" (?=[.,])", "", first)  # where a line was broken before a full stop
    help_hint = others[-1].partition("For full helptext, ")[2].replace("run: ", "run ") if others else ""
    said = _missing(box) or _choice(first) or f"{_command(first, others) or _placed(first)}{_near(others)}"
    return f"{said} ({help_hint or 'see jointattn --help'})"


def _missing(box: str) -> str | None:
    """What is said of arguments that must be there, or of one without a value."""
    match = re.search(r"Missing value for argument '(\S+)'", box)
    if match:
        return f"{match[1]}: expected a value; got none"
    if "Missing from jointattn" not in box:
        return None
    names = re.findall(r"^│     (?! )(.*?) *│?$", box, re.M)
    needed = [name.split()[0] if name.startswith("-") else name for name in names if not name.startswith("jointattn")]
    return f"missing: {', '.join(needed).replace(',, ', ',')}"  # choices may go over two lines


def _choice(text: str) -> str | None:
    """What is said of a value that is none of the choices."""
    match = re.match(r"invalid choice '(.*)' for argument '(?:\w+\.)?(\S+)'. Expected one of \((.*)\)", text)
    if match is None:
        return None
    given, option, listed = match.groups()
    choices = re.findall(r"'([^']*)'", listed)
    if "None" in choices:  # left out on the command line by not giving the option; tyro sorts these by chance
        choices = sorted(set(choices) - {"None"})
    return f"{option}: expected one of {', '.join(choices)}; got {given!r}{meant(given, choices)}"


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


def _command(text: str, parts: list[str]) -> str | None:
    """What is said of a word where there should be one of some commands."""
    given = re.match(r"Unrecognized options: (\S+)", text)
    for match in (re.match(r"Available subcommands: ([\w, -]+)$", part) for part in parts):
        if match and given:
            return f"no command {given[1]!r}{meant(given[1], match[1].split(', '))}; there are {match[1]}"
    return None


def _near(parts: list[str]) -> str:
    """Options that are like one that is not there."""
    near = [option for part in parts if part.startswith("Perhaps you meant") for option in re.findall(r"--\S+", part)]
    options = [option for option in near if option != "--help"][:2]
    return f" (perhaps you meant {' or '.join(options)})" if options else ""
