"""README and docs from the first line to the last, as a reader types them, in one fresh folder.

What takes long is shortened by ``shortened``; what is not run is named in ``NOT_RUN``, and ``test_docs`` checks that it
could be typed.
"""

import importlib.util
import os
import shutil
import socket
import subprocess
import sys
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

import pytest
from documented import ROOT, Block, Command, blocks, commands, pages
from shell import Shell

pytestmark = pytest.mark.integration

NOT_RUN = {
    "installs, builds or tests": lambda words: words[0] in ("apt-get", "pip", "make", "pytest"),
    "shows something until it is closed": lambda words: words[0] == "rerun" or words[:2] == ("jointattn", "view"),
    "needs a camera": lambda words: words[:4] == ("jointattn", "session", "--world", "camera"),
    "takes half an hour": lambda words: words[:3] == ("python", "-m", "experiments.recorded.compare"),
    "writes into the checkout": lambda words: words[:3] == ("python", "-m", "experiments.pages"),
    "measures for minutes": lambda words: words[:2] == ("jointattn", "benchmark"),
    "tries for hours what can go wrong": lambda words: words[:3] == ("python", "-m", "tools.reliability"),
}
SHORT_CLAIM = "5.2"
"""Run in place of others."""
SECONDS = 300
PORT = "8786"
"""Stands for any free one."""


def shortened(command: Command) -> list[str]:
    """Arguments of ``jointattn`` for the same in seconds."""
    words = [*command.words[1:]]

    def at_most(option: str, value: float, always: bool = True) -> None:
        if option in words:
            location = words.index(option) + 1
            words[location] = str(min(type(value)(words[location]), value))
        elif always:
            words.extend([option, str(value)])

    match words[0]:
        case "session":
            at_most("--minutes", 0.01 if "--video" in words else 0.1)
            words += [] if "state" in words else ["--robot.familiarise.minutes", "0.03"]
        case "develop" if "realtime" in words:
            at_most("--minutes", 0.05)
            words += ["--realtime.familiarise-minutes", "0.1"]
        case "develop" if "rendered" in words:
            at_most("--steps", 4 if "--video" in words else 20)
            words += ["--rendered.exploration", "50"]
            words += ["--babbling.steps", "300"] if "growing" in words else []
        case "develop":
            at_most("--steps", 20_000)
            at_most("--checkpoint-every", 5_000, always=False)
        case "perceive":
            at_most("--max-minutes", 0.1 if "--looks" in words else 0.05)
        case "play":
            at_most("--episodes", 2)
            at_most("--time-limit", 0.5)
        case "measure" | "discover" | "recordings":
            at_most("--surrogates", 40)
        case "experiment" if words[1] == "run":
            ids = words[2 : next((location for location, word in enumerate(words) if word.startswith("--")), None)]
            if "--registry" not in words:
                words[2 : 2 + len(ids)] = [SHORT_CLAIM]
                at_most("--runs", 1)
            at_most("--jobs", 1)
    return words


def reason_not_to(command: Command) -> str | None:
    """Why a command is not run, if it is not."""
    if "--rerun" in command.words and importlib.util.find_spec("rerun") is None:
        return "needs the extra rerun"
    return next((reason for reason, holds in NOT_RUN.items() if holds(command.words)), None)


def documented() -> list[Command]:
    """Every command, in reading order."""
    shells = (block for page in guides() for block in blocks(page) if block.language != "python")
    return [command for block in shells for command in commands(block)]


def guides() -> list[Path]:
    """Pages that say what to type; those of experiments/ say what came out, in hours."""
    return [page for page in pages() if page.relative_to(ROOT).parts[0] != "experiments"]


def clone_into(folder: Path) -> None:
    """Copy the files of this checkout that git knows; in an archive that has no history, all of its folders."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    names = listed.stdout.split("\0")[:-1] if listed.returncode == 0 else []
    if not names:
        parts = ("jointattn_mj", "assets", "experiments", "docs")
        names = [str(path.relative_to(ROOT)) for part in parts for path in (ROOT / part).rglob("*") if path.is_file()]
    for name in names:
        if (ROOT / name).is_file() and not name.startswith("tests/"):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)


def free_port() -> str:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return str(listener.getsockname()[1])


class Reader:
    """Somebody who types everything."""

    def __init__(self, folder: Path, shell: Shell, background: ExitStack):
        self.folder, self._shell, self._background = folder, shell, background
        self._port = free_port()
        self.troubles: list[str] = []

    def read(self, block: Block, namespace: dict) -> None:
        """Type what a block says."""
        if block.language == "python":
            try:
                exec(compile(block.text, block.location, "exec"), namespace)
            except Exception as error:
                self.troubles.append(f"{block.location}: {type(error).__name__}: {error}")
            return
        for command in commands(block):
            if command.background:
                self._start(command)
            elif reason_not_to(command) is None:
                self._run(command)

    def _run(self, command: Command) -> None:
        arguments = [word.replace(PORT, self._port) for word in shortened(command)]
        outcome = self._shell(*arguments, seconds=SECONDS)
        if outcome.code or "Traceback" in outcome.err + outcome.out:
            self.troubles.append(f"{command}\n  ended with {outcome.code}: {outcome.err[-2000:]}")

    def _start(self, command: Command) -> None:
        program, *arguments = [word.replace(PORT, self._port) for word in command.words]
        started = subprocess.Popen(
            [str(Path(sys.executable).with_name(program)), *arguments],
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._background.callback(started.wait)
        self._background.callback(started.terminate)


def test_every_command_in_reading_order(tmp_path, monkeypatch):
    clone_into(tmp_path)
    with ExitStack() as background:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "path", [*sys.path])
        shell = Shell(tmp_path)
        background.callback(shell.close)
        reader = Reader(tmp_path, shell, background)
        for page in guides():
            module = ModuleType("page")  # of which the page's classes can be, as checkpoints need
            monkeypatch.setitem(sys.modules, "page", module)
            for block in blocks(page):
                reader.read(block, vars(module))
    assert not reader.troubles, "\n".join(["", *reader.troubles])


def test_no_two_commands_write_to_the_same_folder():
    """But for experiments, which add to theirs, and runs that go on."""
    written = [command.option("--out") for command in documented() if not {"experiment", "--resume"} & {*command.words}]
    assert [folder for folder, times in Counter(filter(None, written)).items() if times > 1] == []


def test_what_is_resumed_and_reported_was_begun_before():
    begun: set[str | None] = set()
    for command in documented():
        if "--resume" in command.words:
            assert command.option("--out") in begun, command
        begun.add(command.option("--out"))


def test_nothing_is_left_out_for_a_reason_that_has_gone():
    typed = documented()
    for reason, holds in NOT_RUN.items():
        assert any(holds(command.words) for command in typed), reason


def test_most_commands_are_run():
    asked = [command for command in documented() if command.words[0] == "jointattn" and command.words[1] != "view"]
    run = [command for command in asked if reason_not_to(command) is None]
    assert len(run) > 30 and len(run) > 0.6 * len(asked)
