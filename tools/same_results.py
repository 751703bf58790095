"""Shows that a change of the code changes no result: every command and the first trial of every claim, value by value.

    python -m tools.same_results record before.json     # in the checkout before the change
    python -m tools.same_results record after.json      # in the checkout after it
    python -m tools.same_results compare before.json after.json

A record holds a digest of every column, array, figure and JSON value that the runs leave, but for times, versions and
the machine. ``RENAMED`` tells which names have changed since the record before; a value under its new name has to be
the value under its old one. Takes a quarter of an hour; ``--only`` runs some of it.
"""

import argparse
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import yaml

COMMANDS = {
    "session/state": "session --perception state --minutes 6 --seed 3 --out {out}",
    "session/no_cues": "session --perception state --minutes 6 --seed 4 --no-motion-cues --out {out}",
    "session/varied": "session --perception state --minutes 2 --variation all --out {out}",
    "session/pixels": "session --minutes 1 --seed 5 --out {out}",
    "session/video": "session --minutes 0.1 --seed 7 --start-from {session/pixels}/weights.npz --video --out {out}",
    "develop/thesis": "develop table --preset thesis --steps 20000 --seed 1 --out {out}",
    "develop/fast": "develop table --preset fast --steps 20000 --seed 2 --out {out}",
    "develop/chapter4": "develop table --preset chapter4 --steps 20000 --out {out}",
    "develop/face_avoiding": "develop table --steps 20000 --reactive face_avoiding --out {out}",
    "develop/rendered": "develop rendered --steps 3000 --seed 3 --out {out}",
    "develop/realtime": "develop realtime --minutes 2 --seed 3 --out {out}",
    "perceive": "perceive {session/video}/video.mp4 --out {out}",
    "play/oracle": "play follow --agent oracle --episodes 3 --out {out}/play",
    "play/gaze_follower": "play object_transfer --agent gaze_follower --episodes 1 --out {out}/play",
    "play/developer": "play turn_taking --agent developer --episodes 1 --out {out}/play",
    "measure": "measure {develop/fast}/steps.parquet --source \"caregiver's face\" --condition 'shift gaze' "
    "--target object --surrogates 99 --out {out}/measured",
    "discover": "discover {develop/fast}/steps.parquet --sensors \"caregiver's face\" 'object looked at' "
    "--actions 'shift gaze' gesture --results 'frontal face' object --surrogates 99 --out {out}/found",
}
"""Commands by a name that never changes; ``{NAME}`` stands for the folder of one that ran before."""
RENAMED: tuple[tuple[str, str], ...] = (
    (r"^state/", "truth/"),
    (r"^steps\.parquet", "turns.parquet"),
    (r"^(turns|contingency)\.parquet/step$", r"\1.parquet/turn"),
    (r"^frames\.parquet/perceived$", "frames.parquet/looked"),
    (r"^((?:frames|percepts|fixations)\.parquet/.*)visible$", r"\1seen"),
    (r"^percepts\.parquet/image$", "percepts.parquet/picture"),
    (r"images_read$", "pictures_read"),
    (r"late_success_rate$", "late_rate"),
    (r"successes_on_an_object$", "successes_on_something"),
    (r"gaze_shifts_by_learner$", "commanded_by_learner"),
    (r"^summary\.json/motion_detection", "summary.json/motion"),
    (r"face_missed_share$", "face_missed"),
    (r"median_px$", "p50"),
    (r"percentile_95_px$", "p95"),
    (r"share_above_8_px$", "above_8px"),
    (r"exploration_steps$", "turns_watched_before"),
    (r"^config\.yaml/config/state", "config.yaml/config/truth"),
    (r"^config\.yaml/config/(.*)holding_location", r"config.yaml/config/\1holding_place"),
    (r"^config\.yaml/config/(.*)rest_location", r"config.yaml/config/\1rest_place"),
    (r"location_gain$", "place_gain"),
    (r"^config\.yaml/config/agent", "config.yaml/config/mind"),
    (r"detector/stop_rule$", "detector/rule"),
    (r"detector/modelled$", "detector/claimed"),
    (r"detector/stability_of$", "detector/of"),
    (r"/calibration$", "/greeting"),
    (r"/exploration$", "/watching"),
    (r"detected_without_a_module", "found_without_a_module"),
    (r"minutes_when_detected", "minutes_when_found"),
)
"""What has been renamed since the record before: a pattern of names now, and what it was; in this order."""
UNTOLD = ("wall_seconds", "versions", "platform", "python", "system", "machine", "seconds", "created", "checkpoint.bin")
"""What may differ between two runs of the same code."""


def digest(value: bytes) -> str:
    """Sixteen digits of SHA-256."""
    return hashlib.sha256(value).hexdigest()[:16]


def named(path: str) -> str:
    """A part's name as the record before has it."""
    for now, before in RENAMED:
        path = re.sub(now, before, path)
    return path


