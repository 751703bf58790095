"""Set up .venv for `make demo` and `make test`: check what can fail, say what comes, then install.

python3 tools/setup.py demo      what the demo needs
python3 tools/setup.py test      everything, for tests, checks and documentation
python3 tools/setup.py renders   exit with 0 where images can be rendered
"""

import sys

if sys.version_info < (3, 11):  # noqa: UP036 - whoever has an older one has to read why
    old = f"{sys.version_info[0]}.{sys.version_info[1]}"
    sys.exit(
        f"setup: Python 3.11 or later is needed, and {sys.executable} is {old}; name another: make PYTHON=python3.11"
    )

import fcntl
import hashlib
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
READY = VENV / ".ready"
"""What was installed, for which project file, folder and Python."""
LOG = VENV / "setup.log"
"""What pip says; there while pip works, and after it failed or was interrupted."""
TEMPORARY = VENV / "tmp"
"""Where pip keeps downloads until it installs them: /tmp may be small, or in memory."""
CHANGES = "Installing collected packages"
"""What pip says before it changes anything."""
ALONE = ["--no-deps", "dm-control>=1.0.50"] if sys.version_info >= (3, 13) else []
"""What pip cannot bring with what it asks for (see pyproject.toml)."""
OPENGL = ("libegl1", "libopengl0", "libgl1-mesa-dri")
TERMINAL = sys.stdout.isatty()
EVERY_S = 1 if TERMINAL else 10
"""Seconds between two lines that say how far it is."""


@dataclass(frozen=True)
class Part:
    """Packages that come together, one of them to tell by, and their size on Linux in MB."""

    name: str
    package: str
    download: int
    installed: int

    def is_there(self) -> bool:
        return any(VENV.glob(f"lib/python*/site-packages/{self.package}/__init__.py"))


BASE = Part("what the demo needs", "mujoco", 397, 1350)
TORCH = Part("PyTorch, in PyPI's build for CUDA", "torch", 2740, 4940)
TOOLS = Part("tools for tests and documentation", "pytest", 85, 400)
KINDS = {"demo": (BASE,), "test": (BASE, TORCH, TOOLS)}
EXTRAS = {"demo": "", "test": "[dev]"}


def main(arguments: list[str]) -> None:
    """Do what the command line asks for; whatever cannot work ends in one line and exit code 1."""
    if arguments == ["renders"]:
        sys.exit(not renders())
    if len(arguments) != 1 or arguments[0] not in KINDS:
        sys.exit(__doc__)
    with open(__file__) as lock:
        wait_for_other_setups(lock.fileno())
        set_up(arguments[0])


def set_up(asked: str) -> None:
    """Bring .venv to what ``asked`` needs, and OpenGL to this machine where that is allowed."""
    repair()
    kind = max(asked, str((made_from() or {}).get("kind", asked)), key=list(KINDS).index)
    missing = [part for part in KINDS[kind] if not part.is_there()]
    announce(missing)
    bring_system_packages(asked)
    if made_from() != wanted_from(kind):
        install(kind, missing)


def wait_for_other_setups(file: int) -> None:
    """Only one at a time; the lock goes with the process that holds it."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        say("another setup is at work in this folder; waiting for it")
        fcntl.flock(file, fcntl.LOCK_EX)
    except OSError:  # a file system without locks
        pass


# What is there


def wanted_from(kind: str) -> dict[str, object]:
    """What an environment is made from; one made from anything else is brought up to date, or made anew."""
    project = hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()
    return {"kind": kind, "project": project, "folder": str(ROOT), "python": list(sys.version_info[:3])}


def made_from() -> dict[str, object] | None:
    """The same of the environment that is there, or None where there is none or somebody else's."""
    try:
        return json.loads(READY.read_text())
    except (OSError, ValueError):
        return None


def repair() -> None:
    """Remove an environment that this script made and that cannot be gone on with; pip keeps its downloads."""
    made, why = made_from(), None
    if LOG.exists() and CHANGES in LOG.read_text(errors="replace"):
        why = "the last setup was interrupted"
    elif made and (made["folder"], made["python"]) != (str(ROOT), list(sys.version_info[:3])):
        why = "it was made in another folder, or for another Python"
    elif VENV.exists() and not (VENV / "bin" / "python").exists():
        why = "it has no Python that works"
    if why:
        say(f"making .venv anew: {why}")
        shutil.rmtree(VENV)


def renders(**environment: str) -> bool:
    """Whether the package itself would render images; asked in another process, for a driver may crash."""
    code = "import sys; from jointattn_mj.scene import gl; gl.choose_backend(); sys.exit(gl.rendering_disabled())"
    return succeeds([sys.executable, "-c", code], **environment)


def succeeds(command: list[str], **environment: str) -> bool:
    """Whether a command that asks something ends with 0; all that it says is left out."""
    return not subprocess.run(command, cwd=ROOT, env=os.environ | environment, capture_output=True).returncode


def announce(missing: list[Part]) -> None:
    """Say what comes, and whether there is room: downloads wait in .venv until all of them are there."""
    for part in missing:
        say(f"to come: {part.name}, some {amount(part.download)} to download, {amount(part.installed)} on disk")
    need, free = sum(part.download + part.installed for part in missing), shutil.disk_usage(ROOT).free // 10**6
    if free < need:
        fail(f"some {amount(need)} of disk are needed in {ROOT}, and {amount(free)} are free")


# What the system has to bring


