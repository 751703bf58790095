"""The table of all faces of a video, people.parquet: one row a face in an image."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa

from jointattn_mj.footage.people import Sighting
from jointattn_mj.footage.reader import RATE
from jointattn_mj.gaze_following.columns import described
from jointattn_mj.io.parquet import write_parts
from jointattn_mj.io.rows import RowStore, log_folder, spans

BLOCK = 60 * RATE
"""Rows of a row group of the file."""
POINTS = ("right_eye", "left_eye", "nose", "mouth_right", "mouth_left")
"""Landmarks, by the person's own sides."""
MEANINGS = {
    "time_s": "time in the video",
    "frame": "number of the frame, as in percepts.parquet",
    "image": "number of the video's image",
    "track": "number of the track: one face that is followed without a gap",
    "person": "number of the person; 0 where a face was lost before it was known whose it is",
    "sure": "whether it is known that it is this person",
    "of_interest": "whether it is the face of interest, which percepts.parquet has",
    "x_px": "left edge of the face's box, pixels of the video",
    "y_px": "its upper edge",
    "width_px": "its width",
    "height_px": "its height, from brow to chin",
    "score": "of the detector, 0..1: .8 and more for clear faces",
    **{
        f"{point}_{axis}_px": f"{point.replace('_', ' ')}, by the person's own sides"
        for point in POINTS
        for axis in "xy"
    },
    "yaw_deg": "yaw of the head against the line to the camera, positive to the right of the image",
    "yaw_error_deg": "its expected error, which two of three yaws do not exceed",
}
_WIDTH = 4 + 15 + 2
_WHOLE = {"frame": pa.int32(), "image": pa.int32(), "track": pa.int32(), "person": pa.int32()}


class PeopleLog:
    """The table of faces so far.

    Attributes:
        rows: All rows, for a checkpoint.
    """

    def __init__(self, out: Path, rows: RowStore | None = None):
        """Make an empty table, or go on with the rows of a checkpoint.

        Args:
            out: Folder of the run.
            rows: Rows of a checkpoint.

        Raises:
            OutputError: The log cannot be written.
            CheckpointError: The log lacks rows of the checkpoint.
        """
        self.rows = RowStore("people", np.float64, _WIDTH) if rows is None else rows
        self.rows.attach(log_folder(out))

    def add(self, faces: list[Sighting], chosen: Sighting | None, frame: int, image: int) -> None:
        """Add the faces of an image.

        Args:
            faces: All of them.
            chosen: The face of interest among them.
            frame: Number of the frame.
            image: Number of the video's image.

        Raises:
            OutputError: The log cannot be written.
        """
        for face in faces:
            about = (frame, image, face.track, face is chosen)
            self.rows.append(np.concatenate([about, face.face, (face.yaw_deg, face.yaw_error_deg)]))

    def write(self, path: Path, start_s: float, owner: Mapping[int, tuple[int, bool]]) -> None:
        """Write all rows as a Parquet file.

        Args:
            path: The file.
            start_s: Time of the first frame, s.
            owner: Person and whether that is sure, of each track.

        Raises:
            OutputError: It cannot be written.
        """
        write_parts(path, self._parts(start_s, owner))

    def _parts(self, start_s: float, owner: Mapping[int, tuple[int, bool]]) -> Iterator[pa.Table]:
        for first, last in spans(len(self.rows), BLOCK):
            values = self.rows.read(first, last)
            frame, image, track, chosen = values[:, :4].T
            people = [owner.get(int(number), (0, False)) for number in track]
            numbers = (
                start_s + frame / RATE, frame, image, track, np.array([person for person, _ in people]),
                np.array([sure for _, sure in people], bool), chosen.astype(bool), *values[:, 4:8].T, values[:, 18],
                *values[:, 8:18].T, *values[:, 19:].T,
            )  # fmt: skip
            columns = {name: _array(name, column) for name, column in zip(MEANINGS, numbers, strict=True)}
            yield described(pa.table(columns), MEANINGS)


def _array(name: str, values: np.ndarray) -> pa.Array:
    if name in _WHOLE:
        return pa.array(values.astype(np.int32))
    if values.dtype == bool or name == "time_s":
        return pa.array(values)
    return pa.array(values.astype(np.float32), mask=np.isnan(values))
