"""Arrow's arrays of numpy's and of words.

``pyarrow.array`` imports pandas where that is installed, whatever it is given: .3 s and 50 MiB.
"""

from collections.abc import Sequence

import numpy as np
import pyarrow as pa


def number_array(values: np.ndarray, missing: np.ndarray | None = None) -> pa.Array:
    """Numbers or truth values (n,) as they are, null where ``missing`` (n,) bool."""
    known = None if missing is None or not missing.any() else _bits(~missing)
    held = _bits(values) if values.dtype == bool else pa.py_buffer(np.ascontiguousarray(values))
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), len(values), [known, held])


def word_array(texts: Sequence[str]) -> pa.StringArray:
    """Texts, none of which is missing."""
    encoded = [str(text).encode() for text in texts]
    ends = np.cumsum([0, *map(len, encoded)], dtype=np.int32)
    return pa.StringArray.from_buffers(len(encoded), pa.py_buffer(ends), pa.py_buffer(b"".join(encoded)))


def _bits(values: np.ndarray) -> pa.Buffer:
    return pa.py_buffer(np.packbits(values, bitorder="little"))
