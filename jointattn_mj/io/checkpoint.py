"""Checkpoints: all that a run needs to go on, in one file of plain data.

A checkpoint is a zip file, not compressed, of ``header.json`` (which config it belongs to, and with which versions it
was written), ``state.json`` (objects as plain data, see ``codec``) and arrays as .npy. Its comment ends with the
SHA-256 of all that stands before: half-written and damaged files are noticed. The same state gives the same bytes,
whatever Python wrote it, and other versions of Python, numpy and mujoco read it.

Reading one runs no code of its author. Nothing is unpickled and no constructor is called; objects are of the classes
that ``parts`` lists, or of the module of the caller's own session class; options come from the caller's config, never
from the file; no size is believed before the file has as many bytes. What has to be trusted is only what the numbers
say: a file made up by somebody else can hold a robot that never lived. The digest protects against accidents, not
against forgers.
"""

import hashlib
import io
import json
import platform
import re
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from importlib import metadata
from pathlib import Path
from traceback import walk_tb
from typing import Any

import yaml

from jointattn_mj import __version__
from jointattn_mj.errors import CheckpointError, JointAttnError
from jointattn_mj.io.archive import archive_of, content_of, member_named, read_array, write_array
from jointattn_mj.io.codec import Decoder, Encoder
from jointattn_mj.io.files import write_whole
from jointattn_mj.io.parts import PACKAGE
from jointattn_mj.io.provenance import plain
from jointattn_mj.options import shown

FORMAT = 2
_PICKLED = b"jointattn checkpoint 1\n"
_DIGITS = 64
_COMMENT = re.compile(rb"jointattn checkpoint (\d+) sha256=[0-9a-f]{64}\Z")
_LONGEST_COMMENT = 128
_HEADER, _STATE = "header.json", "state.json"
_LARGEST_TEXT = 1 << 28
"""Bytes of the largest text that is read; a day of a session has some 2^25."""


def fingerprint(config: Any) -> str:
    """SHA-256 of a config's contents; 26 minutes and 26.0 are the same."""

    def number(text: str) -> float:
        return int(float(text)) if float(text).is_integer() else float(text)

    contents = json.loads(json.dumps(plain(config)), parse_float=number)
    return hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()


def save(path: Path, state: Any, config: Any, own: str = "") -> None:
    """Write ``state``, whole or not at all.

    Args:
        path: The file; what it held before stays if the new one cannot be written.
        state: Plain values, arrays, random generators, and objects of classes that ``parts`` lists.
        config: The run's; parts of it that are met in ``state`` are not written.
        own: Name of a module whose classes may be in ``state`` too.

    Raises:
        CheckpointError: Something in ``state`` cannot be written as data.
        OutputError: The file cannot be written.
    """
    encoder = Encoder(config, own)
    try:
        root = encoder.value(state)
        entries = json.dumps({"root": root, "entries": encoder.entries}, allow_nan=False)
        header = {"format": FORMAT, "config": fingerprint(config), "versions": _versions()}
        content = _archive(json.dumps(header, indent=1), entries, encoder.arrays)
    except JointAttnError:
        raise
    except (TypeError, ValueError, RecursionError) as error:
        raise CheckpointError(
            f"this run cannot be kept in a checkpoint: {error}; define classes of your own in the module of your "
            "session class, and let what cannot be kept be made anew by __getstate__ and __setstate__"
        ) from error
    write_whole(path, lambda temporary: temporary.write_bytes(content))


def load(
    path: Path,
    config: Any,
    own: str = "",
    *,
    kind: type | tuple[type, ...] = object,
    check: Callable[[Any], object] = lambda loaded: None,
) -> Any:
    """Read what ``save`` wrote for the same ``config``.

    Args:
        path: The file.
        config: The run's; what is restored refers to it.
        own: Name of a module whose classes may be in the file too.
        kind: What is expected: an object of this class, or a tuple of one object of each of these.
        check: Is called with what was read; whatever it raises says that this cannot be gone on with.

    Raises:
        CheckpointError: No such file, damaged, of another config, of another version, or not what is expected.
    """
    content = _checked(path)
    try:
        archive = archive_of(content)
        header = json.loads(_text(archive, _HEADER))
        if header["config"] != fingerprint(config):
            raise CheckpointError(_of_another_config(path, header["versions"], config))
        state = json.loads(_text(archive, _STATE))
        array = partial(_array, archive)
        loaded = Decoder(state["entries"], array, config, own).value(state["root"])
        if not _is(loaded, kind):
            raise ValueError(f"it holds {_called(loaded)}")
        check(loaded)
    except CheckpointError:
        raise
    except Exception as error:  # classes that check what they are given, zipfile and json raise dozens of kinds
        raise CheckpointError(
            f"{path} holds no run that this version can go on with ({_words(error)}){_written_by(content)}; go on with "
            "the version that wrote it, or begin the run anew"
        ) from error
    return loaded


