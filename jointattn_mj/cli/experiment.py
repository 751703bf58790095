"""``jointattn experiment``: list claims, run their missing trials, report stored ones."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from jointattn_mj.api.claims import experiments_registry
from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.options import FLAT, Checked, Seed, Whole
from jointattn_mj.sweeps.registry import Registry, registry_of

EXPERIMENTS = "experiments.registry"
LONGEST_NAME = 200
LESS = "fewer jobs at once"


@dataclass(frozen=True)
class ListOptions(Checked):
    """List the claims, and with --out how many trials of each are stored."""

    out: Path | None = None
    """Folder of the results."""
    registry: str = EXPERIMENTS
    """Module whose REGISTRY holds the claims."""


@dataclass(frozen=True)
class ExperimentRunOptions(Checked):
    """Run the trials of some claims that are not stored yet. The same command goes on after a stop."""

    claims: tyro.conf.Positional[tuple[str, ...]]
    """Ids of claims, or all."""
    out: Path
    """Folder for the results; trials that it holds are not run again."""
    runs: Annotated[int, Whole("[1, 1e6]")] | None = None
    """Runs of each setting; by default the claim's own number."""
    seed: Seed | None = None
    """Seed of the first run; by default the claim's own."""
    setting: str | None = None
    """Run only this setting, or all whose ids begin so."""
    jobs: Annotated[int, Whole("[0, 1024]")] = 0
    """Trials at once on this machine; 0 runs one a core."""
    backend: Literal["loky", "gpu", "dask"] = "loky"
    """Where trials run: in processes of this machine; in processes with many trials each, whose images one graphics
    card draws (extra gpu; for settings with world.renderer warp); or in the workers of a dask scheduler."""
    address: str | None = None
    """Address of the dask scheduler, such as tcp://127.0.0.1:8786."""
    registry: str = EXPERIMENTS
    """Module whose REGISTRY holds the claims."""


@dataclass(frozen=True)
class ClaimReportOptions(Checked):
    """Write a report of the stored trials: report.html, claims.json, claims.csv and figures."""

    folder: Annotated[Path, tyro.conf.Positional]
    """Folder of the results."""
    claims: tuple[str, ...] = ()
    """Ids of claims to report; by default all that have trials there."""
    registry: str = EXPERIMENTS
    """Module whose REGISTRY holds the claims."""


Listing = Annotated[ListOptions, tyro.conf.subcommand("list")]
Running = Annotated[ExperimentRunOptions, tyro.conf.subcommand("run")]
Reporting = Annotated[ClaimReportOptions, tyro.conf.subcommand("report")]


def experiment(command: Annotated[Listing | Running | Reporting, FLAT]) -> None:
    """List the claims of the dissertation, run them, or report what came out."""
    options: ListOptions | ExperimentRunOptions | ClaimReportOptions = command
    registry = load_registry(options.registry)
    if isinstance(options, ListOptions):
        print(listing(registry, options.out))
    elif isinstance(options, ExperimentRunOptions):
        _run(registry, options)
    else:
        _report(registry, options)


def load_registry(module: str) -> Registry:
    """The claims of a module; modules of one's own are looked for in the working directory too.

    Raises:
        ConfigError: There is no such module, or it holds none.
        SweepError: It cannot be imported.
    """
    if module == EXPERIMENTS:
        return experiments_registry()
    if not all(part.isidentifier() for part in module.split(".")) or len(module) > LONGEST_NAME:
        raise ConfigError(
            f"{module[:60]!r} is no name of a module; expected a module that Python finds, such as my_claims.registry"
        )
    if (Path.cwd() / module.split(".")[0]).is_dir() and str(Path.cwd()) not in sys.path:
        sys.path.append(str(Path.cwd()))
    return registry_of(module)


def chosen(registry: Registry, ids: tuple[str, ...]) -> list[str]:
    """Ids of the chosen claims, in the registry's order.

    Raises:
        ConfigError: No id is given, or one that does not exist.
    """
    known = ", ".join(registry)
    if not ids:
        raise ConfigError(f"expected ids of claims, or all; there are {known}")
    if ids == ("all",):
        return list(registry)
    for claim in ids:
        if claim not in registry.entries:
            raise ConfigError(f"no claim has the id {claim!r}; there are {known}")
    return [claim for claim in registry if claim in ids]


def listing(registry: Registry, folder: Path | None) -> str:
    """A line for each claim; with a folder also how many of its trials are stored, and how many failed."""
    rows = [("id", "stored", "claim", "source")] if folder else [("id", "", "claim", "source")]
    for claim, entry in registry.entries.items():
        rows.append((claim, _stored(registry, claim, folder) if folder else "", entry.title, entry.source))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = []
    for row in rows:
        lines.append("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True) if width).rstrip())
    return "\n".join(lines)


def _stored(registry: Registry, claim: str, folder: Path) -> str:
    from jointattn_mj.sweeps.run import Selection, plan
    from jointattn_mj.sweeps.store import Store

    store = Store(folder)
    known, failed = store.known(claim), len(store.failures(claim))
    tasks = list(plan([registry[claim]], Selection()))
    there = sum(task.key in known for task in tasks)
    more = f", {len(known) - there} more" if len(known) > there else ""
    return f"{there}/{len(tasks)}{more}" + (f", {failed} failed" if failed else "")


def _run(registry: Registry, options: ExperimentRunOptions) -> None:
    from jointattn_mj.io.progress import count
    from jointattn_mj.parallel.backend_choice import new_backend
    from jointattn_mj.sweeps.progress import SweepProgress
    from jointattn_mj.sweeps.run import Selection, run

    ids = chosen(registry, options.claims)
    selection = Selection(options.setting, options.runs, options.seed)
    try:
        claims = [registry[claim] for claim in ids]
        backend = new_backend(options.backend, options.jobs, options.address)
        always = {} if options.registry == EXPERIMENTS else {"registry": options.registry}
        tally = run(claims, selection, options.out, backend, SweepProgress(), **always)
    except KeyboardInterrupt:
        print(f"jointattn: stopped; the same command goes on with what is in {options.out}", file=sys.stderr)
        raise
    print(options.out)
    if tally.failed:
        raise SweepError(f"{count(len(tally.failed), 'trial')} failed; the same command tries them again")


def _report(registry: Registry, options: ClaimReportOptions) -> None:
    from jointattn_mj.sweeps.report import write_report

    ids = chosen(registry, options.claims) if options.claims else list(registry)
    print(write_report(registry, ids, options.folder))
