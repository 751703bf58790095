"""An eye whose images MuJoCo Warp draws, in another process, together with those of other worlds."""

import atexit
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from multiprocessing import Pipe
from typing import Literal

import numpy as np
from dm_control.mujoco import Physics

from jointattn_mj.io.child import start_child
from jointattn_mj.scene.batched_parts import PART_HEIGHT, PART_WIDTH
from jointattn_mj.scene.eye_block import EyeBlock, PartsRequest
from jointattn_mj.scene.eye_client import EyeClient
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.redrawing import RedrawingEye

DrawParts = Callable[[PartsRequest], None]
"""Returns when the parts of a request are in its image."""
_draw_parts: ContextVar[DrawParts | None] = ContextVar("_draw_parts", default=None)


@contextmanager
def parts_drawn_by(draw: DrawParts) -> Iterator[None]:
    """Within the block, the images of all eyes of this kind are drawn by ``draw``, not by a server of this process."""
    token = _draw_parts.set(draw)
    try:
        yield
    finally:
        _draw_parts.reset(token)


class WarpEye(RedrawingEye):
    """Has its images drawn by an eye server: all of each, or what has changed since the last one."""

    def __init__(self, physics: Physics, scene: SceneConfig, draws: Literal["all", "changes"]):
        """Prepare to draw.

        Args:
            physics: Whose scene.
            scene: From which it was compiled.
            draws: What of an image is drawn while the head stands still.
        """
        super().__init__(physics)
        self._shadows = False  # Warp draws none
        self._scene, self._anew = scene, draws == "all"
        height, width = self._buffer.shape[:2]
        self._grid = np.stack(np.meshgrid(range(0, width, PART_WIDTH), range(0, height, PART_HEIGHT)), -1)

    def render(self) -> np.ndarray:
        """The image now; see ``Eye.render``.

        Raises:
            ExtraError: The extra ``gpu`` is not installed.
            GLError: The eye server has ended.
        """
        if self._anew:
            self.forget()
        return super().render()

    def _render_all(self) -> None:
        height, width = self._buffer.shape[:2]
        self._render_part(0, 0, width, height)

    def _render_part(self, x0: int, y0: int, x1: int, y1: int) -> None:
        data = self._physics.data.ptr
        rows = slice(y0 // PART_HEIGHT, -(-y1 // PART_HEIGHT))
        columns = slice(x0 // PART_WIDTH, -(-x1 // PART_WIDTH))
        corners = self._grid[rows, columns].reshape(-1, 2)
        draw = _draw_parts.get() or OwnServer.draw
        draw(PartsRequest(self._scene, data.qpos, data.mocap_pos, corners, self._buffer))


class OwnServer:
    """An eye server for this process alone, which ends with it."""

    _lock = threading.Lock()
    _now: "OwnServer | None" = None

    def __init__(self) -> None:
        ours, others = Pipe()
        self._process = start_child("jointattn_mj.scene.eye_server", "serve_eyes", [others])
        self._connection, self._client = ours, EyeClient(ours, images=1)
        self._blocks: dict[SceneConfig, EyeBlock] = {}
        atexit.register(self._stop)
        os.register_at_fork(after_in_child=self._leave_alone)

    @classmethod
    def draw(cls, request: PartsRequest) -> None:
        """Draw the parts of a request; any thread may ask for it.

        Raises:
            ExtraError: The extra ``gpu`` is not installed.
            GLError: The server has ended; the next request gets another.
        """
        with cls._lock:
            server = cls._now = cls._now or cls()
            try:
                server._draw(request)
            except BaseException:  # after Ctrl-C too: its answer would be taken for that to the next request
                cls._now = None
                server._process.kill()
                server._stop()
                raise

    def _draw(self, request: PartsRequest) -> None:
        if request.scene not in self._blocks:
            self._blocks[request.scene] = self._client.open(request)
        self._blocks[request.scene].add(request)
        self._client.submit(self._blocks[request.scene])
        self._client.receive()

    def _leave_alone(self) -> None:
        """In a process that was forked: this is its parent's."""
        self._connection.close()
        OwnServer._lock, OwnServer._now = threading.Lock(), None

    def _stop(self) -> None:
        atexit.unregister(self._stop)
        self._connection.close()
        self._process.wait()
