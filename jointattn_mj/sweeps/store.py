"""Trials on disk: one JSON file each, named after a hash of all that went into it, there whole or not at all.

    <folder>/trials/<claim>/<key>.json     a finished trial: claim, setting, seed, config, result, versions, wall time
    <folder>/failed/<claim>/<key>.json     a trial that failed: error and traceback; deleted once it has succeeded

Folders of version 0.1 call the first ``cells``; they are read, and runs in them go on there. Several runs may use one
folder at once: two that compute the same trial write the same file.
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
from jointattn_mj.io.files import make_folder, write_whole
from jointattn_mj.io.lock import locked
from jointattn_mj.io.provenance import plain
from jointattn_mj.sweeps.claim import Claim, Setting, Trial, Trials

END = b"\n}\n"
UNREADABLE = (OSError, ValueError, KeyError, TypeError, RecursionError)
"""Errors of reading a file that is damaged, or that holds something else."""
ABANDONED_S = 3600.0
"""Age at which a temporary file counts as left behind by a killed process."""
TRIALS, FORMER_TRIALS = "trials", "cells"
"""Names of the folder of finished trials: now, and in version 0.1."""
NAMES_IN_KEYS = {
    "agent": "mind", "holding_location": "holding_place", "rest_location": "rest_place", "location_gain": "place_gain",
    "agent_steps": "mind_turns", "images": "pictures", "image_height": "picture_height", "calibration": "greeting",
    "exploration": "watching", "n_steps": "turns", "modelled": "claimed", "stop_rule": "rule", "stability_of": "of",
}  # fmt: skip
"""Renamed fields of configs: name now, name when trials were first stored. Keys and stored configs keep the first name,
so that trials stored before are found. A new row here belongs to every renaming of such a field."""


CHOICES_IN_KEYS = {
    "perception": {"state": "truth"},
    "stop_rule": {"convergence": "still", "confidence": "certain"},
    "modelled": {"keep": "block"},
    "history": {"since_creation": "made", "full": "ever"},
    "looks_at": {"location": "place"},
}
"""Choices of fields that have been renamed, by field and choice as they are called now; likewise."""

ADDED: dict[str, dict[str, Any]] = {
    "": {"patch_side": None, "knows_delay": True},
    "config": {"knows_delay": True},
    "learner": {"pairs": "reached", "base": "none", "competition": 0.0, "compete_after": 10, "forgetting": 0.0,
                "smoothing": 0.05},
    "world": {"wrong": 0.0, "profile_shows": "gaze", "draws": "all", "renderer": "opengl",
              "dynamics": "mujoco", "least_turned": 0},
    "table": {"wrong": 0.0, "profile_shows": "gaze"},
    "rendered": {"least_turned": 0, "draws": "all"},
    "senses": {"frontal_likeness": 0.0},
    "local": {"waits_deviations": 0.0},
    "robot": {"face_at": "found",
              "mean_face": {"subtracted": False, "every": 3, "known": 20, "most": 1800}},
    "gaze": {"gate_sharpness": 3.0, "commands": "direction", "wait_for_still_face": False, "read_again": False},
}  # fmt: skip
"""Fields that configs have got since trials were first stored, by the field that holds the config, with the values at
which trials are what they were; keys and stored configs leave them out then. The setting's own config is held by "".
A new field of a config belongs here."""


def config_text(config: Any) -> str:
    """The config of a setting as JSON text, with the names of fields that keys are made of."""
    return text_of(_with_first_names(_without_added("", plain(config))))


def _with_first_names(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_first_names(item) for item in value]
    if not isinstance(value, dict):
        return value
    named = {
        NAMES_IN_KEYS.get(name, name): _first_choice(name, _without_added(name, item)) for name, item in value.items()
    }
    if isinstance(named.get("state"), dict | list):
        named["truth"] = named.pop("state")
    return named


def _without_added(name: str, value: Any) -> Any:
    """The value of a field, as it was before there were the fields in ``ADDED``, or stop rule local."""
    if not isinstance(value, dict):
        return value
    added = ADDED.get(name, {})
    unused = {"local"} if value.get("detector", {}).get("stop_rule") != "local" else set[str]()
    return {key: item for key, item in value.items() if key not in unused and (key not in added or item != added[key])}


def _first_choice(name: str, value: Any) -> Any:
    """The value of a field, by the first name of what was chosen."""
    return CHOICES_IN_KEYS.get(name, {}).get(value, value) if isinstance(value, str) else _with_first_names(value)


def text_of(value: Any) -> str:
    """``value`` as JSON text, the same for equal values: keys sorted, null for NaN.

    Raises:
        TrialError: ``value`` holds an infinite number, or an object that JSON has no form for.
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
        raise TrialError(f"expected finite numbers, for JSON has no others; got {value}; use None for a missing value")
    return value


