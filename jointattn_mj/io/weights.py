"""What a robot has learned, as one .npz of named arrays (no pickles: safe to share)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.errors import CheckpointError
from jointattn_mj.guards.finite import not_finite
from jointattn_mj.io.archive import archive_of, content_of, read_array
from jointattn_mj.io.files import write_whole

LARGEST = 1 << 30
"""Bytes that are read at most; a robot of chapter 6 has half a million."""
MOST = 1e15
"""No weight is larger in size: the square of a much larger one overflows as float32."""


def write_weights(path: Path, weights: Mapping[str, Any]) -> None:
    """Write named arrays, whole or not at all."""
    write_whole(path, lambda temporary: np.savez_compressed(temporary, **weights))


def read_weights(path: Path) -> dict[str, np.ndarray]:
    """Read what ``write_weights`` wrote: arrays of real numbers by name, finite and not absurdly large.

    Raises:
        CheckpointError: No such file, not such a file, or other numbers.
    """
    try:
        archive = archive_of(content_of(path), LARGEST)
        names = archive.namelist()
        weights = {name.removesuffix(".npy"): read_array(archive, name) for name in names}
    except FileNotFoundError as error:
        raise CheckpointError(f"there are no weights at {path}; give the weights.npz of a finished session") from error
    except Exception as error:  # numpy, zipfile and zlib raise a dozen kinds here
        raise CheckpointError(f"{path} is not a weights.npz of this package ({error})") from error
    lost = not_finite(weights)
    odd = [name for name, array in weights.items() if name not in lost and not _are_weights(array)]
    for names, words in ((lost, "numbers that are not finite"), (odd, f"what is no real number up to {MOST:g}")):
        if names:
            raise CheckpointError(
                f"{path} holds {words} in {', '.join(names)}; give the weights.npz of a finished session"
            )
    return weights


def _are_weights(array: np.ndarray) -> bool:
    return array.dtype.kind in "biuf" and bool((np.abs(array.astype(float)) <= MOST).all())
