"""The live view's server: one page for this machine, and nobody else."""

import json
from http import HTTPStatus
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

from jointattn_mj.viewing.live.server import LiveServer, Shown

PRESSED = []


@pytest.fixture(scope="module")
def server():
    shown = Shown(lambda: b"image", lambda: b"wide image", lambda: {"phase": "session"}, press)
    server = LiveServer(shown, 18_080)
    yield server
    server.close()


def press(button: str) -> bool:
    PRESSED.append(button)
    return button == "pause"


def ask(address: str, method: str = "GET", **headers: str):
    """Status, headers and content of an answer."""
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    try:
        with urlopen(Request(address, method=method, headers=named), timeout=10) as answer:
            return answer.status, dict(answer.headers), answer.read()
    except HTTPError as error:
        return error.code, dict(error.headers), error.read()


def test_what_the_page_asks_for(server):
    assert ask(server.address)[2].startswith(b"<!doctype html>")
    assert ask(f"{server.address}image.jpg?7")[2] == b"image"
    assert ask(f"{server.address}wide_image.jpg")[2] == b"wide image"
    status, headers, content = ask(f"{server.address}state.json")
    assert (status, json.loads(content)) == (HTTPStatus.OK, {"phase": "session"})
    assert headers["Cache-Control"] == "no-store"
    assert headers["Cross-Origin-Resource-Policy"] == "same-origin"


def test_only_this_machine_and_its_own_page_are_served(server):
    host = server.address.split("/")[2]
    assert server.address.startswith("http://127.0.0.1:")
    assert ask(f"http://{host}/")[0] == HTTPStatus.NOT_FOUND  # without the key
    assert ask(f"http://{host}/state.json")[0] == HTTPStatus.NOT_FOUND
    assert ask(f"{server.address}other")[0] == HTTPStatus.NOT_FOUND
    assert ask(server.address, Host="robot.example")[0] == HTTPStatus.FORBIDDEN  # DNS rebinding
    assert ask(f"{server.address}image.jpg", Sec_Fetch_Site="cross-site")[0] == HTTPStatus.FORBIDDEN


def test_buttons_need_the_page(server):
    host = server.address.split("/")[2]
    PRESSED.clear()
    assert ask(f"{server.address}pause", "POST")[0] == HTTPStatus.FORBIDDEN
    assert ask(f"{server.address}pause", "POST", Origin="http://robot.example")[0] == HTTPStatus.FORBIDDEN
    assert PRESSED == []
    assert ask(f"{server.address}pause", "POST", Origin=f"http://{host}")[0] == HTTPStatus.OK
    assert ask(f"{server.address}launch", "POST", Origin=f"http://{host}")[0] == HTTPStatus.NOT_FOUND
    assert PRESSED == ["pause", "launch"]


def test_the_next_free_port_is_taken(server):
    port = int(server.address.split("/")[2].partition(":")[2])
    other = LiveServer(Shown(lambda: b"", lambda: b"", dict, lambda button: False), port)
    assert int(other.address.split("/")[2].partition(":")[2]) > port
    other.close()
