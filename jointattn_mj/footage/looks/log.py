"""What is kept of a video to code where a person looks: face pattern and locations, look by look."""

from pathlib import Path

import numpy as np

from jointattn_mj.footage.frame_map import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.footage.looks.coding import PARTNER, ObservedLooks
from jointattn_mj.footage.looks.config import LooksConfig
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.io.rows import RowStore, log_folder, spans
from jointattn_mj.perception.som import SOM

BLOCK = 1000
"""Rows that are read at a time."""
_HEAD = 6
"""Numbers before the locations: frame, height of the face's square, whether the face is seen, yaw, and the location
of the largest other face."""
PARTNER_LOOKS = 5
"""Looks in which another face must be seen to be a candidate."""


class LooksLog:
    """Looks so far; memory holds some of them, a file in the run's folder all.

    Attributes:
        rows: All rows, for a checkpoint.
    """

    def __init__(self, out: Path, names: tuple[str, ...], pattern_size: int, rows: RowStore | None = None):
        """Make an empty log, or go on with the rows of a checkpoint.

        Args:
            out: Folder of the run.
            names: Of the objects and, last, the face.
            pattern_size: Numbers in a face pattern.
            rows: Rows of a checkpoint.

        Raises:
            OutputError: The log cannot be written.
            CheckpointError: The log lacks rows of the checkpoint.
        """
        self.names = names
        width = _HEAD + 2 * len(names) + pattern_size
        self.rows = RowStore("looks", np.float32, width) if rows is None else rows
        self.rows.attach(log_folder(out))

    def add(self, viewing: Viewing) -> None:
        """Add the frame that was viewed last.

        Raises:
            OutputError: The log cannot be written.
        """
        perceiver, percept = viewing.watcher.perceiver, viewing.watcher.percept
        if percept is None:
            raise ValueError("the viewing has perceived no frame yet")
        height_px, pattern = 0, np.zeros(perceiver.pattern_size)
        if percept.visible[-1]:
            inside = perceiver.fix._replace(x=IMAGE_WIDTH / 2, y=IMAGE_HEIGHT / 2)  # where no border cuts the square
            _, top, _, bottom = perceiver.faces.box(inside, (IMAGE_HEIGHT, IMAGE_WIDTH))
            height_px, pattern = bottom - top, perceiver.face_pattern()
        px = np.where(percept.visible[:, None], percept.px, np.nan)
        chosen, others = viewing.chosen, [face for face in viewing.visible_faces if face is not viewing.chosen]
        yaw_deg = np.nan if chosen is None else chosen.yaw_deg
        partner = np.full(2, np.nan)
        if chosen is not None and others and viewing.mapped is not None:
            partner = viewing.mapped.to_image(others[0].centre - 0.5)
        head = (viewing.frames - 1, height_px, percept.visible[-1], yaw_deg, *partner)
        self.rows.append(np.concatenate([head, px.ravel(), np.ravel(pattern)]))

    def frames(self) -> np.ndarray:
        """Numbers of the frames (n,) of the looks."""
        return self.rows.column(0).astype(int)

    def looks(self, som: SOM | None, cuts: np.ndarray, config: LooksConfig) -> ObservedLooks:
        """All looks, with faces as activations of a map.

        Args:
            som: The map; None where no face was seen.
            cuts: Frames (m,) that follow upon a cut.
            config: ``every``, ``softness`` and ``partner``.
        """
        count, k = len(self.rows), len(self.names)
        units = 1 if som is None else len(som.weights)
        faces, px = np.zeros((count, units), np.float32), np.full((count, k, 2), np.nan)
        heights, yaw_deg, other = np.zeros(count), np.full(count, np.nan), np.full((count, 2), np.nan)
        for first, last in spans(count, BLOCK):
            rows = self.rows.read(first, last)
            px[first:last] = rows[:, _HEAD : _HEAD + 2 * k].reshape(-1, k, 2)
            heights[first:last], yaw_deg[first:last], other[first:last] = rows[:, 1], rows[:, 3], rows[:, 4:_HEAD]
            if som is not None:
                for i in np.flatnonzero(rows[:, 2]):
                    faces[first + i] = som.activations(rows[i, _HEAD + 2 * k :], config.softness)
        visible = np.isfinite(px[:, -1]).all(-1)
        height = float(np.median(heights[visible])) if visible.any() else 1.0
        frames = self.frames()
        cut = np.zeros(count, bool)
        after = np.searchsorted(frames, cuts)
        cut[after[after < count]] = True
        names, candidates = self.names[:-1], px[:, :-1]
        if config.partner and np.isfinite(other[:, 0]).sum() >= PARTNER_LOOKS:
            names, candidates = (*names, PARTNER), np.concatenate([candidates, other[:, None]], axis=1)
        return ObservedLooks(names, faces, px[:, -1], candidates, yaw_deg, cut, height, config.every / RATE)
