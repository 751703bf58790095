"""What made a result: the resolved config, the seed, the versions and the machine, as YAML beside it."""

import platform
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from enum import Enum
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from jointattn_mj import __version__
from jointattn_mj.io.files import write_whole

PACKAGES = ("mujoco", "dm-control", "numpy", "numba", "opencv-python-headless", "torch")


def plain(value: Any) -> Any:
    """Dataclasses, tuples, paths, enums and arrays as what YAML and JSON know."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (Path, Enum)):
        return str(value)
    return value


def versions() -> dict[str, str]:
    """Versions of this package and of those that shape its results, as far as they are installed."""
    installed = {"jointattn_mj": __version__}
    for name in PACKAGES:
        with suppress(metadata.PackageNotFoundError):  # torch is optional; OpenCV goes by four names
            installed[name] = metadata.version(name)
    return installed


def write_config(path: Path, config: Any) -> None:
    """Write ``config`` with versions and platform to ``path``."""
    text = yaml.safe_dump(
        {
            "config": plain(config),
            "versions": versions(),
            "platform": {"python": platform.python_version(), "system": platform.platform()},
        },
        sort_keys=False,
    )
    write_whole(path, lambda temporary: temporary.write_text(text))
