"""What the harnesses found, written into docs/reliability.md between two marks."""

import re
from pathlib import Path

from tools.reliability.results import FOLDER, ROOT, load, table

PAGE = ROOT / "docs" / "reliability.md"
BEGIN = "<!-- written by `python -m tools.reliability report` -->"
END = "<!-- as far as here -->"
TITLES = {
    "kills": (
        "Killed and gone on with",
        "kill -9 at random moments, and the same command again until the run was done; bytes in which the results "
        "then differ from those of a run in peace. Not compared: how long it took.",
    ),
    "stops": (
        "Stopped and gone on with",
        "The same with Ctrl-C, after which a command has to end with 130, and with one line. The overlay of "
        "`perceive` is encoded anew from where it was stopped: as many images, other bytes.",
    ),
    "pairs": (
        "Two commands in one folder",
        "Started at once or up to 0.6 s apart. One has the folder and leaves what it leaves alone; the other says so "
        "in a line and ends with 2. Experiments share a folder.",
    ),
    "malformed": (
        "Inputs that make no sense",
        "Values of options, damaged and made-up files, calls from Python. Right is an error in a line, or a result "
        "where the input has one; counted is everything else.",
    ),
    "videos": (
        "Odd and damaged videos",
        "For `perceive`: containers, codecs, sizes, rates, names and things that are no videos, and such files after "
        "bytes were lost or changed. Right is as many seconds as an odd video has, a refusal in a line of what is no "
        "video, and either of a damaged one; counted is everything else. One in ten goes to the command, the rest "
        "are watched from Python.",
    ),
    "hours": (
        "A simulated day",
        "Resident memory of the process, and what it wrote in all beside what it left.",
    ),
}


def figures(folder: Path = FOLDER) -> str:
    """All that is stored, as Markdown."""
    parts = []
    for name, (title, about) in TITLES.items():
        result = load(name, folder)
        if result is None:
            continue
        versions = ", ".join(f"{package} {version}" for package, version in result["versions"].items())
        with_what = f"{result['date']}, {result['seconds']:,} s on {result['machine']}; {versions}."
        parts += [f"### {title}", about, f"`python -m tools.reliability {name}`, {with_what}", table(result["rows"])]
        if result["wrong"]:
            parts.append(f"What went wrong stands in `experiments/reliability/{name}.json`.")
    return "\n\n".join(parts)


def page(text: str, folder: Path = FOLDER) -> str:
    """The page's text with the figures as they are stored.

    Raises:
        ValueError: The marks are not there.
    """
    made, count = re.subn(
        f"{re.escape(BEGIN)}.*?{re.escape(END)}",
        lambda match: f"{BEGIN}\n\n{figures(folder)}\n\n{END}",
        text,
        flags=re.S,
    )
    if count != 1:
        raise ValueError(f"expected one part between {BEGIN} and {END}; found {count}")
    return made
