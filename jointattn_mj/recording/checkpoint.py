"""Checkpoints: a whole session in one file, safe against half-written bytes and against other runs' files.

A file is a line of magic, the SHA-256 of the rest, the fingerprint of the config, and a pickle. Loading unpickles only
classes of this package and of a module that the caller names, arrays and generators of numpy, and the standard
containers; nothing else is ever called.
"""

import hashlib
import io
import json
import pickle
from pathlib import Path
from typing import Any

from jointattn_mj.errors import CheckpointError
from jointattn_mj.recording.files import write_whole
from jointattn_mj.recording.provenance import plain

MAGIC = b"jointattn checkpoint 1\n"
_TRUSTED = {
    "builtins": {"set", "frozenset", "slice", "complex", "bytearray", "range"},
    "collections": {"deque", "defaultdict", "OrderedDict"},
    "pathlib": {"PosixPath", "WindowsPath"},
    "numpy": {
        "ndarray", "dtype", "_reconstruct", "_frombuffer", "scalar", "PCG64", "SeedSequence",
        "__generator_ctor", "__bit_generator_ctor", "__pyx_unpickle_SeedSequence",
    },
}  # fmt: skip
"""Names by the package they come from: numpy's modules move between versions, what they hold does not."""


def fingerprint(config: Any) -> str:
    """SHA-256 of a config's contents; 26 minutes and 26.0 are the same."""

    def number(text: str) -> float:
        return int(float(text)) if float(text).is_integer() else float(text)

    contents = json.loads(json.dumps(plain(config)), parse_float=number)
    return hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, own: str):
        super().__init__(file)
        self._own = own

    def find_class(self, module: str, name: str) -> Any:
        package = module.split(".")[0]
        if package == __package__.split(".")[0] or module == self._own:
            found = super().find_class(module, name)
            if isinstance(found, type) and found.__module__ == module:  # not what a module has imported from elsewhere
                return found
        elif name in _TRUSTED.get(package, ()):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} does not belong into a checkpoint")


def save(path: Path, state: Any, config: Any) -> None:
    """Write ``state``, whole or not at all.

    Raises:
        OutputError: The file cannot be written.
    """
    body = fingerprint(config).encode() + pickle.dumps(state, protocol=5)
    digest = hashlib.sha256(body).hexdigest().encode()
    write_whole(path, lambda temporary: temporary.write_bytes(MAGIC + digest + body))


def load(path: Path, config: Any, own: str = "") -> Any:
    """Read what ``save`` wrote for the same ``config``; ``own``: name of a module whose classes may be in it too.

    Raises:
        CheckpointError: No such file, damaged, or of another config.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError as error:
        raise CheckpointError(f"there is no checkpoint at {path}; run without --resume to begin a session") from error
    except OSError as error:
        raise CheckpointError(f"cannot read a checkpoint at {path}: {error.strerror}") from error
    digest, body = content[len(MAGIC) :][:64], content[len(MAGIC) + 64 :]
    if not content.startswith(MAGIC) or hashlib.sha256(body).hexdigest().encode() != digest:
        raise CheckpointError(f"{path} is damaged or no checkpoint; delete it and begin the session anew")
    if body[:64] != fingerprint(config).encode():
        raise CheckpointError(
            f"{path} belongs to a session with another config; resume with the options in config.yaml beside it, "
            "or choose another --out"
        )
    try:
        return _Unpickler(io.BytesIO(body[64:]), own).load()
    except Exception as error:  # what classes that have changed since make of an old state can be anything
        raise CheckpointError(f"{path} was written by another version of this package ({error})") from error
