"""The claims of the dissertation, wherever the package's experiments are."""

from importlib.util import find_spec
from pathlib import Path

from jointattn_mj.errors import SweepError
from jointattn_mj.sweeps.registry import Registry, registry_of

PACKAGE_FOLDER = Path(__file__).resolve().parents[1]


def experiments_registry() -> Registry:
    """The claims of the dissertation: those of the checkout, or else the copy that the installed package carries.

    Raises:
        SweepError: Neither is there, or another package called ``experiments`` stands before the checkout's.
    """
    if (PACKAGE_FOLDER / "experiments").is_dir():
        return registry_of("jointattn_mj.experiments.registry")
    expected = PACKAGE_FOLDER.parent / "experiments" / "registry.py"
    spec = find_spec("experiments")
    if not expected.exists() or spec is None:
        raise SweepError(f"the package carries no experiments, and {expected} is not there; install jointattn-mj again")
    if expected.parent not in map(Path, spec.submodule_search_locations or ()):
        raise SweepError(f"expected the package experiments in {expected.parent}; got {spec.origin}; rename that one")
    return registry_of("experiments.registry")
