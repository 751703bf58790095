"""A claim of the dissertation from Python: the same trials and report as ``jointattn experiment``."""

from os import PathLike
from typing import Annotated, Literal

from jointattn_mj.api.claim_result import ClaimResult
from jointattn_mj.api.claims import experiments_registry
from jointattn_mj.errors import ConfigError, SweepError
from jointattn_mj.io.progress import count
from jointattn_mj.options import Whole, as_arguments, check_argument, path_of
from jointattn_mj.parallel.backend_choice import new_backend
from jointattn_mj.sweeps.registry import Registry, registry_of
from jointattn_mj.sweeps.report import write_report
from jointattn_mj.sweeps.run import Selection, SweepWatcher, run


def run_claim(
    claim: str,
    out: str | PathLike[str],
    *,
    runs: int | None = None,
    seed: int | None = None,
    setting: str | None = None,
    jobs: int = 0,
    backend: Literal["loky", "gpu", "dask"] = "loky",
    address: str | None = None,
    registry: str | Registry | None = None,
    watcher: SweepWatcher | None = None,
) -> ClaimResult:
    """Run the trials of a claim that are not stored yet, and report on all claims that the folder holds.

    It can be stopped at any time; the same call goes on. Trials that failed before are tried again.

    Args:
        claim: Id of the claim, such as ``"4.4"``; ``jointattn experiment list`` lists them.
        out: Folder for trials, figures and report; trials that it holds are not run again.
        runs: Runs of each setting; by default the claim's own number.
        seed: Seed of the first run; by default the claim's own.
        setting: Run only this setting, or all whose ids begin so.
        jobs: Trials at once on this machine; 0 runs one a core.
        backend: Processes of this machine (``"loky"``), processes with many trials each, whose images one graphics card
            draws (``"gpu"``), or the workers of a dask scheduler (``"dask"``).
        address: Address of the dask scheduler.
        registry: Claims of your own: a :class:`Registry`, or the module whose REGISTRY it is.
        watcher: Is told how the trials go; ``sweeps.progress.SweepProgress()`` shows them on stderr.

    Returns:
        Findings, figures and report. Its repr is a short table.

    Raises:
        ConfigError: There is no such claim or setting, or options do not go together.
        OutputError: The folder cannot be written.
        SweepError: Trials failed, workers cannot be reached, or an analysis failed.

    Examples:
        >>> from jointattn_mj import run_claim
        >>> result = run_claim("5.2", out="out/claims", runs=1, jobs=1)
        >>> result.report.name, sorted(result.figures)
        ('report.html', ['order'])
    """
    check_argument("claim", claim, str, "the id of a claim, such as '4.4'")
    check_argument("jobs", jobs, Annotated[int, Whole("[0, 10000]")])
    check_argument("backend", backend, Literal["loky", "gpu", "dask"])
    check_argument("address", address, str | None)
    check_argument("registry", registry, Registry | str | None, "a Registry, or the name of the module that holds it")
    claims = registry if isinstance(registry, Registry) else registry_of(registry) if registry else None
    known = experiments_registry() if claims is None else claims
    if claim not in known.entries:
        raise ConfigError(f"no claim has the id {claim!r}; there are {', '.join(known)}")
    folder = path_of(out, "out")
    with as_arguments():
        selection = Selection(setting, runs, seed)
    always = {"registry": registry} if isinstance(registry, str) else {}
    tally = run([known[claim]], selection, folder, new_backend(backend, jobs, address), watcher, **always)
    if tally.failed:
        task, error, alone = tally.failed[0]
        raise SweepError(
            f"{count(len(tally.failed), 'trial')} failed, and the same call tries them again; {task}: {error}; "
            f"alone: {alone}"
        )
    write_report(known, list(known), folder)
    return ClaimResult.open(folder, claim, known)
