"""Processes of our own that are joined to this one by connections, and import nothing of the user's program."""

import subprocess
import sys
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection


def start_child(
    module: str, function: str, connections: Sequence[Connection], environment: Mapping[str, str] | None = None
) -> "subprocess.Popen[bytes]":
    """Start a process that calls a function with connections, and hand these over to it.

    It has a session of its own: Ctrl-C and the end of the terminal are for this process, with which it ends.

    Args:
        module: In which the function is; modules are found where this process finds them.
        function: Its name; it takes a list of connections.
        connections: Ends of pipes. They are closed here.
        environment: Of the process; None for this one's.
    """
    numbers = [connection.fileno() for connection in connections]
    code = (
        f"import sys; sys.path[:] = {sys.path!r}; from multiprocessing.connection import Connection; "
        f"from {module} import {function}; {function}([Connection(number) for number in {numbers}])"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", code],
        pass_fds=numbers,
        stdin=subprocess.DEVNULL,
        env=environment and dict(environment),
        start_new_session=True,
    )
    for connection in connections:
        connection.close()
    return child
