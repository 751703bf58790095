"""A worker that computes many trials at once, taking up another whenever one waits for an image.

Each trial is a greenlet: it stops where it asks for an image, and goes on when it is drawn. The requests of many make a
block for the eye server; two blocks take turns, so that one half of the trials compute while the other waits.
"""

import os
import pickle
from collections import deque
from functools import partial
from multiprocessing.connection import Connection
from typing import Any

from jointattn_mj.errors import JointAttnError
from jointattn_mj.io.extras import extra
from jointattn_mj.parallel.crowd import ALL
from jointattn_mj.scene.eye_block import EyeBlock, PartsRequest
from jointattn_mj.scene.eye_client import EyeClient
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.warp_eye import parts_drawn_by
from jointattn_mj.sweeps.worker import start


class CrowdWorker:
    """Computes the functions that come through a connection, and sends their results back."""

    def __init__(self, tasks: Connection, eyes: Connection, at_once: int):
        """Get ready.

        Args:
            tasks: From which (number, packed) come, a pickled function and its arguments; (number, result, error) go
                back.
            eyes: To the eye server.
            at_once: Trials at once.

        Raises:
            ExtraError: The extra ``gpu`` is not installed.
        """
        self._greenlet = extra("gpu", "greenlet")
        self._tasks = tasks
        self._client = EyeClient(eyes, max(1, -(-at_once // 2)))
        self._ready: deque[Any] = deque()
        self._open: dict[SceneConfig, list[EyeBlock]] = {}
        self._waiting: dict[int, list[Any]] = {}
        self._drawn = 0  # blocks that the server has
        self._alive = 0

    def run(self) -> None:
        """Work until the connection is closed.

        Raises:
            JointAttnError: The eye server has ended, and with it all trials.
        """
        while True:
            while self._tasks.poll(None if not self._alive else 0):
                try:
                    number, packed = self._tasks.recv()
                except EOFError:
                    return
                trial = partial(self._compute, number, packed, self._greenlet.getcurrent())
                self._ready.append(self._greenlet.greenlet(trial))
                self._alive += 1
            while self._ready:
                self._go_on(self._ready.popleft())
            for blocks in self._open.values():
                if blocks and blocks[0].requests:
                    self._submit(blocks)
            if self._drawn:
                self._take_images()

    def _compute(self, number: int, packed: bytes, hub: Any) -> None:
        """Compute a trial, whose images are drawn while others go on; ``hub`` is the greenlet of this worker."""
        try:
            function, arguments = pickle.loads(packed)
            with parts_drawn_by(hub.switch):
                result, error = function(*arguments), None
        except Exception as raised:
            result, error = None, raised
        self._tasks.send((number, result, error))

    def _go_on(self, trial: Any) -> None:
        """Let a trial go on to its next image or its end."""
        request: PartsRequest = trial.switch()
        if trial.dead:
            self._alive -= 1
        else:
            self._ask(request, trial)

    def _ask(self, request: PartsRequest, trial: Any) -> None:
        """Fill a request in, and submit its block when it is full, or half of all trials wait for it."""
        if request.scene not in self._open:
            self._open[request.scene] = [self._client.open(request) for _ in range(2)]
        blocks = self._open[request.scene]
        while not blocks:  # both are with the server
            self._take_images()
        blocks[0].add(request)
        self._waiting.setdefault(id(blocks[0]), []).append(trial)
        if blocks[0].full or 2 * len(blocks[0].requests) >= self._alive:
            self._submit(blocks)

    def _submit(self, blocks: list[EyeBlock]) -> None:
        """Give the first of a scene's blocks at hand to the server."""
        self._client.submit(blocks.pop(0))
        self._drawn += 1

    def _take_images(self) -> None:
        """Wait for a block from the server; the trials that wait for its images can go on."""
        scene, block = self._client.receive()
        self._drawn -= 1
        self._open[scene].append(block)
        self._ready += self._waiting.pop(id(block))


def work(connections: list[Connection]) -> None:
    """Work in this process; the connections are that for tasks, and that to the eye server."""
    tasks, eyes = connections
    start()
    at_once: int = tasks.recv()
    try:
        CrowdWorker(tasks, eyes, at_once).run()
    except JointAttnError as error:
        tasks.send((ALL, None, error))
        os._exit(1)  # trials that are let go of would answer too
