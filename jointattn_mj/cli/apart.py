"""A command of ``jointattn`` in a process of its own, which runs as one that is typed in a shell."""

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

CODE = "import sys; from jointattn_mj.cli.main import main; sys.exit(main())"


def command(words: Sequence[str]) -> list[str]:
    """What to start: this Python, and this package wherever it lies, given ``environment``; ``words`` follow."""
    return [sys.executable, "-c", CODE, *words]


def environment(others: Mapping[str, str] | None = None) -> dict[str, str]:
    """Variables of this process, and with them ``others`` or in their place; compiled code is stored."""
    package = str(Path(__file__).parents[2])
    paths = os.pathsep.join([package, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "", **(others or {})}
