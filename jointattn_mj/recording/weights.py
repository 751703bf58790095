"""What a robot has learned, as one .npz of named arrays (no pickles: safe to share)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.errors import CheckpointError
from jointattn_mj.recording.files import write_whole


def write_weights(path: Path, weights: Mapping[str, Any]) -> None:
    """Write named arrays, whole or not at all."""
    write_whole(path, lambda temporary: np.savez_compressed(temporary, **weights))


def read_weights(path: Path) -> dict[str, np.ndarray]:
    """Read what ``write_weights`` wrote.

    Raises:
        CheckpointError: No such file, or not such a file.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            return dict(archive)
    except FileNotFoundError as error:
        raise CheckpointError(f"there are no weights at {path}; give the weights.npz of a finished session") from error
    except Exception as error:  # numpy, zipfile and zlib raise a dozen kinds here
        raise CheckpointError(f"{path} is not a weights.npz of this package ({error})") from error
