"""Results of one analysis: the rows as CSV, and the same with config, versions and notes as JSON."""

import csv
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from jointattn_mj.errors import OutputError
from jointattn_mj.io.files import alone, make_room, write_whole
from jointattn_mj.io.provenance import plain, versions


def result_paths(out: Path, name: str) -> tuple[Path, Path]:
    """The CSV and the JSON file that ``out`` means: without a suffix, or with one of theirs; in a folder, ``name``.

    Raises:
        OutputError: One of them is there already, or their folder cannot be made or written to.
    """
    try:
        if out.is_dir():
            out = out / name
        stem = out.with_suffix("") if out.suffix in (".csv", ".json") else out
        paths = stem.with_name(f"{stem.name}.csv"), stem.with_name(f"{stem.name}.json")
        there = [path for path in paths if path.exists()]
    except (OSError, ValueError) as error:  # a name that is too long, empty, or has a NUL in it
        trouble = getattr(error, "strerror", None) or error
        raise OutputError(f"cannot write {str(out)[:100]!r}: {trouble}; choose another path") from error
    if there:
        raise OutputError(f"{there[0]} is there already; choose another path")
    make_room(paths[0])
    return paths


@contextmanager
def claimed_paths(out: Path, name: str) -> Iterator[tuple[Path, Path]]:
    """As ``result_paths``, and no other process can have these names while the block runs.

    Raises:
        OutputError: As ``result_paths``, or another process is about to write them.
    """
    paths = result_paths(out, name)
    table = paths[0]
    busy = f"another process is about to write {table}; choose another path"
    with alone(table.with_name(f".{table.stem}.lock"), table, busy):
        yield result_paths(out, name)  # again, for another process may have ended in between


def write_results(paths: tuple[Path, Path], rows: Sequence[dict[str, Any]], config: Any, **more: Any) -> None:
    """Write ``rows`` to both files or to none; ``more`` goes into the JSON file beside config and versions.

    Args:
        paths: Table (CSV or parquet) and JSON document.
        rows: A mapping a row.
        config: What decided the run.
        more: What else goes into the JSON file, by name.

    Raises:
        OutputError: A file cannot be written.
    """
    table, document = paths
    contents = {"config": plain(config), "versions": versions(), **plain(more), "rows": plain(list(rows))}

    def write_rows(path: Path) -> None:
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)

    def write_both(path: Path) -> None:
        path.write_text(json.dumps(without_nan(contents), indent=1) + "\n")
        write_whole(table, write_rows)

    write_whole(document, write_both)


def number(value: float) -> str:
    """Five decimals, or one digit and the power of ten where these would hide it; a dash for NaN."""
    if value != value:
        return "-"
    if abs(value) < 1e-12:
        value = 0.0
    return f"{value:.1e}" if 0 < abs(value) < 0.001 else f"{value:.5f}"


def share(value: float) -> str:
    """Per cent."""
    return f"{value + 0.0 if abs(value) >= 0.0005 else 0:.1%}"


def bracket(interval: tuple[float, float]) -> str:
    """``[low, high]``, or a dash."""
    return "-" if interval[0] != interval[0] else f"[{number(interval[0])}, {number(interval[1])}]"


def without_nan(value: Any) -> Any:
    """JSON knows neither NaN nor infinity: null stands for the one, text for the other."""
    if isinstance(value, dict):
        return {key: without_nan(item) for key, item in value.items()}
    if isinstance(value, list):
        return [without_nan(item) for item in value]
    if isinstance(value, float) and value != value:
        return None
    return str(value) if isinstance(value, float) and value in (float("inf"), float("-inf")) else value
