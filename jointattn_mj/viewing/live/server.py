"""A web server for one page, on this machine alone: images and numbers out, three buttons in.

It listens on the loopback interface. Its address holds a random key, so that other users of this machine do not see the
page either, and requests from pages of other sites are refused (see ``viewing.guard``). Nothing is written.
"""

import json
import secrets
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any

from jointattn_mj.errors import ConfigError
from jointattn_mj.viewing.guard import names_of, refusal

HERE = "127.0.0.1"
TRIED = 100
"""Ports that are tried, from the first one on."""
KEPT_AWAY = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": (
        "default-src 'self'; img-src 'self' data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
    ),
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
"""Headers that keep the images out of other pages, and out of the browser's store."""


@dataclass(frozen=True)
class Shown:
    """What a page asks for, each called in a thread of the server."""

    image: Callable[[], bytes]
    """The robot's image with its percept, as JPEG."""
    wide_image: Callable[[], bytes]
    """The wide image, as JPEG."""
    state: Callable[[], Mapping[str, Any]]
    """Numbers and words."""
    press: Callable[[str], bool]
    """A button was pressed; whether there is such a button."""


class LiveServer:
    """Serves a page from threads of its own.

    Attributes:
        address: URL of the page.
    """

    def __init__(self, shown: Shown, port: int):
        """Start.

        Args:
            shown: What the page asks for.
            port: First port to try; the next free one is taken.

        Raises:
            ConfigError: None of them is free.
        """
        key = secrets.token_urlsafe(12)
        handler = type("Handler", (_Handler,), {"shown": shown, "key": key})
        for tried in range(port, min(port + TRIED, 65536)):
            try:
                self._server = _Server((HERE, tried), handler)
                break
            except OSError as error:
                trouble = error
        else:
            raise ConfigError(f"no free `port` from {port} on ({trouble.strerror}); give another one")
        self.address = f"http://{HERE}:{self._server.server_port}/{key}/"
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.2}, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = False

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that went away needs no traceback."""


class _Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    shown: Shown
    key: str
    server_version, sys_version = "jointattn", ""
    timeout = 10

    def do_GET(self) -> None:
        """Page, images, numbers."""
        if self._refused(acts=False):
            return
        match self._asked():
            case "":
                page = (files("jointattn_mj.viewing.live") / "page.html").read_bytes()
                self._send("text/html; charset=utf-8", page)
            case "image.jpg":
                self._send("image/jpeg", self.shown.image())
            case "wide_image.jpg":
                self._send("image/jpeg", self.shown.wide_image())
            case "state.json":
                self._send("application/json", json.dumps(self.shown.state(), allow_nan=False).encode())
            case _:
                self._say(HTTPStatus.NOT_FOUND, "there is no such page here")

    def do_POST(self) -> None:
        """Buttons."""
        if self._refused(acts=True):
            return
        asked = self._asked()
        if asked is None or not self.shown.press(asked):
            self._say(HTTPStatus.NOT_FOUND, "there is no such button here")
            return
        self._send("application/json", b"{}")

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing."""

    def _asked(self) -> str | None:
        """What is asked for, behind the key; None without the key."""
        path = self.path.partition("?")[0]
        start = f"/{self.key}/"
        return path[len(start) :] if secrets.compare_digest(path[: len(start)].encode(), start.encode()) else None

    def _refused(self, acts: bool) -> bool:
        headers = dict(self.headers.items())
        if acts:
            headers = {
                **headers,
                "Upgrade": "websocket",
            }  # a button needs what a websocket needs: a page of this server
        reason = refusal(headers, names_of(HERE))
        if reason is None and headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
            reason = "another page asks"
        if reason is not None:
            self._say(HTTPStatus.FORBIDDEN, f"refused: {reason}")
        return reason is not None

    def _say(self, status: HTTPStatus, words: str) -> None:
        self._send("text/plain; charset=utf-8", f"{words}\n".encode(), status)

    def _send(self, kind: str, content: bytes, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.send_response(status)
        for name, value in {"Content-Type": kind, "Content-Length": str(len(content)), **KEPT_AWAY}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)
