"""Imports run downwards through the table of folders in CONTRIBUTING.md, those that name a module in a string too."""

import ast
import re
from collections.abc import Iterator

from sources import ROOT, parsed

PACKAGE = ROOT / "jointattn_mj"
ROW = re.compile(r"^\| (`[^|]+`[^|]*) \|", re.MULTILINE)
FORMER_NAMES = ("contingency", "jointattn_mj.recordings.reader")
"""``contingency`` still finds two names that have moved up to the top of the package."""


def layers() -> dict[str, int]:
    """Row of each folder in the table, from the top."""
    rows = [re.findall(r"`([\w.]+?)(?:/|\.py)`", row) for row in ROW.findall((ROOT / "CONTRIBUTING.md").read_text())]
    return {name: number for number, row in enumerate(rows) for name in row}


def modules_named(tree: ast.AST) -> Iterator[str]:
    """Dotted names of the package's modules that a file imports, at its top or later, or names in a string."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == PACKAGE.name:
            below = node.module.partition(".")[2]
            yield from [node.module] if below else [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.startswith(f"{PACKAGE.name}."))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from re.findall(rf"^{PACKAGE.name}\.[\w.]+$", node.value)


def upwards() -> list[str]:
    """Every import that does not run down, but those within a folder."""
    row, found = layers(), []
    for path, tree in parsed().items():
        if PACKAGE not in path.parents:
            continue
        own = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        for module in modules_named(tree) if own != "__init__" else ():
            other = module.split(".")[1]
            if other not in (own, "__version__") and row[other] <= row[own] and (own, module) != FORMER_NAMES:
                found.append(f"{path.relative_to(ROOT)} names {module}")
    return found


def test_the_table_has_every_folder():
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and any(path.glob("*.py"))}
    files = {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"}
    assert set(layers()) - {"experiments"} == folders | files


def test_imports_run_downwards():
    assert upwards() == []
