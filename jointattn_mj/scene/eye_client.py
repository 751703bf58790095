"""What a process asks of an eye server, and gets from it."""

import os
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.reduction import send_handle

from jointattn_mj.errors import GLError, JointAttnError
from jointattn_mj.scene.batched_parts import PART_HEIGHT, PART_WIDTH
from jointattn_mj.scene.eye_block import EyeBlock, EyeBlockLayout, PartsRequest
from jointattn_mj.scene.model import SceneConfig

ENDED = "the process that draws images has ended; what it printed says why"


@dataclass(frozen=True)
class OpenBlock:
    """Message of a client: a block of this number has been made. Its file comes next."""

    number: int
    scene: SceneConfig
    layout: EyeBlockLayout


@dataclass(frozen=True)
class DrawBlock:
    """Message of a client: draw the parts of a block. The answer is its number, or an exception."""

    number: int
    parts: int


class EyeClient:
    """A process's line to an eye server.

    Args:
        connection: To the server.
        images: Images in a block.
    """

    def __init__(self, connection: Connection, images: int):
        self._connection, self._images = connection, images
        self._blocks: list[tuple[SceneConfig, EyeBlock]] = []

    def open(self, request: PartsRequest) -> EyeBlock:
        """A new block, for requests of the same scene as this one.

        Raises:
            GLError: The server has ended.
        """
        height, width = request.image.shape[:2]
        parts = -(-height // PART_HEIGHT) * -(-width // PART_WIDTH)
        sizes = len(request.angles), len(request.positions), self._images, parts, PART_WIDTH * PART_HEIGHT
        block = EyeBlock(EyeBlockLayout(*sizes), number=len(self._blocks))
        self._send(OpenBlock(block.number, request.scene, block.layout), block)
        os.close(block.file)
        self._blocks.append((request.scene, block))
        return block

    def submit(self, block: EyeBlock) -> None:
        """Ask for what was added to a block.

        Raises:
            GLError: The server has ended.
        """
        self._send(DrawBlock(block.number, block.filled))

    def receive(self) -> tuple[SceneConfig, EyeBlock]:
        """Wait for the next block that is drawn, with its scene; the parts are in the images that asked for them then.

        Raises:
            GLError: The server has ended.
            ExtraError: It misses the extra ``gpu``.
        """
        try:
            answer = self._connection.recv()
        except (EOFError, OSError) as error:
            raise GLError(ENDED) from error
        if isinstance(answer, JointAttnError):
            raise answer
        scene, block = self._blocks[answer]
        block.deliver(PART_WIDTH)
        return scene, block

    def _send(self, message: object, block: EyeBlock | None = None) -> None:
        """Send a message, and the file of a block after it."""
        try:
            self._connection.send(message)
            if block is not None:
                send_handle(self._connection, block.file, None)
        except OSError:
            while True:  # up to what the server has said last
                self.receive()
