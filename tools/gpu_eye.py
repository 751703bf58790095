"""How many of the robot's images a graphics card draws in a second: ``python -m tools.gpu_eye --out gpu_eye.json``.

MuJoCo Warp casts the rays of many worlds at once. A session from the state gives the poses; OpenGL draws some of them
in a process of its own, since EGL and Warp hang where they meet in one. Needs the extra ``gpu``.
"""

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.io.extras import extra
from jointattn_mj.io.files import write_whole
from jointattn_mj.scene.batched_eye import TILES, BatchedEye
from jointattn_mj.scene.model import build_model

SIZES = ("320x240", "160x120", "80x60", "64x64")
WORLDS = (64, 256, 1024, 4096)
EVERY = 15
"""Frames of the session from one pose to the next."""
DRAWN = 64
"""Poses of which OpenGL draws an image."""
VARIED = "320x240"
"""Size at which other orders of the rays, and more rays a pixel, are tried, with ``--varied-at`` worlds."""
VARIANTS: tuple[dict[str, Any], ...] = (
    {"tiles": ((4, 8),)}, {"tiles": ((16, 2),)}, {"tiles": (*TILES, (16, 16))}, {"tiles": (*TILES, (32, 32))},
    {"tiles": (*TILES, (8, 32))}, {"samples": 2},
)  # fmt: skip
BLOCKS, BLOCK_S = 7, 0.1
"""Blocks that are timed, and the least seconds of each."""
PACKAGES = ("mujoco", "mujoco-warp", "warp-lang", "numpy")


