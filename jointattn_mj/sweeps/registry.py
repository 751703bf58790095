"""Claims by id. What runs one is imported when it is asked for, what reads it when it is read."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from jointattn_mj.errors import ConfigError
from jointattn_mj.sweeps.claim import Claim


@dataclass(frozen=True)
class Entry:
    """What can be said of a claim without importing it."""

    id: str
    folder: str
    """Package with ``sweep`` and ``analysis``."""
    title: str
    source: str
    """Where it stands in the dissertation."""
    says: str
    """What the dissertation claims, in one or two sentences."""


class Registry(Mapping[str, Claim]):
    """Claims by id, in the order in which they were entered."""

    def __init__(self, package: str, *entries: Entry):
        self.entries = {entry.id: entry for entry in entries}
        if len(self.entries) < len(entries):
            raise ConfigError(f"claim ids must differ; got {', '.join(entry.id for entry in entries)}")
        self._package = package

    def __getitem__(self, claim: str) -> Claim:
        entry = self.entries[claim]
        sweep = import_module(f"{self._package}.{entry.folder}.sweep")

        def analysis() -> Any:
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
