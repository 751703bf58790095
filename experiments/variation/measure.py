"""Presets of domain randomisation: what they look like, and how often face and objects are found under each.

    python -m experiments.variation.measure --figure experiments/figures/variation.jpg \\
        --out experiments/variation/measured.json
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import tyro

from jointattn_mj.io.files import write_whole
from jointattn_mj.options import Checked, Seed, Whole
from jointattn_mj.perception.faces import FaceDetectorConfig, haar_faces
from jointattn_mj.perception.objects import ColourAreas
from jointattn_mj.scene.camera import in_image, pixels_of_points
from jointattn_mj.scene.objects import OBJECTS
from jointattn_mj.scene.variation import PRESETS
from jointattn_mj.scene.world import World
from jointattn_mj.tasks import load

FRAMES = 12
"""Steps of an episode before an image is taken: the caregiver still looks at the robot."""
FACE_PX, OBJECT_PX = 10.0, 8.0
"""Distance (px) from the true position within which a detection counts."""
SHOWN, WIDTH, HEIGHT = 6, 200, 150
"""Images a preset in the figure, and their size in pixels."""


@dataclass(frozen=True)
class VariationOptions(Checked):
    """What to leave where."""

    figure: Path | None = None
    """JPEG file for a sheet with a row a preset."""
    out: Path | None = None
    """JSON file for the rates."""
    draws: Annotated[int, Whole("[1, 1e6]")] = 60
    """Episodes a preset."""
    seed: Seed = 100
    """Of the episodes."""


def detected(image: np.ndarray, world: World, colours: ColourAreas) -> tuple[bool, int, int]:
    """Whether OpenCV's cascade finds the face, how many objects their colours find, and how many are in view.

    Args:
        image: RGB image (240, 320, 3) uint8 of the robot's eye.
        world: The scene, for the ground truth.
        colours: What finds the objects.
    """
    truth = pixels_of_points(world.candidate_points(), np.degrees(world.head_angles()))
    faces = haar_faces(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), FaceDetectorConfig())
    areas = colours.nothing()
    colours.find(image, np.empty(image.shape[:2], np.uint8), areas)
    near = np.linalg.norm(areas.px - truth[:-1], axis=1) < OBJECT_PX
    view = in_image(truth[:-1])
    face = len(faces) > 0 and np.linalg.norm(faces[0, :2] - truth[-1]) < FACE_PX
    return bool(face), int(np.sum(near & view)), int(view.sum())


def measure(preset: str, options: VariationOptions) -> tuple[dict[str, int], np.ndarray]:
    """Number of faces and objects found in a number of draws, and the first images side by side."""
    settings = {"random": options.seed, "variation": preset}
    environment = load("joint_attention", "object_transfer", task_kwargs=settings)
    colours = ColourAreas([item.rgb for item in OBJECTS[:4]])
    rows, images = [], []
    for _ in range(options.draws):
        environment.reset()
        for _ in range(FRAMES):
            step = environment.step(np.zeros(2))
        rows.append(detected(step.observation["camera"], environment.task.world, colours))
        images.append(step.observation["camera"])
    environment.close()
    faces, objects, in_view = np.sum(rows, axis=0).tolist()
    band = np.hstack([cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA) for image in images[:SHOWN]])
    for colour, thickness in (((255, 255, 255), 3), ((0, 0, 0), 1)):
        cv2.putText(band, preset, (6, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.55, colour, thickness, cv2.LINE_AA)
    return {"draws": options.draws, "faces": faces, "objects": objects, "objects_in_view": in_view}, band


def main(options: VariationOptions) -> None:
    """Measure every preset and print, one a line; leave the files that were asked for."""
    rates, bands = {}, []
    for preset in PRESETS:
        rates[preset], band = measure(preset, options)
        bands.append(band)
        print(preset, rates[preset])
    if options.out is not None:
        text = json.dumps(rates, indent=1) + "\n"
        write_whole(options.out, lambda path: path.write_text(text))
    if options.figure is not None:
        sheet = cv2.cvtColor(np.vstack(bands), cv2.COLOR_RGB2BGR)
        coded = cv2.imencode(".jpg", sheet, [cv2.IMWRITE_JPEG_QUALITY, 82])[1]
        write_whole(options.figure, lambda path: path.write_bytes(coded.tobytes()))


if __name__ == "__main__":
    main(tyro.cli(VariationOptions, description=__doc__))