@dataclass(frozen=True)
class PlannedTrial:
    """A trial to compute: a claim's setting with a seed."""

    claim: Claim
    name: str
    """Id of the setting."""
    setting: Setting
    seed: int
    key: str

    def __str__(self) -> str:
        return f"{self.claim.id} {self.name} seed {self.seed}"


class Keys:
    """File names (keys) of a claim's trials. The config of each setting is turned into text once."""

    def __init__(self, claim: Claim):
        self.claim = claim
        self.configs = {name: config_text(setting.config) for name, setting in claim.settings.items()}

    def key(self, name: str, seed: int) -> str:
        """Key of the trial with this setting and seed."""
        return key_of(self.claim.id, self.claim.version, self.configs[name], seed)

    def tasks(self, names: Sequence[str], seeds: Mapping[str, range]) -> Iterator[PlannedTrial]:
        """Trials of these settings: the first seed of each, then the second seed of each, and so on.

        Args:
            names: Ids of settings.
            seeds: Seeds of each of them.
        """
        for index in range(max((len(seeds[name]) for name in names), default=0)):
            for name in names:
                if index < len(seeds[name]):
                    seed = seeds[name][index]
                    yield PlannedTrial(self.claim, name, self.claim.settings[name], seed, self.key(name, seed))

    @cached_property
    def settings(self) -> dict[str, list[str]]:
        """Ids of settings by the text of their config. Settings with equal configs share their trials."""
        ids: dict[str, list[str]] = {}
        for name, config in self.configs.items():
            ids.setdefault(config, []).append(name)
        return ids


