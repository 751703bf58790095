"""When gaze following, looking back and gaze alternation are found in an hour without turns."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from jointattn_mj.laboratory.claim import Cells, Finding


def analyse(cells: Cells) -> list[Finding]:
    """Nothing yet."""
    return []


def draw(cells: Cells) -> Mapping[str, Figure]:
    """Nothing yet."""
    return {}
