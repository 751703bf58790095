"""What the package calls an argument, as it is typed on a command line."""

import re

_ARGUMENT = re.compile(r"`([a-z_.]+)(?:=([^`]*))?`")


def with_options(message: str) -> str:
    """A message of the package with options in the place of arguments: ``--skip-rows 2`` for ```skip_rows=2```.

    Messages name an argument as it is called in Python, between backticks, with or without a value.
    """
    return _ARGUMENT.sub(lambda match: _typed(match[1].replace("_", "-"), match[2]), message)


def _typed(name: str, value: str | None) -> str:
    if value is None or value == "True":
        return f"--{name}"
    if value == "False":
        return f"--no-{name}"
    return "--{} {}".format(name, value.strip("'"))
