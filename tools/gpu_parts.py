"""How many parts of the robot's images a graphics card draws in a second: ``python -m tools.gpu_parts --out FILE``.

What has changed in an image is seldom all of it, so that eye servers draw parts. Small parts fit changes better, and
large ones cost less a pixel. Needs the extra ``gpu``, and poses that ``tools.gpu_eye`` has left.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.io.files import write_whole
from jointattn_mj.scene.batched_parts import BatchedParts
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH, build_model
from tools.gpu_eye import BLOCK_S, BLOCKS, SessionPoses, card, measured

PARTS = ("8x24", "8x48", "8x120", "8x240", "16x48", "32x24", "64x48", "320x240")
SLOTS = (1024, 4096, 16384)
MOST_RAYS = 1 << 25
"""Larger batches are left out: they take no longer a part, and much memory."""


class WholeImages(BatchedParts):
    """Parts that are drawn slot after slot until whole images are there."""

    def set_poses(self, angles: np.ndarray, objects: np.ndarray) -> None:
        """Put poses into slots: as many slots as an image has parts have the same one."""
        _, high, wide, _ = self._shape
        corners = np.stack(np.meshgrid(range(0, IMAGE_WIDTH, wide), range(0, IMAGE_HEIGHT, high)), -1).reshape(-1, 2)
        image, part = np.divmod(np.arange(self.worlds), len(corners))
        super().set_poses(angles[image], objects[image])
        self.set_corners(corners[part])


def main() -> None:
    """Measure, and write and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="JSON file for the figures")
    parser.add_argument("--poses", type=Path, required=True, help="file of poses: python -m tools.gpu_eye --only-poses")
    parser.add_argument("--device", help="Warp's name of the device (default: the card, where there is one)")
    parser.add_argument("--parts", nargs="+", default=PARTS, help="sizes of parts, such as 8x48")
    parser.add_argument("--slots", type=int, nargs="+", default=SLOTS, help="parts that are drawn at once")
    parser.add_argument("--blocks", type=int, default=BLOCKS, help="blocks that are timed")
    parser.add_argument("--block-seconds", type=float, default=BLOCK_S, help="least seconds of a block")
    options = parser.parse_args()
    poses, model, rows = SessionPoses.read(options.poses), build_model(), list[dict[str, Any]]()
    for part, slots in ((part, slots) for part in options.parts for slots in options.slots):
        wide, high = map(int, part.split("x"))
        if slots * wide * high > MOST_RAYS:
            continue
        eye = WholeImages(model, slots, (wide, high), options.device)
        row = {"part": part, "slots": slots, **measured(eye, poses, options.blocks, options.block_seconds)}
        rows.append(row)
        print(json.dumps(row), flush=True)
        text = json.dumps(card(eye.device) | {"rows": rows}, indent=1) + "\n"
        del eye
        write_whole(options.out, lambda temporary, text=text: temporary.write_text(text))


if __name__ == "__main__":
    main()
