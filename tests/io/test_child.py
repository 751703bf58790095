"""Processes of our own that are joined to this one by connections."""

import os
from multiprocessing import Pipe

from jointattn_mj.io.child import start_child


def test_a_child_ends_with_its_connections_and_is_not_meant_by_ctrl_c():
    ours, theirs = Pipe()
    child = start_child("multiprocessing.connection", "wait", [theirs])
    assert os.getsid(child.pid) == child.pid, "the terminal's signals are for the parent"
    assert child.poll() is None
    ours.close()
    assert child.wait(60) == 0
