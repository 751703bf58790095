"""Which command lines need no image: for them no OpenGL library is loaded, which saves 55 MiB."""

from collections.abc import Sequence

SHOWING = ("--video", "--rerun", "--world")
"""Beginnings of the options of ``session`` that need images, whatever the robot perceives."""


def needs_images(arguments: Sequence[str]) -> bool:
    """Whether a command line may need an image; only a session from the state certainly needs none.

    Args:
        arguments: Words of the command line, without the program's name.
    """
    if not arguments or arguments[0] != "session":
        return True
    perception, following = "", [*arguments[1:], ""]
    for word, after in zip(arguments, following, strict=True):
        option, _, value = word.partition("=")
        if option.startswith(SHOWING) and not option.startswith("--world."):
            return True
        if option == "--perception":
            perception = value or after
    return perception != "state"