@contextmanager
def gone_on_with(path: Path, resumed: bool, *parts: Any) -> Iterator[None]:
    """Name the checkpoint where the block breaks in a way that no code has foreseen.

    Not every number in a checkpoint is checked: one that was changed by hand can break a run much later.

    Args:
        path: The checkpoint.
        resumed: Whether the run in the block was read from it; nothing is done otherwise.
        parts: Classes and functions of the caller: what is raised in their modules passes as it is.

    Raises:
        CheckpointError: The run has broken so.
    """
    try:
        yield
    except (JointAttnError, OSError, MemoryError):
        raise
    except Exception as error:  # the kinds of compiled code, OpenCV and MuJoCo have nothing in common
        modules = {getattr(part, "__module__", "") for part in parts}
        met = {frame.f_globals.get("__name__", "") for frame, _ in walk_tb(error.__traceback__)}
        if not resumed or any(name in met and name.partition(".")[0] != PACKAGE for name in modules):
            raise
        said = f"{type(error).__name__}: {' '.join(str(error).split())[:200]}".removesuffix(": ")
        raise CheckpointError(
            f"{path} does not fit: the run that it holds cannot go on ({said}); begin anew in another folder, or "
            "report this as a fault of jointattn if nobody has changed the file"
        ) from error


def _of_another_config(path: Path, versions: dict[str, str], config: Any) -> str:
    """What is said of a checkpoint whose config has other contents than ``config``."""
    written = versions.get("jointattn_mj", __version__)
    if written != __version__:
        return (
            f"{path} was written by version {written} of jointattn-mj, and this version, {__version__}, cannot go on "
            "with it; go on with the version that wrote it, or begin the run anew in another folder"
        )
    try:
        there = yaml.safe_load((path.parent / "config.yaml").read_text("utf-8"))["config"]
        differing = _first_difference(there, plain(config))
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError):  # the file is a help, no more
        differing = None
    return (
        f"{path} belongs to a run with another config{f' ({differing})' if differing else ''}; resume with the options "
        "in config.yaml beside it, or choose another folder"
    )


def _first_difference(there: Any, here: Any, name: str = "") -> str | None:
    """``seed is 3 there and 5 here``, or None where nothing differs; groups are mappings."""
    if not (isinstance(there, dict) and isinstance(here, dict)):
        return None if there == here else f"{name} is {shown(there)} there and {shown(here)} here"
    parts = (_first_difference(there.get(key), value, f"{name}.{key}".removeprefix(".")) for key, value in here.items())
    return next((part for part in parts if part is not None), None)


def _archive(header: str, state: str, arrays: list[Any]) -> memoryview:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr(member_named(_HEADER), header)
        archive.writestr(member_named(_STATE), state)
        for number, array in enumerate(arrays):
            write_array(archive, _member(number), array)
        archive.comment = b"jointattn checkpoint %d sha256=" % FORMAT + b"0" * _DIGITS
    content = buffer.getbuffer()
    content[-_DIGITS:] = hashlib.sha256(content[:-_DIGITS]).hexdigest().encode()
    return content


def _checked(path: Path) -> bytes:
    """The bytes of a checkpoint that is whole.

    Raises:
        CheckpointError: No such file, damaged, or of another format.
    """
    try:
        content = content_of(path)
    except FileNotFoundError as error:
        raise CheckpointError(f"there is no checkpoint at {path}; run without `resume` to begin a session") from error
    except OSError as error:
        raise CheckpointError(f"cannot read a checkpoint at {path}: {error.strerror}") from error
    if content.startswith(_PICKLED):
        raise CheckpointError(
            f"{path} was written by an earlier version of this package, whose checkpoints could run code and are not "
            "read any more; go on with that version, or begin the run anew"
        )
    comment = _COMMENT.search(content[-_LONGEST_COMMENT:])
    digest = hashlib.sha256(memoryview(content)[:-_DIGITS]).hexdigest().encode()
    if comment is None or digest != content[-_DIGITS:]:
        raise CheckpointError(f"{path} is damaged or no checkpoint; delete it and begin the session anew")
    if int(comment[1]) != FORMAT:
        raise CheckpointError(
            f"{path} has format {int(comment[1])} of checkpoints, and this version reads format {FORMAT}; go on with "
            "the version that wrote it, or begin the run anew"
        )
    return content


def _text(archive: zipfile.ZipFile, name: str) -> str:
    size = archive.getinfo(name).file_size
    if size > _LARGEST_TEXT:
        raise ValueError(f"{name} has {size} bytes, more than {_LARGEST_TEXT}")
    return archive.read(name).decode()


def _array(archive: zipfile.ZipFile, number: int) -> Any:
    return read_array(archive, _member(number))


def _member(number: int) -> str:
    return f"{number}.npy"


def _is(value: Any, kind: type | tuple[type, ...]) -> bool:
    if isinstance(kind, tuple):
        return type(value) is tuple and len(value) == len(kind) and all(map(isinstance, value, kind))
    return isinstance(value, kind)


def _called(value: Any) -> str:
    return f"({', '.join(map(_called, value))})" if type(value) is tuple else type(value).__name__


def _words(error: Exception) -> str:
    """What an error says, in one line."""
    said = str(error) if isinstance(error, (ValueError, TypeError)) else f"{type(error).__name__} {error}"
    return " ".join(said.split())[:200]


def _written_by(content: bytes) -> str:
    try:
        given = json.loads(_text(archive_of(content), _HEADER))["versions"]
        there = _versions()
        other = [f"{name} {given[name]}" for name in there if given[name] != there[name]]
    except Exception:  # a header that says nothing is not worth a second error
        return ""
    return f"; it was written with {', '.join(other)}" if other else ""


@cache
def _versions() -> dict[str, str]:
    libraries = {name: metadata.version(name) for name in ("numpy", "mujoco")}
    return {"python": platform.python_version(), "jointattn_mj": __version__, **libraries}
