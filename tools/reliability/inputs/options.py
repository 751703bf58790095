"""Values that make no sense, for every option of every command: options are read from ``--help-all``."""

import random
import re
import shlex
from dataclasses import dataclass
from pathlib import Path

from tools.reliability.malformed import Input, anything, refused
from tools.shell import Shell

LINE = re.compile(r"^[\s│|]{1,6}(--[a-z][\w.-]*)((?:, --[\w.-]+)*)(?: (\S.*?))?(?:\s{2,}.*)?[\s│|]*$")
COLUMNS = "90"
"""Wide enough for every option with what it takes, too narrow for two beside each other."""
NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "9223372036854775808", "1" + "0" * 400)
NOT_ONE = ("", "abc", "0x10", "1,5", "None", "--", "१२nan", "\udcff")
WHOLE = ("1.5", "-9223372036854775809")
TEXTS = ("", "x" * 5000, "\udcff\udcfe", "a\nb", "..", "-", "nan", "𝓍")
PATHS = ("", "x" * 10_000, "/dev/null/x", "/proc/self/mem", "/dev/full", "\udcff", ".", "a\nb", "-")


@dataclass(frozen=True)
class Base:
    """A command that takes a second where its options make sense."""

    command: str
    out: bool = True
    """Whether it takes --out."""
    asked: str = ""
    """Which of its options: those whose names begin so."""
    serves: bool = False
    """Whether it goes on until it is stopped: only values that cannot be are tried."""


BASES = (
    Base("session --perception state --minutes 0.02"),
    Base("session --minutes 0.02 --robot.familiarise.minutes 0.02", asked="--pixels"),
    Base("session --preset cross_situational --perception state --minutes 0.02", asked="--robot.learner"),
    Base("develop table --preset fast --steps 2000"),
    Base("develop table --preset local --steps 300", asked="--agent.local"),
    Base("develop rendered --resolution growing --steps 20 --rendered.exploration 60", asked="--babbling"),
    Base("develop rendered --maps continuous --steps 20 --rendered.exploration 60", asked="--continuous"),
    Base("develop rendered --steps 20 --rendered.exploration 60 --rendered.calibration 5"),
    Base("develop realtime --minutes 0.02 --realtime.perception state --realtime.familiarise-minutes 0.1"),
    Base("perceive {video} --no-overlay --max-minutes 0.02"),
    Base("perceive {video} --no-overlay --max-minutes 0.02 --looks", asked="--coding"),
    Base("recordings {events} --infant robot --partner caregiver --surrogates 20 --resamples 5"),
    Base("looks {session} --form table"),
    Base("measure {table} --source her_gaze --condition my_gaze --target toy_seen", out=False),
    Base("discover {table} --sensors her_gaze --actions my_gaze --results toy_seen", out=False),
    Base("play follow --agent zero --episodes 1 --time-limit 0.2", out=False),
    Base("experiment list", out=False),
    Base("experiment run 5.2 --setting 'robot first' --runs 1 --jobs 1"),
    Base("experiment report {store}", out=False),
    Base("benchmark --what scene --blocks 1 --seconds 1", out=False, serves=True),
    Base("view follow --agent zero", out=False, serves=True),
)


@dataclass(frozen=True)
class Option:
    """An option as --help-all shows it."""

    name: str
    takes: str
    """FLOAT, INT INT, PATH, [STR [STR ...]], {a,b}, or nothing."""
    default: str


def options_of(shell: Shell, base: Base, places: dict[str, str]) -> list[Option]:
    """Those that a command has.

    Args:
        shell: Runs commands.
        base: Command with what it needs.
        places: Folders and files that commands name.
    """
    arguments = [places.get(word, word) for word in shlex.split(base.command)]
    said = shell(*arguments, "--help-all", env={"COLUMNS": COLUMNS}).out
    options = []
    lines = said.splitlines()
    for place, line in enumerate(lines):
        if match := LINE.match(line):
            rest = " ".join(part.strip(" │|") for part in lines[place : place + 12])
            default = re.search(r"\(default: ([^)]*)\)", rest)
            options.append(Option(match[1], match[3] or "", default[1].strip() if default else ""))
    return [option for option in options if option.name.startswith(base.asked) and option.name != "--help"]


def values_for(option: Option, chance: random.Random) -> list[tuple[tuple[str, ...], bool]]:
    """Words that may follow an option, and whether a run with them is wrong in any case."""
    takes = option.takes
    if not takes:
        return [(("yes",), True)]
    if takes.startswith(("{", "[{")):
        return [((text,), True) for text in (*TEXTS, takes.strip("{}"))]
    parts = re.findall(r"FLOAT|INT|STR|PATH", takes)
    kind, count = parts[0], 1 if "..." in takes else len(parts)
    if kind == "PATH":
        return [((path,), False) for path in PATHS]
    if kind == "STR":
        return [((text,) * count, False) for text in TEXTS]
    bad = [number for number in NUMBERS if number not in (option.default, option.default.split(" ")[0])]
    values = []
    for word in (*bad, *NOT_ONE, *(WHOLE if kind == "INT" else ())):
        words = ["1"] * count
        words[chance.randrange(count)] = word
        values.append((tuple(words), word != "None" or option.default != "None"))
    return [*values, (("1",) * (count + 1), True)]


def inputs(shell: Shell, chance: random.Random, many: int, folder: Path, places: dict[str, str]) -> list[Input]:
    """``many`` of all that there are, drawn by ``chance``; every command has some.

    Args:
        shell: Runs commands.
        chance: Draws options and values.
        many: Number of inputs.
        folder: For their files.
        places: Folders and files that commands name.
    """
    tried: dict[Base, list[Input]] = {}
    for base in BASES:
        tried[base] = []
        for option in options_of(shell, base, places):
            for words, wrong in values_for(option, chance):
                if wrong or not base.serves:
                    number = len(tried[base])
                    out = folder / f"{BASES.index(base)}_{number}"
                    tried[base].append(_input(base, option, words, wrong, out, places))
        chance.shuffle(tried[base])
    share = [tried[base][: max(5, many * len(tried[base]) // sum(map(len, tried.values())))] for base in BASES]
    return [option for part in share for option in part]


def _input(base: Base, option: Option, words: tuple[str, ...], wrong: bool, out: Path, places: dict[str, str]) -> Input:
    """The command with its option in place of the one that it may have already."""
    given = shlex.split(base.command) + (["--out", str(out)] if base.out else [])
    if option.name in given:
        place = given.index(option.name)
        del given[place : place + 2]
    given = [places.get(word, word) for word in given]
    what = f"{base.command.split(' --')[0]} {option.name} = {' '.join(words)[:60]!r}"
    follow = [f"{option.name}={words[0]}"] if len(words) == 1 else [option.name, *words]
    return Input("options", what, (*given, *follow), result=refused if wrong else anything)
