"""Trials on disk: one JSON file each, named after a hash of all that went into it, there whole or not at all.

    <folder>/cells/<claim>/<key>.json      a finished cell: what it was computed from, its result, versions, wall time
    <folder>/failed/<claim>/<key>.json     a trial that failed: the error, its traceback; gone once it has succeeded

Several runs may use one folder at once: they can only write the same file twice.
"""

import hashlib
import json
import math
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from jointattn_mj.errors import OutputError, TrialError
from jointattn_mj.io.files import write_whole
from jointattn_mj.io.lock import locked
from jointattn_mj.io.provenance import plain
from jointattn_mj.sweeps.claim import Claim, Setting, Trial, Trials

END = b"\n}\n"
UNREADABLE = (OSError, ValueError, KeyError, TypeError, RecursionError)
"""What reading a file can end in that is damaged, or something else under its name."""
ABANDONED_S = 3600.0
"""A temporary file as old as this was left by a process that was killed."""


NAMES_IN_KEYS = {
    "agent": "mind", "holding_location": "holding_place", "rest_location": "rest_place", "location_gain": "place_gain",
    "agent_steps": "mind_turns", "images": "pictures", "image_height": "picture_height", "calibration": "greeting",
    "exploration": "watching", "modelled": "claimed", "stop_rule": "rule", "stability_of": "of",
}  # fmt: skip
"""Fields of configs that have been renamed, by their name now. Keys and stored configs keep the first name, so that
trials stored before are found."""


CHOICES_IN_KEYS = {
    "perception": {"state": "truth"},
    "stop_rule": {"convergence": "still", "confidence": "certain"},
    "modelled": {"keep": "block"},
    "history": {"since_creation": "made", "full": "ever"},
}
"""Choices of fields that have been renamed, by field and choice as they are called now; likewise."""


def config_text(config: Any) -> str:
    """The config of a setting as the JSON text that the keys of its trials are made of."""
    return text_of(_with_first_names(plain(config)))


def _with_first_names(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_first_names(item) for item in value]
    if not isinstance(value, dict):
        return value
    named = {NAMES_IN_KEYS.get(name, name): _first_choice(name, item) for name, item in value.items()}
    if isinstance(named.get("state"), dict):
        named["truth"] = named.pop("state")
    return named


def _first_choice(name: str, value: Any) -> Any:
    """The value of a field, by the first name of what was chosen."""
    return CHOICES_IN_KEYS.get(name, {}).get(value, value) if isinstance(value, str) else _with_first_names(value)


def text_of(value: Any) -> str:
    """``value`` as the one JSON text that it has: plain data, keys in order, null for NaN.

    Raises:
        CellError: Something in it is no plain data, or infinite.
    """
    try:
        return json.dumps(_finite(plain(value)), sort_keys=True, allow_nan=False, separators=(",", ":"))
    except TypeError as error:
        raise TrialError(f"expected numbers, strings, lists and dicts, None for what is missing; {error}") from error


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        if math.isnan(value):
            return None
        raise TrialError(f"expected finite numbers, for JSON has no others; got {value}; say None for what never came")
    return value


@dataclass(frozen=True)
class PlannedTrial:
    """A trial to compute."""

    claim: Claim
    name: str
    """Id of the setting."""
    setting: Setting
    seed: int
    key: str

    def __str__(self) -> str:
        return f"{self.claim.id} {self.name} seed {self.seed}"


class Keys:
    """Names of the files of a claim's trials; the resolved config of each setting is written out once."""

    def __init__(self, claim: Claim):
        self.claim = claim
        self.configs = {name: config_text(setting.config) for name, setting in claim.settings.items()}

    def key(self, name: str, seed: int) -> str:
        """Of the trial with this setting and seed."""
        return key_of(self.claim.id, self.claim.version, self.configs[name], seed)

    def tasks(self, names: Sequence[str], seeds: Mapping[str, range]) -> Iterator[PlannedTrial]:
        """Trials of these settings, all with their first seed, then all with their second..."""
        for place in range(max((len(seeds[name]) for name in names), default=0)):
            for name in names:
                if place < len(seeds[name]):
                    seed = seeds[name][place]
                    yield PlannedTrial(self.claim, name, self.claim.settings[name], seed, self.key(name, seed))

    @cached_property
    def settings(self) -> dict[str, list[str]]:
        """Ids of settings by their config: two that are the same share their trials."""
        found: dict[str, list[str]] = {}
        for name, config in self.configs.items():
            found.setdefault(config, []).append(name)
        return found


