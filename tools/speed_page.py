"""Write the figures of many worlds and many sessions into the page on speed: ``python -m tools.speed_page``.

They come from ``experiments/gpu_eye.json``, ``gpu_parts.json``, ``many_sessions.json`` and ``many_gpu_sessions.json``,
which ``tools.gpu_eye``, ``tools.gpu_parts`` and ``tools.many_sessions`` write.
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH

HERE = Path(__file__).parents[1]
PAGE = HERE / "docs" / "speed.md"
KINDS = {"state": "from the state", "pixels": "from images", "warp": "from images of one card"}
"""Kinds of sessions by the beginnings of their settings."""
BEGIN, END = "<!-- {}: written by python -m tools.speed_page -->", "<!-- end of {} -->"


def cards_table(figures: Mapping[str, Any]) -> str:
    """What a graphics card draws: a row for each size and number of worlds."""
    versions = ", ".join(f"{name} {number}" for name, number in figures["versions"].items())
    off = figures["to_opengl"]
    lines = [f"{figures['device']}, driver {figures['driver']}, {versions}, {figures['date']}."]
    lines.append(
        f"{off['images']} images against OpenGL's ({figures['opengl']}): mean difference {off['mean']:.2f} grey"
    )
    lines.append(f"levels; {off['off_by_more_than_2']:.1%} of pixels off by more than 2,")
    lines.append(f"{off['off_by_more_than_16']:.2%} by more than 16.")
    lines += [
        "",
        "| image | worlds | rays | images/s | by a graph | pose | refit | cast | copy |",
        "|---|---|---|" + 6 * "--:|",
    ]
    for row in figures["rows"]:
        parts = " | ".join(f"{row[f'{name}_us'][0]:.2f}" for name in ("pose", "refit", "cast", "copy"))
        whole = " | ".join(f"{row[name][0]:,.0f}" for name in ("images_per_s", "graph_images_per_s"))
        lines.append(f"| {row['size']} | {row['worlds']:,} | {_rays(row)} | {whole} | {parts} |")
    return "\n".join(lines) + "\n"


def _rays(row: Mapping[str, Any]) -> str:
    """How the rays of a row were cast."""
    if row.get("samples", 1) > 1:
        return f"{row['samples']}x{row['samples']} a pixel"
    return " in ".join("x".join(map(str, tile)) for tile in row["tiles"]) or "by row"


def parts_table(figures: Mapping[str, Any]) -> str:
    """What a graphics card draws in parts: a row for each size of part."""
    lines = [
        f"{figures['device']}, {figures['date']}.", "",
        "| part | parts at once | parts/s | whole images/s | draw | copy |", "|---|" + 5 * "--:|",
    ]  # fmt: skip
    for row in figures["rows"]:
        wide, high = map(int, row["part"].split("x"))
        pace = row["graph_images_per_s"][0]
        whole = pace * wide * high / (IMAGE_WIDTH * IMAGE_HEIGHT)
        draw, copy = row["graph_us"][0], row["copy_us"][0]
        lines.append(f"| {row['part']} | {row['slots']:,} | {pace:,.0f} | {whole:,.0f} | {draw:.3f} | {copy:.3f} |")
    return "\n".join(lines) + "\n"


def sessions_table(figures: Mapping[str, Any]) -> str:
    """How fast many sessions ran."""
    lines = ["| sessions | processes | number | seconds | times real time | 1,000 sessions |", "|---|" + 5 * "--:|"]
    for row in figures["runs"]:
        kind = KINDS[row["setting"].partition("/")[0]]
        begin = f"| {kind} | {row['jobs']} | {row['sessions']} |"
        if "seconds" not in row:
            lines.append(f"{begin} none had ended after {row['given_up_after_s']:.0f} | | |")
            continue
        pace, minutes = row["times_real_time"], row["minutes_for_1000_sessions"]
        lines.append(f"{begin} {row['seconds']:.1f} | {pace:,.0f} | {minutes:.1f} min |")
    return f"{figures['cores']} cores, {figures['date']}.\n\n" + "\n".join(lines) + "\n"


TABLES: dict[str, Callable[[Mapping[str, Any]], str]] = {
    "gpu_eye": cards_table, "gpu_parts": parts_table, "many_sessions": sessions_table,
    "many_gpu_sessions": sessions_table,
}  # fmt: skip
"""Files of figures, and how each is shown."""


def with_figures(page: str) -> str:
    """The page with the figures that lie in ``experiments``."""
    for name, table in TABLES.items():
        figures = json.loads((HERE / "experiments" / f"{name}.json").read_text("utf-8"))
        before, _, rest = page.partition(BEGIN.format(name))
        after = rest.partition(END.format(name))[2]
        page = f"{before}{BEGIN.format(name)}\n\n{table(figures)}\n{END.format(name)}{after}"
    return page


if __name__ == "__main__":
    PAGE.write_text(with_figures(PAGE.read_text("utf-8")), "utf-8")
