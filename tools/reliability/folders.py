"""What two folders of results differ in, but for time."""

import json
import re
from pathlib import Path

TIME = {"wall_seconds"}
"""Fields of JSON files that say how long something took."""
NOT_RESULTS = {
    r"checkpoint\..*": "holds how long the run has taken so far; what follows from it is compared",
    r"\..*\.lock|\.lock": "is empty; says who uses the folder",
}
"""Names of files that are not compared, and why."""


def contents(folder: Path) -> dict[str, bytes]:
    """Files by their path in the folder; of JSON files all but the time."""
    digests = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not any(re.fullmatch(name, path.name) for name in NOT_RESULTS):
            digests[str(path.relative_to(folder))] = _timeless(path)
    return digests


def _timeless(path: Path) -> bytes:
    raw = path.read_bytes()
    if path.suffix != ".json":
        return raw
    return json.dumps(_without_time(json.loads(raw)), sort_keys=True).encode()


def _without_time(value: object) -> object:
    if isinstance(value, dict):
        return {key: _without_time(part) for key, part in value.items() if key not in TIME}
    return [_without_time(part) for part in value] if isinstance(value, list) else value


def differences(before: dict[str, bytes], after: dict[str, bytes]) -> dict[str, int]:
    """Bytes that differ, by file; a file that is missing differs in all of its own, in one at least."""
    differing = {}
    for name in sorted(before.keys() | after.keys()):
        first, second = before.get(name, b""), after.get(name, b"")
        count = sum(a != b for a, b in zip(first, second, strict=False)) + abs(len(first) - len(second))
        if count or (name in before) != (name in after):
            differing[name] = max(count, 1)
    return differing
