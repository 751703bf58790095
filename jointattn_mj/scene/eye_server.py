"""A process that draws the images of many others on one graphics card.

Clients share blocks of memory with it (``eye_block``). Their requests are gathered into batches: while the card draws
one, the parts of the next are gathered, and those of the last are given out.
"""

import os
import signal
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.reduction import recv_handle
from typing import Any

import numpy as np

from jointattn_mj.errors import GLError, JointAttnError
from jointattn_mj.io.extras import extra
from jointattn_mj.scene.batched_parts import BatchedParts
from jointattn_mj.scene.eye_block import EyeBlock
from jointattn_mj.scene.eye_client import OpenBlock
from jointattn_mj.scene.model import SceneConfig, build_model

SLOTS = 16384
"""Parts that are drawn at once: some 80 whole images of 200, a few milliseconds of the card's time."""
FEW = 256
"""The same without a card, where a part that nobody wants takes time too."""


@dataclass
class _Job:
    """A block whose parts are to be drawn."""

    connection: Connection
    number: int
    block: EyeBlock
    parts: int
    begun: int = 0
    drawn: int = 0


class _Batch:
    """One of the two batches of a scene: what is drawn, and for whom."""

    def __init__(self, scene: SceneConfig, slots: int, device: str | None):
        self.eye = BatchedParts(build_model(scene), slots, device=device)
        self.shares: list[tuple[_Job, int, int]] = []
        self._warp = extra("gpu", "warp")
        self._stream = self._warp.Stream(self.eye.device) if self.eye.device.is_cuda else None
        with self._in_stream():
            self.eye.set_corners(np.zeros((0, 2), np.int32))
            if self._stream is not None:
                self.eye.capture()

    def _in_stream(self) -> Any:
        return self._warp.ScopedStream(self._stream)

    def begin(self, jobs: deque[_Job]) -> None:
        """Take parts from ``jobs``, from which those that have no more are removed, and start to draw them."""
        eye, taken, corners = self.eye, 0, []
        while jobs and taken < eye.worlds:
            job = jobs[0]
            first, last = job.begun, min(job.parts, job.begun + eye.worlds - taken)
            images, slots = job.block.images[first:last], slice(taken, taken + last - first)
            eye.angles[slots], eye.objects[slots] = job.block.angles[images], job.block.positions[images]
            corners.append(job.block.corners[first:last])
            self.shares.append((job, first, last))
            taken, job.begun = taken + last - first, last
            if last == job.parts:
                jobs.popleft()
        eye.set_corners(np.concatenate(corners))
        with self._in_stream():
            eye.draw()
            eye.copy()

    def finish(self) -> None:
        """Wait for what was drawn, and give it out."""
        if self._stream is not None:
            self._warp.synchronize_stream(self._stream)
        pixels, taken = self.eye.packed(), 0
        for job, first, last in self.shares:
            job.block.pixels[first:last] = pixels[taken : taken + last - first]
            taken, job.drawn = taken + last - first, job.drawn + last - first
            if job.drawn == job.parts:
                _answer(job.connection, job.number)
        self.shares = []


def _answer(connection: Connection, message: object) -> None:
    with suppress(OSError):  # a client that is gone shows at the next look at its connection
        connection.send(message)


class EyeServer:
    """Draws for clients until all are gone."""

    def __init__(self, connections: Sequence[Connection], device: str | None = None, slots: int | None = None):
        """Get ready.

        Args:
            connections: To the clients.
            device: Warp's name of the device; None for the card, where there is one.
            slots: Parts that are drawn at once; None for what suits the device.

        Raises:
            ExtraError: The extra ``gpu`` is not installed.
        """
        chosen = extra("gpu", "warp").get_device(device)
        self._connections = list(connections)
        self._device, self._slots = device, slots or (SLOTS if chosen.is_cuda else FEW)
        self._blocks: dict[tuple[Connection, int], tuple[SceneConfig, EyeBlock]] = {}
        self._waiting: dict[SceneConfig, deque[_Job]] = {}
        self._batches: dict[SceneConfig, deque[_Batch]] = {}

    def run(self) -> None:
        """Serve until the last client is gone."""
        drawing: _Batch | None = None
        while self._connections:
            self._receive(patient=drawing is None and not any(self._waiting.values()))
            begun = self._begin()
            if drawing is not None:
                drawing.finish()
            drawing = begun

    def _receive(self, patient: bool) -> None:
        """Take the messages that have come; if ``patient``, wait for one."""
        for ready in wait(self._connections, None if patient else 0):
            connection: Any = ready
            try:
                message = connection.recv()
                file = recv_handle(connection) if isinstance(message, OpenBlock) else None
            except (EOFError, OSError):
                self._connections.remove(connection)
                continue
            if isinstance(message, OpenBlock):
                block = EyeBlock(message.layout, file)
                os.close(block.file)
                self._blocks[connection, message.number] = message.scene, block
            else:
                scene, block = self._blocks[connection, message.number]
                job = _Job(connection, message.number, block, message.parts)
                self._waiting.setdefault(scene, deque()).append(job)

    def _begin(self) -> _Batch | None:
        """Start to draw the next batch, if anything is wanted."""
        scene = next((scene for scene, jobs in self._waiting.items() if jobs), None)
        if scene is None:
            return None
        if scene not in self._batches:
            self._batches[scene] = deque(_Batch(scene, self._slots, self._device) for _ in range(2))
        self._batches[scene].rotate()
        self._batches[scene][0].begin(self._waiting[scene])
        self._waiting[scene] = self._waiting.pop(scene)  # the others come first now
        return self._batches[scene][0]


def serve_eyes(connections: Sequence[Connection], device: str | None = None, slots: int | None = None) -> None:
    """Serve in this process; an error goes to all clients. For the arguments see :class:`EyeServer`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        warp = extra("gpu", "warp")
        warp.config.log_level = warp.LOG_WARNING
        EyeServer(connections, device, slots).run()
    except Exception as error:
        for connection in connections:
            _answer(connection, _told(error))


def _told(error: Exception) -> JointAttnError:
    """An error as one that every process can read."""
    if isinstance(error, JointAttnError):
        return error
    return GLError(f"the process that draws images has stopped: {type(error).__name__}: {error}")
