"""The backend that computes trials, as options name it."""

from jointattn_mj.errors import ConfigError
from jointattn_mj.parallel.crowd import Crowd
from jointattn_mj.sweeps.backends import Backend, Dask, Loky


def new_backend(name: str, jobs: int, address: str | None) -> Backend:
    """Make the backend that the options ask for.

    Args:
        name: ``loky``, ``gpu`` or ``dask``.
        jobs: Processes of loky and gpu; 0 for one a core.
        address: Address of the dask scheduler.

    Raises:
        ConfigError: The options contradict each other.
        ExtraError: The extra ``gpu`` is not installed.
        SweepError: The scheduler cannot be reached.
    """
    if name != "dask":
        if address is not None:
            raise ConfigError(
                f"`address={address!r}` is for `backend='dask'`; the processes of {name} are on this machine"
            )
        return Loky(jobs) if name == "loky" else Crowd(jobs)
    if address is None:
        raise ConfigError("`backend='dask'` needs `address`, such as tcp://127.0.0.1:8786")
    return Dask(address)
