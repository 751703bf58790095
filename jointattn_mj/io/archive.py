"""Arrays as .npy members of a zip file, read without pickle and without trusting what a header says."""

import errno
import io
import os
import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np

WITHOUT_POINTERS = "biufcSUMmV"
"""Kinds of dtype whose bytes are the values."""
_VERSIONS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


def write_array(archive: zipfile.ZipFile, name: str, array: np.ndarray) -> None:
    """Add ``array`` to ``archive``, not compressed; the same array gives the same bytes.

    Args:
        archive: ZIP file that is open for writing.
        name: Of the member.
        array: Of any shape, and of a dtype of plain data.

    Raises:
        TypeError: It is a subclass of ndarray, or holds Python objects or values without bytes.
    """
    if type(array) is not np.ndarray or not _is_plain(array.dtype):
        raise TypeError(f"an array of kind {type(array).__name__} and dtype {array.dtype} is no plain data")
    member = member_named(name)
    member.file_size = array.nbytes + 4096  # decides whether it needs the large form of a member
    with archive.open(member, "w") as file:
        np.lib.format.write_array(file, array, allow_pickle=False)


def read_array(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    """Read what ``write_array`` wrote, into memory of its own.

    Nothing is allocated before the size that the header asks for is that of the member.

    Raises:
        ValueError: It is no array, or not of the size that its header says.
    """
    member = archive.getinfo(name)
    with archive.open(member) as file:
        shape, in_columns, dtype = _header(file)
        count = _count(shape)
        if not _is_plain(dtype) or count * dtype.itemsize != member.file_size - file.tell():
            raise ValueError(f"{name} says that it holds {shape} of {dtype}, and has {member.file_size} bytes")
        flat = np.empty(count, dtype)
        into = memoryview(flat.view(np.uint8).data) if count else memoryview(bytearray())
        if file.readinto(into) != len(into) or file.read(1):  # type: ignore[attr-defined]
            raise ValueError(f"{name} is cut off")
    return flat.reshape(shape, order="F" if in_columns else "C")


def member_named(name: str) -> zipfile.ZipInfo:
    """A member that says neither when nor where it was written."""
    member = zipfile.ZipInfo(name)
    member.create_system = 3
    return member


def aligned(dtype: np.dtype) -> np.dtype:
    """A structured dtype as compiled code knows it: laid out the same, and flagged as aligned, which .npy drops.

    Raises:
        ValueError: Its fields are not where an aligned dtype has them.
    """
    fields: Any = dtype.fields or {}
    names = dtype.names or ()
    layout = {
        "names": list(names),
        "formats": [fields[name][0] for name in names],
        "offsets": [fields[name][1] for name in names],
        "itemsize": dtype.itemsize,
    }
    aligned: np.dtype = np.dtype(layout, align=True)  # type: ignore[call-overload]
    return aligned


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype]:
    version = np.lib.format.read_magic(file)
    if version not in _VERSIONS:
        raise ValueError(f"arrays in .npy format {version} are not read")
    return _VERSIONS[version](file)


def _count(shape: tuple[int, ...]) -> int:
    count = 1
    for length in shape:
        if type(length) is not int or length < 0:
            raise ValueError(f"{shape} is no shape")
        count *= length
    return count


def _is_plain(dtype: np.dtype) -> bool:
    return dtype.kind in WITHOUT_POINTERS and not dtype.hasobject and dtype.itemsize > 0


def content_of(path: Path) -> bytes:
    """All bytes of a file.

    Raises:
        OSError: It cannot be read, or is no regular file: a device or pipe may have no end.
    """
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, os.strerror(errno.EISDIR) if path.is_dir() else "It is no regular file")
    return path.read_bytes()


def archive_of(content: bytes, largest: int | None = None) -> zipfile.ZipFile:
    """Open a zip file, if its members are not larger than they may be.

    Args:
        content: The file.
        largest: Bytes that all members together can have; None: those of the file, since nothing is compressed.

    Raises:
        ValueError: It is no zip file, or one that has a member twice, or compressed or too large ones.
    """
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
    except zipfile.BadZipFile as error:
        raise ValueError(f"it is no zip file ({error})") from error
    members = archive.infolist()
    if len({member.filename for member in members}) < len(members):
        raise ValueError("a member is there twice")
    if largest is None and any(member.compress_type != zipfile.ZIP_STORED for member in members):
        raise ValueError("its members are compressed")
    most, total = len(content) if largest is None else largest, sum(member.file_size for member in members)
    if total > most:
        raise ValueError(f"its members have {total} bytes, more than {most}")
    return archive
