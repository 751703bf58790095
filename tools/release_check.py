"""Try README's two commands on bare Debian machines, before a release: as root, and as a user without sudo.

    python3 tools/release_check.py --folder /var/tmp/release

Needs root, debootstrap, some 20 GB of disk and an hour; each Debian downloads 7 GB. A root is built for each Debian by
debootstrap, with Python, make and git alone; the last commit of this checkout is cloned into it; pip has the package
index and nothing else. A table says what came out; logs stay in the folder.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]
USER = "robin"
BROUGHT = "python3,python3-venv,make,git,ca-certificates"
ODD = re.compile(r"Traceback|warning|deprecat|Segmentation|core dumped", re.IGNORECASE)
"""What no line of ``make demo`` says; tests print warnings of other packages."""


@dataclass(frozen=True)
class MachineTrial:
    """A command that somebody runs on the machine, and what has to come of it."""

    who: str
    command: str
    says: str
    succeeds: bool = True


TRIALS = (
    MachineTrial(USER, "make demo", "No images can be rendered here"),
    MachineTrial(USER, "make test", "for the administrator: apt-get", succeeds=False),
    MachineTrial("root", "make demo", "out/demo/trained/video.mp4"),
    MachineTrial("root", "make test", " passed"),
    MachineTrial("root", "make demo", "out/demo/trained/video.mp4"),
    MachineTrial(USER, "make demo", "out/demo/trained/video.mp4"),
    MachineTrial(USER, "make test", " passed"),
)
"""In this order on each machine: root's first demo brings OpenGL."""


@dataclass(frozen=True)
class Machine:
    """A bare Debian in a folder."""

    folder: Path

    @classmethod
    def build(cls, suite: str, folder: Path) -> "Machine":
        """Debian's smallest system, and of this machine what the way to the network needs."""
        mirror = subprocess.run(
            "grep -rhoE 'https?://[^ ]+/debian/?( |$)' /etc/apt/sources.list* | head -n 1",
            shell=True, capture_output=True, text=True,
        ).stdout.strip()  # fmt: skip
        command = ["debootstrap", "--variant=minbase", f"--include={BROUGHT}", suite, str(folder)]
        log = folder.with_suffix(".debootstrap.log")
        with log.open("w") as file:
            done = subprocess.run([*command, *filter(None, [mirror])], stdout=file, stderr=file)
        if done.returncode:
            sys.exit(f"release_check: debootstrap could not: {log.read_text().splitlines()[-1]} (see {log})")
        shutil.copytree("/etc/apt/apt.conf.d", folder / "etc/apt/apt.conf.d", dirs_exist_ok=True)
        for name in ("resolv.conf", "hosts", "ssl/certs/ca-certificates.crt"):
            shutil.copy(Path("/etc") / name, folder / "etc" / name)
        machine = cls(folder)
        machine.run("root", f"useradd --create-home {USER}", folder.with_suffix(".useradd.log"))
        return machine

    def home(self, who: str) -> str:
        return "/root" if who == "root" else f"/home/{who}"

    def clone(self, who: str) -> None:
        """The checkout's last commit, in somebody's home."""
        project = self.folder / self.home(who)[1:] / "project"
        subprocess.run(["git", "clone", "--quiet", str(CHECKOUT), str(project)], check=True)
        self.run("root", f"chown -R {who}: {self.home(who)}/project", self.folder.with_suffix(".chown.log"))

    def run(self, who: str, command: str, log: Path) -> int:
        """Exit code of a command in the clone, or else at home, without anything of this process's environment.

        Args:
            who: User who runs it.
            command: Line for a shell.
            log: File for all that it says.
        """
        kept = {name: value for name, value in os.environ.items() if name.lower().endswith("_proxy")}
        given = {
            "HOME": self.home(who), "USER": who, "LANG": "C.UTF-8", "PIP_CERT": "/etc/ssl/certs/ca-certificates.crt",
            "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
        }  # fmt: skip
        inside = f"cd; cd project 2>/dev/null; {command}"
        script = 'mount -t proc proc "$0/proc"; mount --rbind /dev "$0/dev"; mount -t tmpfs -o mode=1777 tmpfs "$0/tmp"'
        script += '; exec chroot --userspec="$1" "$0" bash -c "$2"'
        new = ["unshare", "--mount", "--pid", "--fork", "--kill-child", "bash", "-c", script]
        arguments = [*new, str(self.folder), who, inside]
        with log.open("w") as file:
            done = subprocess.run(arguments, env=kept | given, stdin=subprocess.DEVNULL, stdout=file, stderr=file)
        return done.returncode

    def size(self, path: str) -> str:
        """On disk, as du says it."""
        done = subprocess.run(["du", "-sm", self.folder / path[1:]], capture_output=True, text=True)
        return f"{done.stdout.split()[0]} MB" if done.stdout else "none"


def tried(machine: Machine, trial: MachineTrial, log: Path) -> str:
    """A row of the table.

    Args:
        machine: Where it is tried.
        trial: What is tried.
        log: File for all that is said.
    """
    started = time.monotonic()
    code = machine.run(trial.who, trial.command, log)
    minutes = (time.monotonic() - started) / 60
    said = log.read_text(errors="replace")
    odd = [line for line in said.splitlines() if trial.command == "make demo" and ODD.search(line)]
    fine = (code == 0) == trial.succeeds and trial.says in said and not odd
    environment = machine.size(f"{machine.home(trial.who)}/project/.venv")
    verdict = "as expected" if fine else f"**not as expected**: see {log.name} {odd[:1]}"
    cells = (machine.folder.name, trial.who, trial.command, code, f"{minutes:.1f}", environment, verdict)
    return f"| {' | '.join(map(str, cells))} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True, help="for roots and logs; made when missing")
    parser.add_argument("--suites", nargs="+", default=["bookworm", "trixie"], help="Debian's names")
    parser.add_argument("--commands", nargs="+", default=["demo", "test"], choices=["demo", "test"], help="of make")
    parser.add_argument("--keep", action="store_true", help="leave the roots there")
    options = parser.parse_args()
    if os.geteuid() or not shutil.which("debootstrap"):
        sys.exit("release_check: needs root, and debootstrap (apt-get install debootstrap)")
    rows = ["| Debian | who | command | exit | minutes | .venv | |", "|---|---|---|---|---|---|---|"]
    for suite in options.suites:
        options.folder.mkdir(parents=True, exist_ok=True)
        machine = Machine.build(suite, options.folder.resolve() / suite)
        for who in (USER, "root"):
            machine.clone(who)
        for number, trial in enumerate(trial for trial in TRIALS if trial.command.split()[1] in options.commands):
            log = machine.folder.with_name(f"{suite}-{number}-{trial.who}-{trial.command.split()[1]}.log")
            rows.append(tried(machine, trial, log))
            print(rows[-1], flush=True)
        if not options.keep:
            shutil.rmtree(machine.folder)
    print("\n" + "\n".join(rows))
    sys.exit(any("**" in row for row in rows))


if __name__ == "__main__":
    main()
