"""The page on speed shows the figures that are committed."""

from tools.speed_page import PAGE, with_figures


def test_figures_are_those_of_the_files():
    page = PAGE.read_text("utf-8")
    assert with_figures(page) == page, "python -m tools.speed_page writes them"
    assert "| 320x240 | 1,024 |" in page
