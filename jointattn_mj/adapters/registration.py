"""Registers the suite's tasks with Gymnasium, once both packages are imported, in either order."""

import importlib
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

TYPE_CHECKING = False  # as in typing, which the start of a program does not wait for
if TYPE_CHECKING:
    from importlib.abc import Loader

IDS = {
    "ObjectTransfer-v0": "object_transfer",
    "ObjectTransferHard-v0": "object_transfer_hard",
    "Follow-v0": "follow",
    "FollowHard-v0": "follow_hard",
    "TurnTaking-v0": "turn_taking",
    "TurnTakingHard-v0": "turn_taking_hard",
}
"""Gymnasium's id of each task: ``gymnasium.make("jointattn_mj:Follow-v0")``."""
ENTRY_POINT = "jointattn_mj.adapters.gymnasium:JointAttentionEnv"
VECTOR_ENTRY_POINT = "jointattn_mj.adapters.vector:FollowVector"
VECTORS = ("follow", "follow_hard")
"""Tasks of which many worlds run together; of the others Gymnasium makes as many environments."""


def register_when_needed() -> None:
    """Register now if gymnasium is imported, else once it is: to import it takes longer than all of this package."""
    if sys.modules.get("gymnasium") is not None:
        _register()
    else:
        sys.meta_path.insert(0, _GymnasiumFinder())


def _register() -> None:
    gymnasium = importlib.import_module("gymnasium")
    for name, task in IDS.items():
        vector = VECTOR_ENTRY_POINT if task in VECTORS else None
        gymnasium.register(id=name, entry_point=ENTRY_POINT, vector_entry_point=vector, kwargs={"task": task})


class _GymnasiumFinder:
    """An import hook that lets the import of gymnasium be followed by registration."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != "gymnasium":
            return None
        from importlib.util import find_spec

        sys.meta_path.remove(self)
        spec = find_spec(name)
        if spec is not None and spec.loader is not None:
            spec.loader = _ThenRegister(spec.loader)  # type: ignore[assignment]  # has what a Loader needs
        return spec


class _ThenRegister:
    def __init__(self, loader: "Loader"):
        self._loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)
        _register()
