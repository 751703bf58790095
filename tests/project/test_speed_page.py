"""The pages on speed show the figures that are committed."""

import pytest

from tools.speed_page import PAGES, with_figures


@pytest.mark.parametrize(("page", "names"), PAGES.items(), ids=lambda part: getattr(part, "name", None))
def test_figures_are_those_of_the_files(page, names):
    text = page.read_text("utf-8")
    assert with_figures(text, names) == text, "python -m tools.speed_page writes them"
    assert "| 320x240 | 1,024 |" in text or "times rendering alone |" in text
