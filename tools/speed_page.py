"""Write the figures of speed into the pages that show them: ``python -m tools.speed_page``.

They come from files in ``experiments``: ``benchmark.json``, which ``jointattn benchmark`` writes, and ``gpu_eye.json``,
``gpu_parts.json``, ``many_sessions.json`` and ``many_gpu_sessions.json``, which ``tools.gpu_eye``, ``tools.gpu_parts``
and ``tools.many_sessions`` write.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH

HERE = Path(__file__).parents[1]
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


def benchmark_tables(figures: Mapping[str, Any]) -> str:
    """What ``jointattn benchmark`` measures."""
    f = figures
    of_sessions = {
        "rendering alone, the very images of the loop":
            f"{f['render_ms']:.2f} ms an image, {f['render_to_dm_control']:.2f} of dm_control's time",
        "closed loop from images, everything in it":
            f"{f['loop_ms_per_image']:.2f} ms an image, {f['loop_to_render']:.2f} times rendering alone",
        "the same, preset `cross_situational`": f"{f['contingent_to_render']:.2f} times rendering alone",
        "the same, drawing only what changes": f"{f['changes_to_render']:.2f} times rendering all of these images",
        "26 simulated minutes from images":
            f"{f['session_26_min_s']:.0f} s, {f['loop_times_real_time']:.0f} times real time",
        "getting to know the face, before a session from images": f"{f['familiarise_s']:.1f} s",
        "from the state": f"{f['state_times_real_time']:,.0f} times real time; "
            f"as a command of 26 minutes, with tables and figures, {f['state_command_times_real_time']:.0f}",
        "from the state, bodies in closed form": f"{f['closed_form_times_real_time']:,.0f} times real time; "
            f"as a command {f['closed_form_command_times_real_time']:.0f}",
        "memory of a command": f"{f['session_mib']:.0f} MiB from images, {f['state_session_mib']:.0f} from the state",
        "a frame of a session's film": f"{f['video_frame_ms']:.1f} ms",
        "first session from the state, nothing compiled": f"{f['first_session_s']:.1f} s",
        "first `develop table`, likewise": f"{f['first_develop_s']:.1f} s",
        "`jointattn --help`": f"{f['help_s']:.2f} s",
        "dm_control's cartpole with pixels at 320x240":
            f"{f['cartpole_ms']:.0f} ms a step; our loop takes {f['loop_to_cartpole']:.2f} of that an image",
    }  # fmt: skip
    of_development = {
        "step of chapter 5 from images": f"{f['step_ms']:.2f} ms, {f['step_to_image']:.2f} times its image alone",
        "the same, drawing only the centre": f"{f['centre_step_to_image']:.2f} times that image",
        "step of the same agent at the symbolic table": f"{f['table_step_us']:.2f} microseconds",
        "run of 100,000 steps there, preset `thesis`": f"{f['thesis_100k_s']:.3f} s",
        "preset `fast`": f"{f['fast_100k_s']:.3f} s",
        "compiling all of it, once on a machine": f"{f['compile_s']:.1f} s",
    }
    nanoseconds = {count: f[f"ns_per_triple_{count}"] for count in (12, 48, 108, 300)}
    of_detector = {
        "count a transition, SAC of all triples, find the highest: steps a second":
            f"{f['detector_steps_per_s_12'] / 1e6:.1f} million with 12 triples, "
            f"{f['detector_steps_per_s_300'] / 1e6:.2f} million with 300",
        "nanoseconds a triple": ", ".join(f"{value:.1f} ({count} triples)" for count, value in nanoseconds.items()),
        "times the speed of recomputing SAC from the tables in numpy":
            f"{f['detector_to_numpy_12']:.0f} with 12 triples, {f['detector_to_numpy_300']:.0f} with 300",
    }  # fmt: skip
    million = f"transfer entropy of a million steps, {f['transfer_entropy_ms']:.2f} ms for int32"
    of_entropy = {
        million: f"int32 {_share(f, 'transfer_entropy')}, int64 {_share(f, 'int64')} of pyinform's time",
        "several calls with the same series": f"int32 {_share(f, 'in_a_row')}, int64 {_share(f, 'in_a_row_int64')}",
        "with a condition": _share(f, "conditional"),
        "a series of 100 steps": _share(f, "short"),
        "2,000 of these, an array given to both": _share(f, "many_short"),
        "2,000 of these, lists given to both": _share(f, "many_short_lists"),
    }
    of_worlds = {
        f"16 worlds of `follow` in one process, {kind}": f"{f[f'vector_{name}_steps_per_s']:,.0f} steps a second, "
            f"{f[f'vector_{name}_to_sync']:.2f} times SyncVectorEnv's"
        for name, kind in (("state", "from the state"), ("images", "from images"))
    }  # fmt: skip
    tables = of_sessions, of_worlds, of_development, of_detector, of_entropy
    return "\n\n".join("\n".join(["| | |", "|---|---|", *map("| {} | {} |".format, table, table.values())])
                       for table in tables) + "\n"  # fmt: skip


def _share(figures: Mapping[str, Any], name: str) -> str:
    return f"{figures[f'{name}_to_pyinform']:.2f}"


TABLES: dict[str, Callable[[Mapping[str, Any]], str]] = {
    "gpu_eye": cards_table, "gpu_parts": parts_table, "many_sessions": sessions_table,
    "many_gpu_sessions": sessions_table, "benchmark": benchmark_tables,
}  # fmt: skip
"""Files of figures, and how each is shown."""
PAGES = {
    HERE / "docs" / "speed.md": ("gpu_eye", "gpu_parts", "many_sessions", "many_gpu_sessions"),
    HERE / "experiments" / "README.md": ("benchmark",),
}
"""Pages, and the files whose figures each shows."""


def with_figures(page: str, names: Sequence[str]) -> str:
    """The page with the figures of these files in ``experiments``."""
    for name in names:
        figures = json.loads((HERE / "experiments" / f"{name}.json").read_text("utf-8"))
        before, _, rest = page.partition(BEGIN.format(name))
        after = rest.partition(END.format(name))[2]
        page = f"{before}{BEGIN.format(name)}\n\n{TABLES[name](figures)}\n{END.format(name)}{after}"
    return page


if __name__ == "__main__":
    for page, names in PAGES.items():
        page.write_text(with_figures(page.read_text("utf-8"), names), "utf-8")
