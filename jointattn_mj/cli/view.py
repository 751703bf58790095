"""``jointattn view``: an agent in a task, live in a window or in a browser.

What takes seconds to import is imported after the line that says that the view is starting.
"""

import socket
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from jointattn_mj.adapters.registration import IDS
from jointattn_mj.cli.running import one_thread
from jointattn_mj.errors import ConfigError
from jointattn_mj.io.interrupts import deferred
from jointattn_mj.options import FLAT, Checked, Choice, Seed, Whole

if TYPE_CHECKING:
    from jointattn_mj.viewing.show import Show

LESS = "a shorter episode"
HERE = "127.0.0.1"
"""This machine alone."""
DOMAIN = "joint_attention"


@dataclass(frozen=True)
class ViewOptions(Checked):
    """Which task and agent are shown, and where."""

    task: tyro.conf.Positional[Annotated[str, Choice(IDS.values())]]
    """Task of the suite."""
    agent: Literal["zero", "random", "oracle", "gaze_follower"] | None = None
    """Who acts. By default the gaze follower of chapter 6 where the task gives images in time, else the oracle."""
    seed: Seed = 0
    """Seed of all randomness."""
    browser: bool = False
    """Serve the browser's viewer even where there is a display; needs the extra ``view``."""
    host: str = HERE
    """Network interface to serve it on. Any but this machine's own lets others watch and stop the view."""
    port: Annotated[int, Whole("[1, 65535]")] = 8080
    """First port to try; the next free one is taken."""


def view(options: Annotated[ViewOptions, FLAT]) -> None:
    """Watch an agent in a task: in a window where there is a display, else in a browser.

    The browser's address is printed; only this machine reaches it unless --host says otherwise. Closing the window or
    Ctrl-C ends the view.
    """
    print(f"jointattn: the view of {options.task} is starting", file=sys.stderr, flush=True)
    if options.browser or options.host != HERE or not _has_display():
        _serve(options)
        return
    from jointattn_mj.viewing.native import show_in_window

    with deferred() as interrupts:
        show_in_window(_show(options), lambda: not interrupts.requested)


def _serve(options: ViewOptions) -> None:
    """The browser's viewer; Ctrl-C is how it ends."""
    from jointattn_mj.adapters.mjviser import Browser

    _check(options.host)
    print("jointattn: starting the viewer, in some seconds", file=sys.stderr)
    browser = Browser(_show(options), options.host, options.port)
    if options.host != HERE:
        print(f"jointattn: warning: whoever reaches {options.host} can watch this and stop it", file=sys.stderr)
    print(f"{browser.address}  (Ctrl-C ends it)", flush=True)
    with deferred() as interrupts:
        browser.run(lambda: not interrupts.requested)


def _show(options: ViewOptions) -> "Show":
    from jointattn_mj.tasks import load
    from jointattn_mj.tasks.agents import AGENTS
    from jointattn_mj.viewing.show import Show

    one_thread()
    images = options.agent in (None, "gaze_follower")
    environment = load(DOMAIN, options.task, task_kwargs={"random": options.seed, "camera": images})
    sees = "head_moves" in environment.observation_spec()
    agent = options.agent or ("gaze_follower" if sees else "oracle")
    return Show(environment, AGENTS[agent](environment, options.seed))


def _check(host: str) -> None:
    """Whether one can listen there at all."""
    try:
        with socket.create_server((host, 0)):
            pass
    except OSError as error:
        raise ConfigError(f"cannot listen on {host} ({error}); leave --host out for this machine alone") from error


def _has_display() -> bool:
    from jointattn_mj.viewing.native import has_display

    return has_display()