def leaves(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Every value of a JSON document under its path, without those that may differ."""
    if isinstance(value, dict):
        for key, item in value.items():
            if key not in UNTOLD:
                yield from leaves(item, f"{path}/{key}")
    elif isinstance(value, list) and any(isinstance(item, (dict, list)) for item in value):
        for number, item in enumerate(value):
            yield from leaves(item, f"{path}/{number}")
    else:
        yield path, value


def parts(path: Path, name: str, scratch: str) -> Iterator[tuple[str, str]]:
    """What a file holds, a digest for each of its parts; ``scratch``, where runs work, does not count.

    Args:
        path: The file.
        name: Of the file in its run's folder.
        scratch: Folder where runs work.
    """
    if path.suffix == ".parquet":
        table = pq.read_table(path)
        for column in table.column_names:
            yield f"{name}/{column}", digest(json.dumps(table[column].to_pylist()).encode())
    elif path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as arrays:
            for key in arrays.files:
                kind = repr((arrays[key].dtype.str, arrays[key].shape))
                yield f"{name}/{key}", digest(kind.encode() + arrays[key].tobytes())
    elif path.suffix == ".json":
        for key, value in leaves(json.loads(path.read_text().replace(scratch, "")), name):
            yield key, digest(json.dumps(value).encode())
    elif path.suffix == ".yaml":
        for key, value in leaves(yaml.safe_load(path.read_text().replace(scratch, "")), name):
            yield key, digest(json.dumps(value, default=str).encode())
    else:
        yield name, digest(path.read_bytes())


def record_folder(folder: Path, scratch: str) -> dict[str, str]:
    """Digests of all that a command left in ``folder``, in ``scratch``."""
    digests: dict[str, str] = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_file() and path.name not in UNTOLD and not path.name.startswith("."):
            digests |= {named(part): value for part, value in parts(path, name, scratch)}
    return digests


def jointattn(arguments: list[str], **more: Any) -> subprocess.CompletedProcess[str]:
    """Run a command with the code of the working directory."""
    environment = {**os.environ, "PYTHONPATH": os.getcwd()}
    code = "import sys; from jointattn_mj.cli.main import main; sys.exit(main())"
    return subprocess.run([sys.executable, "-c", code, *arguments], env=environment, text=True, **more)


def record(to: Path, only: str) -> None:
    """Run everything and write the record."""
    records: dict[str, Any] = json.loads(to.read_text()) if to.exists() else {}
    needed = {name for name in COMMANDS if name.startswith(only)}
    for name in reversed(COMMANDS):  # what a command needs ran before it
        needed |= {before for before in COMMANDS if name in needed and f"{{{before}}}" in COMMANDS[name]}
    with tempfile.TemporaryDirectory() as scratch:
        folders = {name: Path(scratch) / name.replace("/", "_") for name in COMMANDS}
        for name, command in COMMANDS.items():
            if name not in needed:
                continue
            words = shlex.split(command.format(**{"out": folders[name], **folders}))
            ended = jointattn(words, capture_output=True)
            digests = record_folder(folders[name], scratch) if ended.returncode == 0 else {}
            _keep(records, to, name, digests, ended.stderr)
        from experiments.registry import REGISTRY

        for claim in REGISTRY:
            if not f"claim/{claim}".startswith(only):
                continue
            setting, folder = next(iter(REGISTRY[claim].settings)), Path(scratch) / f"claim_{claim}"
            words = ["experiment", "run", claim, "--setting", setting, "--runs", "1", "--jobs", "1"]
            ended = jointattn([*words, "--out", str(folder)], capture_output=True)
            results = [json.loads(path.read_text())["result"] for path in sorted(folder.rglob("trials/**/*.json"))]
            digests = {named(key): digest(json.dumps(value).encode()) for key, value in leaves(results, setting)}
            _keep(records, to, f"claim/{claim}", digests, ended.stderr)


def _keep(records: dict[str, Any], to: Path, name: str, digests: dict[str, str], said: str) -> None:
    """Add to the record what one command left, or how it failed, and say so."""
    records[name] = digests or {"failed": said[-300:]}
    print(f"{name}: {f'{len(digests)} parts' if digests else f'FAILED: {said[-300:]}'}", flush=True)
    to.write_text(json.dumps(records, indent=1) + "\n")


def compare(before: Path, after: Path) -> int:
    """Print what differs; the number of commands and claims that do."""
    old, new = json.loads(before.read_text()), json.loads(after.read_text())
    differing = 0
    for name in old:
        gone, come = old[name].keys() - new.get(name, {}).keys(), new.get(name, {}).keys() - old[name].keys()
        changed = [part for part in old[name].keys() & new.get(name, {}).keys() if old[name][part] != new[name][part]]
        differing += bool(gone or come or changed or "failed" in old[name])
        print(f"{name}: {len(old[name]) - len(gone) - len(changed)} of {len(old[name])} parts are the same")
        for what, which in (("differs", changed), ("is gone", gone), ("is new", come)):
            for part in sorted(which)[:12]:
                print(f"    {what}: {part}")
    print(f"{differing} of {len(old)} differ")
    return differing


def main() -> None:
    """Record or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record", help="run everything and write a record")
    recording.add_argument("to", type=Path)
    recording.add_argument("--only", default="", help="commands and claims whose names begin so, such as develop")
    comparing = commands.add_parser("compare", help="say what differs between two records")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    options = parser.parse_args()
    if options.command == "record":
        record(options.to, options.only)
    else:
        sys.exit(bool(compare(options.before, options.after)))


if __name__ == "__main__":
    main()
