"""Checks actions before they reach the world."""

from typing import Any

import numpy as np
from dm_env import specs

from jointattn_mj.errors import ActionError
from jointattn_mj.options import shown


def checked(action: Any, spec: specs.BoundedArray) -> np.ndarray:
    """An action as an array within its bounds.

    Args:
        action: Numbers of the shape of ``spec``: an array, a list, or what else numpy makes an array of.
        spec: Shape and bounds; the dtype may differ.

    Returns:
        The action, clipped to the bounds.

    Raises:
        ActionError: Not numbers (text, None, complex, booleans), another shape, masked, NaN or infinite.
    """
    try:
        values = np.asarray(action)
    except Exception as error:  # ragged lists, and whatever an object's own conversion raises
        raise ActionError(f"{_expected(spec)}; got {shown(action)} ({shown(error)})") from error
    if np.ma.is_masked(action):
        raise ActionError(f"{_expected(spec)}; got {shown(action)}, of which values are masked: fill them in")
    if values.dtype.kind not in "iuf":
        raise ActionError(f"{_expected(spec)}; got {shown(action)}, which is {values.dtype}, no numbers")
    if values.shape != spec.shape:
        raise ActionError(f"{_expected(spec)}; got shape {values.shape}: {shown(action)}")
    if not np.isfinite(values).all():
        raise ActionError(f"{_expected(spec)}; got {shown(action)}, which is not finite: check what chose it")
    clipped: np.ndarray = np.minimum(np.maximum(values, spec.minimum), spec.maximum)
    return clipped


def _expected(spec: specs.BoundedArray) -> str:
    names = (spec.name or "numbers").replace("\t", ", ")
    return f"an action is {names}: shape {spec.shape}, from {spec.minimum} to {spec.maximum}"
