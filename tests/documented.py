"""What README and the pages of documentation tell a reader to type, in reading order."""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    """Of its first line, from 1 on."""
    language: str
    text: str

    @property
    def location(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


@dataclass(frozen=True)
class Command:
    """A line of a shell block."""

    block: Block
    words: tuple[str, ...]
    """Without comments, settings of the environment, ``taskset -c 0`` and ``&``."""
    background: bool
    """Whether it ends in ``&``."""

    def __str__(self) -> str:
        return f"{self.block.location}: {shlex.join(self.words)}"

    def option(self, name: str) -> str | None:
        """What follows ``name``; None where it is not there."""
        return self.words[self.words.index(name) + 1] if name in self.words else None


def pages() -> list[Path]:
    """README, the site's pages in the order of its contents, CONTRIBUTING, and the pages of the experiments."""
    contents = yaml.load((ROOT / "mkdocs.yml").read_text(), yaml.BaseLoader)["nav"]
    written = [ROOT / "docs" / name for name in _names(contents) if (ROOT / "docs" / name).exists()]
    claims = sorted((ROOT / "experiments").glob("*/README.md"))
    return [ROOT / "README.md", *written, ROOT / "CONTRIBUTING.md", ROOT / "experiments" / "README.md", *claims]


def _names(contents: object) -> list[str]:
    """Files in a part of the contents, whose parts are lists and titles."""
    if isinstance(contents, str):
        return [contents]
    parts = contents.values() if isinstance(contents, dict) else contents
    return [name for part in parts for name in _names(part)]


def blocks(page: Path) -> list[Block]:
    """Fenced blocks of a page."""
    text = page.read_text("utf-8")
    return [Block(page, text.count("\n", 0, found.start()) + 2, *found.groups()) for found in BLOCK.finditer(text)]


def commands(block: Block) -> list[Command]:
    """The lines of a shell block that are commands."""
    lines = [shlex.split(re.sub(r"(^|\s)#.*", "", line)) for line in block.text.replace("\\\n", " ").splitlines()]
    found = []
    for words in filter(None, lines):
        while "=" in words[0]:
            words = words[1:]
        words = words[3:] if words[0] == "taskset" else words
        background = words[-1] == "&"
        found.append(Command(block, tuple(words[:-1] if background else words), background))
    return found
