"""Refuses requests to a server on this machine that do not come from its own pages.

A browser lets any page open a websocket to any address, loopback too; the header Origin says which page it was. A page
can also let its own name point to this machine (DNS rebinding); the header Host then holds that name.
"""

import ipaddress
import socket
from collections.abc import Collection, Mapping
from urllib.parse import urlsplit


def refusal(headers: Mapping[str, str], names: Collection[str]) -> str | None:
    """Decide about a request. A websocket must come from a page of the host and port that it asks.

    Args:
        headers: Of the request.
        names: Hosts that are trusted, beside localhost and plain addresses.

    Returns:
        Why the request is refused; None if it is not.
    """
    host = headers.get("Host", "").lower()
    name = _name(host)
    if name is None or not (name == "localhost" or name in {known.lower() for known in names} or _is_address(name)):
        return f"this server is not called {host[:100]!r}"
    if headers.get("Upgrade", "").lower() != "websocket":
        return None
    origin = headers.get("Origin", "").lower()
    return None if origin in (f"http://{host}", f"https://{host}") else f"{origin[:100]!r} is not a page of this server"


def names_of(host: str) -> set[str]:
    """Names under which a server that listens on ``host`` is reached; on loopback its own alone."""
    return {host} if _is_address(host) and ipaddress.ip_address(host).is_loopback else {host, socket.gethostname()}


def _name(host: str) -> str | None:
    """The host without its port; None if it is no host."""
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