def bring_system_packages(kind: str) -> None:
    """Install software OpenGL, and pip for virtual environments, where they are missing, or say who can."""
    missing = missing_system_packages()
    tried = bool(missing) and apt(missing)
    if tried:
        missing = missing_system_packages()
    if not missing:
        return
    line = f"apt-get update && apt-get install --no-install-recommends {' '.join(missing)}"
    help = "they are installed: see README, Troubles" if tried else f"for the administrator: {line}"
    if missing[0] not in OPENGL:
        fail(f"{sys.executable} makes no virtual environments with pip; {help}")
    if kind == "test":
        fail(f"the tests render images, and there is no OpenGL that works; {help}")
    say(f"there is no OpenGL that works, and everything but images works without; {help}")


def missing_system_packages() -> list[str]:
    """By Debian's names."""
    pip, images = [f"python{sys.version_info[0]}.{sys.version_info[1]}-venv"], list(OPENGL)
    if VENV.exists() or succeeds([sys.executable, "-c", "import ensurepip, venv"]):
        pip = []
    if sys.platform != "linux" or renders(MUJOCO_GL=""):
        images = []
    return pip + images


def apt(packages: list[str]) -> bool:
    """Whether they could be installed; what apt-get says is shown only where it fails."""
    say(f"missing from the system: {' '.join(packages)} (some 50 MB to download, 215 MB on disk)")
    if not (shutil.which("apt-get") and (os.geteuid() == 0 or sudo_lets())):
        return False
    root = [] if os.geteuid() == 0 else ["sudo"]
    get = [*root, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq"]
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "apt.log"
        for command in ([*get, "update"], [*get, "install", "-y", "--no-install-recommends", *packages]):
            if not watch(command, log, lambda: "apt-get is at work"):
                say(f"apt-get could not: {last_lines(log, ('E:',))}")
                return False
    return True


def sudo_lets() -> bool:
    """Whether sudo can be used; it asks for a password where there is a terminal."""
    if not shutil.which("sudo"):
        return False
    if sys.stdin.isatty() and TERMINAL:
        return subprocess.run(["sudo", "-v"]).returncode == 0
    return succeeds(["sudo", "-n", "true"])


# What pip brings


def install(kind: str, missing: list[Part]) -> None:
    """Make the environment where there is none, and install what ``kind`` needs into it."""
    started = time.monotonic()
    if not VENV.exists() and not succeeds([sys.executable, "-m", "venv", str(VENV)]):
        fail(f"{sys.executable} -m venv {VENV} fails")
    shutil.rmtree(TEMPORARY, ignore_errors=True)
    TEMPORARY.mkdir()
    before, downloads = megabytes(VENV / "lib"), [0]

    def how_far() -> str:
        if CHANGES in LOG.read_text(errors="replace"):
            return f"installed {megabytes(VENV / 'lib') - before} of about {sum(part.installed for part in missing)} MB"
        downloads.append(max(downloads[-1], megabytes(TEMPORARY)))  # pip holds a package twice while it moves it
        return f"downloaded {downloads[-1]} of about {sum(part.download for part in missing)} MB"

    pip = [str(VENV / "bin" / "python"), "-m", "pip", "install", "--disable-pip-version-check", "--progress-bar=off"]
    for wanted in filter(None, (["--editable", f"{ROOT}{EXTRAS[kind]}"], ALONE)):
        if not watch([*pip, "--no-input", *wanted], LOG, how_far, TMPDIR=str(TEMPORARY), PYTHONUNBUFFERED="1"):
            fail(f"pip could not: {last_lines(LOG, ('ERROR:',))} (all it said: {LOG}); the same command tries again")
    READY.write_text(json.dumps(wanted_from(kind)))
    shutil.rmtree(TEMPORARY)
    LOG.unlink()
    say(f"ready after {time.monotonic() - started:.0f} s")


# How it is told


def watch(command: list[str], log: Path, how_far: Callable[[], str], **environment: str) -> bool:
    """Run a command, all that it says into ``log``, and say now and then how far it is.

    Args:
        command: Program and arguments.
        log: File for all that it says.
        how_far: Gives words on how far it is.
        environment: Further variables.
    """
    with log.open("w") as file:
        inherited = os.environ | environment
        run = subprocess.Popen(command, stdout=file, stderr=file, stdin=subprocess.DEVNULL, env=inherited)
    with run:
        while run.poll() is None:
            try:
                run.wait(EVERY_S)
            except subprocess.TimeoutExpired:
                say(how_far(), passing=TERMINAL)
    return run.returncode == 0


def say(text: str, passing: bool = False) -> None:
    """A line; a ``passing`` one is written over by the next."""
    print(("\r\x1b[2K" if TERMINAL else "") + f"setup: {text}", end="" if passing else "\n", flush=True)


def fail(text: str) -> NoReturn:
    say(text)
    sys.exit(1)


def last_lines(log: Path, starts: tuple[str, ...]) -> str:
    """The last two of those that begin so, or of all."""
    lines = log.read_text(errors="replace").splitlines()
    return " ".join(([line for line in lines if line.startswith(starts)] or lines)[-2:])


def megabytes(folder: Path) -> int:
    total = 0
    for place, _, names in os.walk(folder):
        for name in names:
            try:
                total += os.lstat(os.path.join(place, name)).st_size
            except OSError:  # gone in the meantime
                continue
    return total // 10**6


def amount(size: int) -> str:
    return f"{size / 1000:.1f} GB" if size >= 1000 else f"{size} MB"


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except OSError as error:
        fail(str(error))
    except KeyboardInterrupt:
        say("interrupted; the same command goes on")
        sys.exit(130)
