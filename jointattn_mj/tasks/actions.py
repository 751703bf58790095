"""The border between whoever acts and the world: numbers of the right shape pass, and nothing else."""

from typing import Any

import numpy as np
from dm_env import specs

from jointattn_mj.errors import ActionError


def checked(action: Any, spec: specs.BoundedArray) -> np.ndarray:
    """``action`` as an array, clipped to the bounds of ``spec``; a new one, or ``action`` itself where it fits.

    Args:
        action: Numbers, whole or not, of the shape of ``spec``: an array, a list, or what numpy takes for one.
        spec: Shape and bounds; the dtype may differ.

    Raises:
        ActionError: Not numbers (text, None, complex, yes or no), another shape, NaN or infinite.
    """
    try:
        values = np.asarray(action)
    except Exception as error:  # ragged lists, and whatever an object's own conversion raises
        raise ActionError(f"{_expected(spec)}; got {_shown(action)} ({error})") from error
    if values.dtype.kind not in "iuf":
        raise ActionError(f"{_expected(spec)}; got {_shown(action)}, which is {values.dtype}, no numbers")
    if values.shape != spec.shape:
        raise ActionError(f"{_expected(spec)}; got shape {values.shape}: {_shown(action)}")
    if not np.isfinite(values).all():
        raise ActionError(f"{_expected(spec)}; got {_shown(action)}, which is not finite: check what chose it")
    return np.minimum(np.maximum(values, spec.minimum), spec.maximum)


def _expected(spec: specs.BoundedArray) -> str:
    names = (spec.name or "numbers").replace("\t", ", ")
    return f"an action is {names}: shape {spec.shape}, from {spec.minimum} to {spec.maximum}"


def _shown(action: Any) -> str:
    shown = repr(action)
    return shown if len(shown) <= 80 else f"{shown[:77]}..."
