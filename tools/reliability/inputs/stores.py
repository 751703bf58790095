"""Folders of experiments of which a file is damaged."""

import random
import shutil
from collections.abc import Iterator
from pathlib import Path

from tools.reliability.inputs.damage import damaged, write
from tools.reliability.malformed import Input
from tools.shell import Shell


def inputs(shell: Shell, chance: random.Random, many: int, folder: Path) -> Iterator[Input]:
    """Folders of experiments of which a file is damaged, for ``list`` and ``report``.

    Args:
        shell: Runs commands.
        chance: Draws what is damaged, and how.
        many: Number of inputs.
        folder: For their files.
    """
    run = ("experiment", "run", "5.2", "--setting", "robot first", "--runs", "2", "--jobs", "1")
    shell(*run, "--out", folder / "good")
    for number in range(many):
        out = folder / f"store{number}"
        shutil.copytree(folder / "good", out)
        (trial := sorted(out.glob("trials/*/*.json"))[0]).with_name("odd.json").write_text("{}")
        if number % 3 == 0:
            note = write(out / "failed" / "5.2" / f"{'a' * 32}.json", b'{"setting": "robot first", "seed": 1}')
            path = note
        else:
            path = trial
        what, made = damaged(path.read_bytes(), chance)
        if number % 4 == 3:
            path.unlink()
            path.mkdir()
            what = "a folder"
        else:
            path.write_bytes(made)
        command = (("experiment", "list", "--out", str(out)), ("experiment", "report", str(out)))[number % 2]
        yield Input("stored trials", f"{command[1]}: {path.parent.parent.name} {what}", command)
