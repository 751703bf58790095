"""Files of coded events, and folders of runs, of which a file is damaged: ``recordings``, ``measure`` and ``looks``."""

import random
import shutil
from collections.abc import Iterator
from pathlib import Path

from tools.reliability.inputs.damage import damaged
from tools.reliability.malformed import Input, anything, numbers
from tools.shell import Shell

SESSION = ("session", "--perception", "state", "--minutes", "2", "--seed", "1")
FORMS = ("elan", "boris", "datavyu", "table")
TIERS = ("--infant", "robot", "--partner", "caregiver")
FEW = ("--surrogates", "20", "--resamples", "5")


def session_of(shell: Shell, folder: Path) -> Path:
    """Folder of a session, whose looks can be written as coded events."""
    if not folder.exists():
        shell(*SESSION, "--out", folder)
    return folder


def events_of(shell: Shell, session: Path, form: str, folder: Path) -> Path:
    """The file of coded events of a session.

    Args:
        shell: Runs commands.
        session: Folder of a session.
        form: Format of the file.
        folder: For the file.
    """
    if not folder.exists():
        shell("looks", session, "--form", form, "--out", folder)
    (file,) = folder.iterdir()
    return file


def inputs(shell: Shell, chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Files of coded events for ``recordings`` and ``measure``, folders for ``looks``.

    Args:
        shell: Runs commands.
        chance: Draws what is damaged, and how.
        many: Number of inputs.
        folder: For their files.
    """
    session = session_of(shell, folder / "session")
    for number in range(many):
        at, out = folder / f"events{number}", str(folder / f"events{number}" / "out")
        if number % 4 == 3:
            shutil.copytree(session, at)
            path = chance.choice(sorted(file for file in at.iterdir() if file.is_file()))
            form = chance.choice(FORMS)
            command = ("looks", str(at), "--form", form, "--out", str(folder / f"looks{number}"))
        else:
            form = chance.choice(FORMS)
            file = events_of(shell, session, form, folder / form)
            at.mkdir(parents=True)
            path = Path(shutil.copy(file, at))
            command = ("recordings", str(path), *TIERS, *FEW, "--out", out)
            if number % 2:
                command = ("measure", str(path), "--source", "caregiver", "--target", "robot", "--step", "0.5", *FEW)
        what, made = damaged(path.read_bytes(), chance)
        path.write_bytes(made)
        what = f"{command[0]}: {form}, {path.name} {what}"
        yield Input("coded events", what, command, result=anything if command[0] == "looks" else numbers)