@dataclass(frozen=True)
class SessionPoses:
    """Where bodies are in many moments of a session."""

    angles: np.ndarray
    """(n, nq) positions of all joints, float32."""
    objects: np.ndarray
    """(n, k, 3) positions of the objects, world frame, metres, float32."""
    images: np.ndarray
    """(m, 240, 320, 3) uint8 RGB, what OpenGL draws of the first m; none where it is not to be had."""
    renderer: str
    """OpenGL's name of the renderer, or why there is none."""

    @classmethod
    def of_session(cls, count: int, seed: int = 0) -> "SessionPoses":
        """Moments of a session from the state, and OpenGL's images of the first of them.

        Args:
            count: Number of moments.
            seed: Of the session.
        """
        from jointattn_mj.errors import GLError
        from jointattn_mj.gaze_following.session import SessionConfig, SessionRun

        run = SessionRun(SessionConfig(minutes=1 + count * EVERY / 1800, seed=seed, perception="state"))
        run.begin()
        world, angles, objects, images, renderer = run.world, [], [], [], ""
        for moment in range(count):
            for _ in range(EVERY):
                run.step()
            angles.append(world.data.qpos.astype(np.float32))
            objects.append(world.data.mocap_pos.astype(np.float32))
            try:
                if moment < DRAWN and not renderer:
                    images.append(world.image().copy())
            except GLError as error:
                renderer = str(error)
        if images:
            with world.physics.contexts.gl.make_current() as context:
                renderer = context.call(_renderer_name)
        run.close()
        return cls(np.array(angles), np.array(objects), np.array(images, np.uint8), renderer)

    @classmethod
    def read(cls, path: Path) -> "SessionPoses":
        with np.load(path) as kept:
            return cls(kept["angles"], kept["objects"], kept["images"], str(kept["renderer"]))

    def write(self, path: Path) -> None:
        write_whole(path, lambda temporary: _save(temporary, self))

    def taken(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Angles and objects of ``count`` poses, the first again after the last."""
        numbers = np.arange(count) % len(self.angles)
        return self.angles[numbers], self.objects[numbers]


def _save(path: Path, poses: SessionPoses) -> None:
    with path.open("wb") as file:
        np.savez_compressed(file, **asdict(poses))


def _renderer_name() -> str:
    from OpenGL import GL

    return str(GL.glGetString(GL.GL_RENDERER).decode())


def seconds(work: Callable[[], None], wait: Callable[[], None], blocks: int, least: float) -> list[float]:
    """Seconds of a call of ``work``, in each of some blocks.

    Args:
        work: Gives work to the device.
        wait: Waits until all is done.
        blocks: Their number.
        least: Seconds that a block takes at least.
    """
    work()
    wait()
    start = time.perf_counter()
    work()
    wait()
    repeats = max(1, round(least / (time.perf_counter() - start)))
    times = []
    for _ in range(blocks):
        start = time.perf_counter()
        for _ in range(repeats):
            work()
        wait()
        times.append((time.perf_counter() - start) / repeats)
    return times


def measured(eye: BatchedEye, poses: SessionPoses, blocks: int = BLOCKS, least: float = BLOCK_S) -> dict[str, Any]:
    """Microseconds an image of each part, and images a second: medians and quartiles over blocks.

    Args:
        eye: What draws the images.
        poses: Of all worlds, from sessions.
        blocks: Number of blocks that are timed.
        least: Least length of a block, seconds.

    Returns:
        pose_us, refit_us, cast_us: of the parts of ``draw``, each alone. draw_us: of all three in a row; graph_us: by a
        graph, on a card. copy_us: of bringing the image to the host. images_per_s, graph_images_per_s: from draw_us and
        graph_us.
    """
    eye.set_poses(*poses.taken(eye.worlds))
    eye.draw()
    works = {"pose": eye.pose, "refit": eye.refit, "cast": eye.cast, "draw": eye.draw, "copy": eye.copy}
    row = {}
    with extra("gpu", "warp").ScopedDevice(eye.device):
        for name, work in works.items():
            row |= _figures(name, seconds(work, eye.wait, blocks, least), eye.worlds)
        if eye.device.is_cuda:
            eye.capture()
            row |= _figures("graph", seconds(eye.draw, eye.wait, blocks, least), eye.worlds)
    return row


def _figures(name: str, times: list[float], worlds: int) -> dict[str, list[float]]:
    """Median and quartiles of microseconds an image, and of images a second where whole images are drawn."""
    each = np.array(times) / worlds
    row = {f"{name}_us": (1e6 * np.percentile(each, (50, 25, 75))).tolist()}
    whole = {"draw": "images_per_s", "graph": "graph_images_per_s"}.get(name)
    return row | ({whole: (1 / np.percentile(each, (50, 75, 25))).tolist()} if whole else {})


def difference(first: np.ndarray, second: np.ndarray) -> dict[str, float]:
    """How far images (n, h, w, 3) uint8 lie apart: mean |difference| in grey levels, shares of pixels off by more."""
    apart = np.abs(first.astype(int) - second.astype(int))
    most = apart.max(axis=3)
    return {
        "images": len(first),
        "mean": float(apart.mean()),
        "off_by_more_than_2": float((most > 2).mean()),
        "off_by_more_than_16": float((most > 16).mean()),
    }


def card(device: Any) -> dict[str, Any]:
    """Name of Warp's device, driver, date and versions."""
    about = {"device": device.name, "date": date.today().isoformat()}
    asked = ["nvidia-smi", "--query-gpu=driver_version", "--format=csv,noheader"]
    if device.is_cuda:
        about["driver"] = subprocess.run(asked, capture_output=True, text=True, timeout=60).stdout.strip()
    return {**about, "versions": {name: version(name) for name in PACKAGES}}


def main() -> None:
    """Measure, and write and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="JSON file for the figures")
    parser.add_argument("--poses", type=Path, help="file of poses; made where it is not there (default: beside --out)")
    parser.add_argument("--only-poses", action="store_true", help="make the poses, and measure nothing")
    parser.add_argument("--device", help="Warp's name of the device (default: the card, where there is one)")
    parser.add_argument("--worlds", type=int, nargs="+", default=WORLDS, help="worlds that are drawn at once")
    parser.add_argument("--varied-at", type=int, default=1024, help=f"worlds for other orders of rays at {VARIED}")
    parser.add_argument("--sizes", nargs="+", default=SIZES, help="sizes of images, such as 320x240")
    parser.add_argument("--blocks", type=int, default=BLOCKS, help="blocks that are timed")
    parser.add_argument("--block-seconds", type=float, default=BLOCK_S, help="least seconds of a block")
    options = parser.parse_args()
    kept = options.poses or options.out.with_suffix(".npz")
    if options.only_poses:
        SessionPoses.of_session(max(options.worlds)).write(kept)
        return
    if not kept.exists():  # in a process of its own
        words = f"-m tools.gpu_eye --only-poses --worlds {max(options.worlds)}".split()
        subprocess.run([sys.executable, *words, "--poses", kept, "--out", options.out], check=True)
    poses, model = SessionPoses.read(kept), build_model()
    device = extra("gpu", "warp").get_device(options.device)
    figures, rows = card(device) | {"opengl": poses.renderer}, []
    if len(poses.images):
        eye = BatchedEye(model, len(poses.images), device=options.device)
        eye.set_poses(*poses.taken(eye.worlds))
        start = time.perf_counter()
        own = (eye.draw(), eye.images())[1]
        figures |= {"first_images_s": time.perf_counter() - start, "to_opengl": difference(own, poses.images)}
    for size, worlds in ((size, worlds) for size in options.sizes for worlds in options.worlds):
        width, height = map(int, size.split("x"))
        ways: list[dict[str, Any]] = [{"tiles": TILES}, {"tiles": ()}]
        for way in [*ways, *(VARIANTS if (size, worlds) == (VARIED, options.varied_at) else ())]:
            eye = BatchedEye(model, worlds, width, height, options.device, **way)
            rows.append({"size": size, "worlds": worlds, **way})
            rows[-1] |= measured(eye, poses, options.blocks, options.block_seconds)
            del eye
            print(json.dumps(rows[-1]), flush=True)
            text = json.dumps(figures | {"rows": rows}, indent=1) + "\n"
            write_whole(options.out, lambda temporary, text=text: temporary.write_text(text))


if __name__ == "__main__":
    main()
