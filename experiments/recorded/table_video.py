"""A caregiver at a table as a fixed wide camera at the robot's eye sees it: a video, and where the caregiver looks.

``python -m experiments.recorded.table_video --out FOLDER`` leaves ``table.mp4`` and ``coding.csv``. The caregiver is
the one of a session with the same seed, to the frame: three minutes of familiarisation, and then the session.
"""

import argparse
import csv
from pathlib import Path

import numpy as np

from jointattn_mj.gaze_following.agent import FamiliariseConfig
from jointattn_mj.io.files import write_whole
from jointattn_mj.scene.camera import FOCAL_PX, Eye
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.sensor import Sensor
from jointattn_mj.scene.world import World, WorldConfig
from jointattn_mj.video.reel import Reel

WIDTH, HEIGHT = 880, 640
"""Size of the video, pixels."""
FOV_DEG = float(np.degrees(2 * np.arctan(WIDTH / 2 / FOCAL_PX)))
"""Its horizontal angle of view, so that a pixel in its middle is as large as one of the robot's."""
TILT_DEG = -6.5
"""Elevation of the camera: midway between the face and the table."""
MINUTES = FamiliariseConfig().minutes + 26.0
"""Length of the video of a whole session."""
TIER = "looks at"


class WideEyedWorld(World):
    """A rendered world whose eye never turns, and has a wide lens."""

    def wide_eye(self) -> Eye:
        """The lens; the eye of the robot is taken for it."""
        size = self.model.vis.global_
        size.offwidth, size.offheight = WIDTH, HEIGHT
        self.model.cam_fovy[self.model.camera("robot/eye").id] = np.degrees(2 * np.arctan(HEIGHT / 2 / FOCAL_PX))
        return Eye(self.physics, width=WIDTH, height=HEIGHT)

    def hold(self) -> np.ndarray:
        """Put the eye where it stays; returns the command (2,), rad, that keeps it there."""
        head = np.array([0.0, np.radians(TILT_DEG)])
        self._head_angles[:] = head
        return head


def write_video(
    folder: Path, seed: int, minutes: float = MINUTES, config: WorldConfig | None = None, noise: float = 0.0
) -> None:
    """Write ``coding.csv`` and ``table.mp4``.

    Args:
        folder: Is made when missing.
        seed: Of the session whose caregiver it is.
        minutes: Length of the video.
        config: Scene and caregiver; None for those of a session.
        noise: Standard deviation of the camera's noise, grey values.
    """
    config, frames = config or WorldConfig(), round(minutes * 60 / FRAME_S)
    folder.mkdir(parents=True, exist_ok=True)
    _write_coding(folder / "coding.csv", targets(seed, frames, config), [item.name for item in config.scene.objects])
    world, sensor = _world(seed, config), Sensor(noise=noise, seed=seed)
    eye = world.wide_eye()
    try:
        with Reel(folder / "table.mp4", HEIGHT, WIDTH, 1 / FRAME_S) as reel:
            command = world.hold()
            for frame in range(frames):
                image = eye.render()
                sensor.expose(image, frame)
                reel.add(image)
                world.step(command)
    finally:
        world.close()


def targets(seed: int, frames: int, config: WorldConfig) -> list[int | None]:
    """Number of the object at which the caregiver looks in each frame; None for the robot. Nothing is rendered.

    Args:
        seed: Of the session.
        frames: Number of frames, 30 a second.
        config: Scene and caregiver.
    """
    world, command, found = _world(seed, config), np.zeros(2), list[int | None]()
    for _ in range(frames):
        found.append(world.caregiver.target)
        world.step(command)
    world.close()
    return found


def _world(seed: int, config: WorldConfig) -> WideEyedWorld:
    """The world of a session with this seed."""
    return WideEyedWorld.build(config, np.random.SeedSequence(seed).spawn(3)[0])


def _write_coding(path: Path, targets: list[int | None], names: list[str]) -> None:
    write_whole(path, lambda temporary: _write_rows(temporary, targets, names))


def _write_rows(path: Path, targets: list[int | None], names: list[str]) -> None:
    codes = ["partner" if target is None else names[target] for target in targets]
    starts = [i for i in range(len(codes)) if i == 0 or codes[i] != codes[i - 1]]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["onset_s", "offset_s", "tier", "code"])
        for start, end in zip(starts, [*starts[1:], len(codes)], strict=True):
            writer.writerow([f"{start * FRAME_S:.3f}", f"{end * FRAME_S:.3f}", TIER, codes[start]])


def main() -> None:
    """Write the video of a seed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, required=True, help="folder; made when missing")
    parser.add_argument("--seed", type=int, default=0, help="of the session whose caregiver it is")
    parser.add_argument("--minutes", type=float, default=MINUTES, help="length of the video")
    parser.add_argument("--noise", type=float, default=0.0, help="of the camera, grey values")
    given = parser.parse_args()
    write_video(given.out, given.seed, given.minutes, noise=given.noise)


if __name__ == "__main__":
    main()
