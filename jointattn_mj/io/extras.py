"""Optional packages: imported when they are asked for, and asked for by name where they are missing."""

from importlib import import_module
from typing import Any

from jointattn_mj.errors import ExtraError


def extra(name: str, module: str) -> Any:
    """The ``module`` that the extra ``name`` of this package brings.

    Raises:
        ExtraError: It is not installed; the message says what to install.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise ExtraError(f"this needs the package {module}: pip install 'jointattn-mj[{name}]' ({error})") from error
