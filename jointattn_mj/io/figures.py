"""Figures as files that are the same whenever they are drawn, in fonts that have their characters."""

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import matplotlib
from matplotlib import font_manager
from matplotlib.figure import Figure
from matplotlib.text import Text

from jointattn_mj.io.files import write_whole

matplotlib.rcParams["svg.hashsalt"] = "jointattn"
FONT = "DejaVu Sans"
"""Comes with matplotlib; it has no Chinese, Japanese or Korean characters."""
_BUNDLED = matplotlib.get_data_path()
"""Fonts for formulas lie there, and one that has a box for every character."""


def save(figure: Figure, path: Path, whole: bool = False) -> None:
    """Write a figure as PNG, without anything in it that changes from run to run.

    Args:
        figure: The figure.
        path: Of the file.
        whole: Make the image as large as all words need, whatever the figure's size.
    """
    box = "tight" if whole else None

    def draw(temporary: Path) -> None:
        with with_fonts(figure):
            figure.savefig(temporary, dpi=110, metadata={"Software": None}, bbox_inches=box)

    write_whole(path, draw)


def without_formulas(figure: Figure) -> Figure:
    """Take dollar signs in the words of a figure as they are, where users wrote them: they begin no formula."""
    for text in figure.findobj(Text):
        text.set_parse_math(False)
    return figure


@contextmanager
def with_fonts(figure: Figure) -> Iterator[None]:
    """Draw what our font lacks with other fonts of this machine.

    An SVG keeps what none of them has as text, so that the reader's fonts show it.
    """
    texts = figure.findobj(Text)
    words = [text.get_text() for text in texts]
    others = {_font_with(character) for character in lacking(words)}
    if others:
        for text in texts:
            text.set_fontfamily([FONT, *sorted(name for name in others if name)])
    with warnings.catch_warnings(), matplotlib.rc_context({"svg.fonttype": "none"} if None in others else {}):
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)
        yield


def lacking(words: Iterable[str]) -> list[str]:
    """Characters that our font does not have."""
    known = _characters(font_manager.findfont(FONT))
    characters = {character for word in words for character in word if not character.isspace()}
    return sorted(character for character in characters if ord(character) not in known)


def without_font(words: Iterable[str]) -> list[str]:
    """Characters that no font of this machine has: images show boxes in their place."""
    return [character for character in lacking(words) if _font_with(character) is None]


@cache
def _characters(path: str) -> frozenset[int]:
    return frozenset(font_manager.get_font(path).get_charmap())


@cache
def _font_with(character: str) -> str | None:
    """Name of an installed font that has a character."""
    fonts = ((font.name, font.fname) for font in font_manager.fontManager.ttflist)
    installed = sorted(font for font in fonts if not font[1].startswith(_BUNDLED))
    return next((name for name, path in installed if ord(character) in _characters(path)), None)
