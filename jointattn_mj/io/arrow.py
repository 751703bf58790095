"""Arrow's arrays of numpy's and of words.

``pyarrow.array`` imports pandas where that is installed, whatever it is given: .3 s and 50 MiB. What computes with
arrays imports ``pyarrow.compute``: .03 s.
"""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa


def number_array(values: np.ndarray, missing: np.ndarray | None = None) -> pa.Array:
    """Numbers or truth values (n,) as they are, null where ``missing`` (n,) bool."""
    held = _bits(values) if values.dtype == bool else pa.py_buffer(np.ascontiguousarray(values))
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), len(values), [_known(missing), held])


def word_array(texts: Sequence[str] | np.ndarray, missing: np.ndarray | None = None) -> pa.StringArray:
    """Texts (n,), null where ``missing`` (n,) bool."""
    encoded = [str(text).encode() for text in texts]
    ends, held = np.cumsum([0, *map(len, encoded)], dtype=np.int32), b"".join(encoded)
    return pa.StringArray.from_buffers(len(encoded), pa.py_buffer(ends), pa.py_buffer(held), _known(missing))


def _known(missing: np.ndarray | None) -> pa.Buffer | None:
    return None if missing is None or not missing.any() else _bits(~missing)


def _bits(values: np.ndarray) -> pa.Buffer:
    return pa.py_buffer(np.packbits(values, bitorder="little"))
