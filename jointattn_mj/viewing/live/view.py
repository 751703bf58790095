"""The live view of a session before a person: it draws when a page asks, and never changes what the robot does."""

import threading
import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any

import numpy as np

from jointattn_mj.footage.sessions.session import FootageSessionRun
from jointattn_mj.video.paint import PERSON
from jointattn_mj.viewing.live.drawing import LiveDrawing, jpeg
from jointattn_mj.viewing.live.server import LiveServer, Shown
from jointattn_mj.viewing.live.state import LiveState

EVERY_S = 0.1
"""Time between two images on the page: drawing takes time of the robot's."""
ASKED_S = 2.0
"""Seconds after the last request in which images are drawn at all."""
BUTTONS = ("pause", "resume", "finish")


class LiveView:
    """Serves a session: ``with LiveView(port) as view: run(..., prepare=view.attach)``.

    Attributes:
        address: URL of the page.
    """

    def __init__(self, port: int):
        """Start the server.

        Args:
            port: First port to try.

        Raises:
            ConfigError: No port is free.
        """
        self._lock = threading.Lock()
        self._image = self._wide_image = b""
        self._state: dict[str, Any] = {"phase": "starting"}
        self._asked_s = self._drawn_s = -np.inf
        self._paused, self._finish = False, False
        shown = Shown(lambda: self._get("_image"), lambda: self._get("_wide_image"), self._get_state, self._press)
        self._server = LiveServer(shown, port)
        self.address = self._server.address
        self._drawing: LiveDrawing | None = None
        self._words: LiveState | None = None

    def __enter__(self) -> "LiveView":
        """The view itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Stop serving."""
        self._server.close()

    def attach(self, session: Any) -> None:
        """Show ``session`` from now on; it is prepared and has not begun, or was restored."""
        assert isinstance(session, FootageSessionRun)
        rgb = session.colours()
        self._drawing = LiveDrawing(session, rgb)
        inks = [*(255 * rgb).astype(int).tolist(), list(PERSON)]
        self._words = LiveState([f"rgb({', '.join(map(str, ink))})" for ink in inks])
        session.wide.watch = lambda: self._show(session)

    def _show(self, session: FootageSessionRun) -> None:
        """Draw if somebody looks; wait while the session is paused."""
        now = time.monotonic()
        if now - self._asked_s < ASKED_S and now - self._drawn_s >= EVERY_S:
            self._draw(session, "session" if session.begun else "learning your face")
        if self._finish:
            if not session.begun:
                raise KeyboardInterrupt
            session.total = session.frame + 1
        if self._paused:
            self._draw(session, "paused")
            while self._paused and not self._finish:
                time.sleep(0.05)

    def _draw(self, session: FootageSessionRun, phase: str) -> None:
        assert self._drawing is not None and self._words is not None
        image, wide_image = jpeg(self._drawing.image(session)), jpeg(self._drawing.wide_image(session))
        state = self._words.of(session, phase)
        with self._lock:
            self._image, self._wide_image, self._state = image, wide_image, state
        self._drawn_s = time.monotonic()

    def _get(self, name: str) -> bytes:
        self._asked_s = time.monotonic()
        with self._lock:
            content: bytes = getattr(self, name)
        return content

    def _get_state(self) -> Mapping[str, Any]:
        self._asked_s = time.monotonic()
        with self._lock:
            return self._state

    def _press(self, button: str) -> bool:
        if button not in BUTTONS:
            return False
        self._paused, self._finish = button == "pause", self._finish or button == "finish"
        return True
