"""Who may talk to a server on this machine: its own pages, and no others that happen to be open in the same browser.

A browser lets any page open a websocket to any address, loopback too, and says in the header Origin which page it was.
A page can also let its own name point to this machine (DNS rebinding); the header Host then holds that name.
"""

import ipaddress
import socket
from collections.abc import Collection, Mapping
from urllib.parse import urlsplit


def refusal(headers: Mapping[str, str], names: Collection[str]) -> str | None:
    """Why a request is refused, or None; ``names``: hosts that are trusted beside localhost and plain addresses.

    A websocket must come from a page of the very host and port that it asks.
    """
    host = headers.get("Host", "").lower()
    name = _name(host)
    if name is None or not (name == "localhost" or name in {one.lower() for one in names} or _is_address(name)):
        return f"this server is not called {host[:100]!r}"
    if headers.get("Upgrade", "").lower() != "websocket":
        return None
    origin = headers.get("Origin", "").lower()
    return None if origin in (f"http://{host}", f"https://{host}") else f"{origin[:100]!r} is not a page of this server"


def names_of(host: str) -> set[str]:
    """Names under which a server is reached that listens on ``host``: none but itself on loopback."""
    return {host} if _is_address(host) and ipaddress.ip_address(host).is_loopback else {host, socket.gethostname()}


def _name(host: str) -> str | None:
    """The host without its port; None where it is none."""
    try:
        return urlsplit(f"//{host}").hostname
    except ValueError:
        return None


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
