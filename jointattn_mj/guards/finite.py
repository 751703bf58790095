"""Whether what a run has learned and simulated is still made of finite numbers."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from jointattn_mj.errors import NotFiniteError


def not_finite(arrays: Mapping[str, Any]) -> list[str]:
    """Names of the arrays that hold NaN or infinity; what is no float is finite."""
    return [
        name for name, array in arrays.items() if np.asarray(array).dtype.kind in "fc" and not np.isfinite(array).all()
    ]


def check_finite(arrays: Mapping[str, Any]) -> None:
    """Stop a run that has lost its numbers.

    Raises:
        NotFiniteError: Some of ``arrays`` hold NaN or infinity; it names them.
    """
    lost = not_finite(arrays)
    if lost:
        raise NotFiniteError(
            f"NaN or infinity came up in {', '.join(lost)}: some option is too large, or no number; the last "
            "checkpoint, if there is one, is from before that"
        )