def key_of(claim: str, version: int, config: str, seed: int) -> str:
    """Hash over all that a trial's result depends on, as 32 hexadecimal digits.

    Args:
        claim: Id of the claim.
        version: The claim's version.
        config: Text of the setting's config, see :func:`config_text`.
        seed: Seed of the trial.
    """
    return hashlib.sha256(f"{claim}\n{version}\n{seed}\n{config}".encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Stored:
    """The trials of a claim that a folder holds."""

    trials: Trials
    versions: tuple[dict[str, str], ...]
    """The combinations of package versions that trials were computed with."""
    others: int
    """Number of trials of another version of the claim, or of settings that it no longer has."""
    damaged: tuple[Path, ...]
    """Files that hold no trial."""

    def __repr__(self) -> str:
        counts = ", ".join(f"{name}: {len(trials)}" for name, trials in self.trials.items())
        return f"Stored({counts or 'nothing'}; {self.others} others, {len(self.damaged)} damaged)"


class Store:
    """A folder of trials."""

    def __init__(self, folder: Path):
        self.folder = folder

    def __repr__(self) -> str:
        return f"Store({str(self.folder)!r})"

    def prepare(self, claim: str) -> None:
        """Make a claim's folders, and delete half-written files of killed processes.

        Raises:
            OutputError: A folder cannot be made.
        """
        for folder in (self._trials(claim), self._failed(claim)):
            make_folder(folder)
            for path in folder.glob(".*"):
                with suppress(OSError):  # another run has just renamed the file, or the folder is read-only
                    if time.time() - path.stat().st_mtime > ABANDONED_S:
                        path.unlink()

    @contextmanager
    def berth(self) -> Iterator[int]:
        """Hold the lowest free number among the runs that use the folder now, from 0 on.

        The number is free again when the block ends or the process is killed. It is 0 on a file system without locks.
        """
        number = 0
        with ExitStack() as locks:
            with suppress(OSError):
                while not locks.enter_context(locked(self.folder / f".run{number}.lock")):
                    number += 1
            yield number

    def path(self, task: PlannedTrial) -> Path:
        """File of the trial, whether it is there or not."""
        return self._trials(task.claim.id) / f"{task.key}.json"

    def has(self, task: PlannedTrial) -> bool:
        """Whether the trial's file is there and whole."""
        return _is_whole(self.path(task))

    def known(self, claim: str) -> frozenset[str]:
        """Keys of all whole trials of a claim, those of other versions included."""
        return frozenset(Path(entry.name).stem for entry in _files(self._trials(claim)) if _is_whole(entry))

    def write(self, task: PlannedTrial, result: str, **beside: Any) -> None:
        """Store a finished trial.

        Args:
            task: The trial.
            result: Its result as JSON text.
            beside: Facts about the computation, such as versions and wall time.

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
        """Store the note of a failed trial.

        Args:
            task: The trial.
            error: The error in one line.
            traceback: Its traceback.
            alone: The command that runs this trial alone.

        Raises:
            OutputError: The file cannot be written.
        """
        facts = {
            "claim": task.claim.id, "setting": task.name, "seed": task.seed, "error": error, "alone": alone,
            "traceback": traceback.splitlines(),
        }  # fmt: skip
        write_whole(self._failure(task), lambda path: path.write_text(json.dumps(facts, indent=1) + "\n"))

    def failures(self, claim: str) -> list[dict[str, Any]]:
        """Notes of failed trials, sorted by setting and seed. A damaged note has its path under ``damaged``."""
        notes = [_failure(Path(entry)) for entry in _files(self._failed(claim))]
        return sorted(notes, key=lambda note: (note["setting"], note["seed"]))

    def read(self, claim: Claim) -> Stored:
        """Read all stored trials that belong to the present settings of a claim."""
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
        by_seed = {name: sorted(part, key=lambda trial: trial.seed) for name, part in trials.items() if part}
        return Stored(by_seed, tuple(map(dict, sorted(versions))), others, tuple(sorted(damaged)))

    def _trials(self, claim: str) -> Path:
        former = (self.folder / FORMER_TRIALS).is_dir() and not (self.folder / TRIALS).exists()
        return self.folder / (FORMER_TRIALS if former else TRIALS) / claim

    def _failed(self, claim: str) -> Path:
        return self.folder / "failed" / claim

    def _failure(self, task: PlannedTrial) -> Path:
        return self._failed(task.claim.id) / f"{task.key}.json"


def _failure(path: Path) -> dict[str, Any]:
    try:
        note = json.loads(path.read_bytes())
        return {**note, "setting": str(note["setting"]), "seed": int(note["seed"])}
    except UNREADABLE:
        return {"setting": "unknown", "seed": -1, "error": f"its note {path.name} cannot be read", "damaged": path}


def _files(folder: Path) -> list[os.DirEntry[str]]:
    """JSON files of a folder, without temporary ones; none where the folder is missing.

    Raises:
        OutputError: ``folder`` is no folder, or cannot be read.
    """
    try:
        with os.scandir(folder) as entries:
            return [entry for entry in entries if entry.name.endswith(".json") and not entry.name.startswith(".")]
    except FileNotFoundError:
        return []
    except OSError as error:
        raise OutputError(f"{folder} is no folder of results that can be read: {error.strerror}") from error


def _is_whole(path: Path | os.DirEntry[str]) -> bool:
    """Whether the file ends as :meth:`Store.write` ends it. A loss of power can leave a part of a file."""
    try:
        with open(path, "rb") as file:
            file.seek(-len(END), os.SEEK_END)
            return file.read() == END
    except OSError:
        return False
