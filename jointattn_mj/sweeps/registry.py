"""Claims by id. The modules that run or analyse a claim are imported when they are first needed."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.sweeps.claim import Claim


@dataclass(frozen=True)
class Entry:
    """Facts about a claim that are known without importing it."""

    id: str
    folder: str
    """Package with the modules ``sweep`` and ``analysis``."""
    title: str
    source: str
    """Where the claim stands in the dissertation."""
    says: str
    """What the dissertation claims, in one or two sentences."""


class Registry(Mapping[str, Claim]):
    """Claims by id, in the order in which they were entered.

    Args:
        package: Dotted name of the package that holds a folder for each claim.
        entries: The claims, with different ids.

    Raises:
        ConfigError: Two entries have the same id.
    """

    def __init__(self, package: str, *entries: Entry):
        self.entries = {entry.id: entry for entry in entries}
        if len(self.entries) < len(entries):
            raise ConfigError(f"claim ids must differ; got {', '.join(entry.id for entry in entries)}")
        self._package = package

    def __getitem__(self, claim_id: str) -> Claim:
        entry = self.entries[claim_id]
        sweep = import_module(f"{self._package}.{entry.folder}.sweep")

        def analysis() -> ModuleType:
            return import_module(f"{self._package}.{entry.folder}.analysis")

        return Claim(
            id=entry.id,
            title=entry.title,
            source=entry.source,
            says=entry.says,
            settings=sweep.SETTINGS,
            trial=sweep.trial,
            analyse=lambda trials: analysis().analyse(trials),
            draw=lambda trials: analysis().draw(trials),
            first_seed=getattr(sweep, "FIRST_SEED", 0),
            version=getattr(sweep, "VERSION", 1),
            film=getattr(sweep, "FILM", None),
        )

    def __iter__(self) -> Iterator[str]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __repr__(self) -> str:
        return f"Registry({self._package!r}: {', '.join(self.entries)})"


def registry_of(module: str) -> Registry:
    """``REGISTRY`` of a module, such as ``my_claims.registry``.

    Raises:
        ConfigError: There is no such module, or it has no such registry.
        SweepError: The module cannot be imported.
    """
    try:
        registry = getattr(import_module(module), "REGISTRY", None)
    except ModuleNotFoundError as error:
        if error.name is None or not module.startswith(error.name):
            raise SweepError(f"cannot import {module}: {error}") from error
        raise ConfigError(
            f"cannot import {module}; expected a module that Python finds, such as my_claims.registry"
        ) from error
    except Exception as error:
        raise SweepError(f"cannot import {module}: {type(error).__name__}: {error}") from error
    if not isinstance(registry, Registry):
        raise ConfigError(f"{module} has no REGISTRY; see jointattn_mj.sweeps.registry.Registry")
    return registry