def key_of(claim: str, version: int, config: str, seed: int) -> str:
    """32 hexadecimal digits of a hash over all that a trial's result depends on."""
    return hashlib.sha256(f"{claim}\n{version}\n{seed}\n{config}".encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Stored:
    """What a folder holds of a claim."""

    trials: Trials
    versions: tuple[dict[str, str], ...]
    """Every combination of versions that a trial was computed with."""
    others: int
    """Trials of another version of the claim, or of settings that it has no more."""
    damaged: tuple[Path, ...]
    """Files that hold no trial."""


class Store:
    """A folder of trials."""

    def __init__(self, folder: Path):
        self.folder = folder

    def prepare(self, claim: str) -> None:
        """Make the folders, and forget what killed processes left half written.

        Raises:
            OutputError: They cannot be made.
        """
        for folder in (self._trials(claim), self._failed(claim)):
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise OutputError(f"cannot make the folder {folder}: {error.strerror}; choose another --out") from error
            for path in folder.glob(".*"):
                with suppress(OSError):  # another run has just put it in place, or it may only be read
                    if time.time() - path.stat().st_mtime > ABANDONED_S:
                        path.unlink()

    @contextmanager
    def berth(self) -> Iterator[int]:
        """While the block runs: how many other runs use the folder that began before this one, or a number that one of
        them has left free. It is given up by a killed process too; 0 where the file system knows no locks."""
        place = 0
        with ExitStack() as locks:
            with suppress(OSError):
                while not locks.enter_context(locked(self.folder / f".run{place}.lock")):
                    place += 1
            yield place

    def path(self, task: PlannedTrial) -> Path:
        """Where the trial is, or will be."""
        return self._trials(task.claim.id) / f"{task.key}.json"

    def has(self, task: PlannedTrial) -> bool:
        """Whether the trial is there, down to its last line."""
        return _is_whole(self.path(task))

    def known(self, claim: str) -> frozenset[str]:
        """Keys of all whole trials of a claim; of another version too."""
        return frozenset(Path(entry.name).stem for entry in _files(self._trials(claim)) if _is_whole(entry))

    def write(self, task: PlannedTrial, result: str, **beside: Any) -> None:
        """Store a trial, ``result`` as JSON text; ``beside`` are facts about how it was computed.

        Raises:
            OutputError: The file cannot be written.
        """
        facts = {"claim": task.claim.id, "version": task.claim.version, "setting": task.name, "seed": task.seed}
        lines = [f'"{name}": {text_of(value)}' for name, value in {**facts, **beside}.items()]
        lines[4:4] = [f'"config": {config_text(task.setting.config)}', f'"result": {result}']
        text = "{\n" + ",\n".join(lines) + END.decode()
        write_whole(self.path(task), lambda path: path.write_text(text))
        with suppress(OSError):
            self._failure(task).unlink(missing_ok=True)

    def write_failure(self, task: PlannedTrial, error: str, traceback: str, alone: str) -> None:
        """Note why a trial failed and the command that runs it alone.

        Raises:
            OutputError: The file cannot be written.
        """
        facts = {
            "claim": task.claim.id, "setting": task.name, "seed": task.seed, "error": error, "alone": alone,
            "traceback": traceback.splitlines(),
        }  # fmt: skip
        write_whole(self._failure(task), lambda path: path.write_text(json.dumps(facts, indent=1) + "\n"))

    def failures(self, claim: str) -> list[dict[str, Any]]:
        """Failed trials, by setting and seed; of a note that is damaged no more is known than its file."""
        found = [_failure(Path(entry)) for entry in _files(self._failed(claim))]
        return sorted(found, key=lambda failure: (failure["setting"], failure["seed"]))

    def read(self, claim: Claim) -> Stored:
        """All stored trials of a claim that belong to its settings as they are now."""
        keys, others, damaged = Keys(claim), 0, []
        trials: dict[str, list[Trial]] = {name: [] for name in claim.settings}
        versions = set()
        for entry in _files(self._trials(claim.id)):
            try:
                stored = json.loads(Path(entry).read_bytes())
                config, seed, result = text_of(stored["config"]), stored["seed"], stored["result"]
                made_with = {**stored.get("versions", {}), "python": stored.get("python", "unknown")}
                if key_of(claim.id, stored["version"], config, seed) != Path(entry.name).stem:
                    raise ValueError("not the trial that its name says")
            except UNREADABLE:
                damaged.append(Path(entry))
                continue
            names = keys.settings.get(config, []) if stored["version"] == claim.version else []
            others += not names
            for name in names:
                trials[name].append(Trial(name, seed, result))
            if names:
                versions.add(tuple((package, str(number)) for package, number in made_with.items()))
        found = {name: sorted(part, key=lambda trial: trial.seed) for name, part in trials.items() if part}
        return Stored(found, tuple(dict(one) for one in sorted(versions)), others, tuple(sorted(damaged)))

    def _trials(self, claim: str) -> Path:
        return self.folder / "cells" / claim

    def _failed(self, claim: str) -> Path:
        return self.folder / "failed" / claim

    def _failure(self, task: PlannedTrial) -> Path:
        return self._failed(task.claim.id) / f"{task.key}.json"


def _failure(path: Path) -> dict[str, Any]:
    try:
        noted = json.loads(path.read_bytes())
        return {**noted, "setting": str(noted["setting"]), "seed": int(noted["seed"])}
    except UNREADABLE:
        return {"setting": "unknown", "seed": -1, "error": f"its note {path.name} cannot be read", "damaged": path}


def _files(folder: Path) -> list[os.DirEntry[str]]:
    """Files that are there whole: no temporary ones; nothing where there is no folder.

    Raises:
        OutputError: There is something else, or it may not be read.
    """
    try:
        with os.scandir(folder) as entries:
            return [entry for entry in entries if entry.name.endswith(".json") and not entry.name.startswith(".")]
    except FileNotFoundError:
        return []
    except OSError as error:
        raise OutputError(f"{folder} is no folder of results that can be read: {error.strerror}") from error


def _is_whole(path: Path | os.DirEntry[str]) -> bool:
    """Whether the file ends as :meth:`Store.write` ends it: a machine that lost power can leave less."""
    try:
        with open(path, "rb") as file:
            file.seek(-len(END), os.SEEK_END)
            return file.read() == END
    except OSError:
        return False
