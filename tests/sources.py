"""Source files of the package, the experiments and the tools, parsed once a process for all tests that read them."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]


@cache
def parsed() -> dict[Path, ast.Module]:
    """Trees by path, which tests only read."""
    folders = [ROOT / name for name in ("jointattn_mj", "experiments", "tools")]
    paths = [path for folder in folders for path in sorted(folder.rglob("*.py"))]
    return {path: ast.parse(path.read_text("utf-8")) for path in paths}
