"""What a viewing of a video keeps in its folder while it goes on: rows, parts of the overlay, checkpoints of all."""

import time
from pathlib import Path
from typing import Any, NamedTuple

from jointattn_mj.errors import CheckpointError
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.log import PerceptLog
from jointattn_mj.footage.looks.log import LooksLog
from jointattn_mj.footage.overlay import HEIGHT, WIDTH, FootageOverlay
from jointattn_mj.footage.people_log import PeopleLog
from jointattn_mj.footage.reader import RATE, Still
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.io import checkpoint
from jointattn_mj.io.rows import RowStore, log_folder
from jointattn_mj.video.parted import PartedReel

CHECKPOINT = "checkpoint.bin"


class ViewingCheckpoint(NamedTuple):
    """What a checkpoint holds of a viewing."""

    wall_s: float
    finished: bool
    state: dict[str, Any]
    """Of the viewing, and of the options that decide what is kept."""
    percepts: RowStore
    faces: RowStore
    looks: RowStore

    @classmethod
    def load(cls, out: Path, config: PerceiveConfig) -> "ViewingCheckpoint":
        """Read that of a folder.

        Raises:
            CheckpointError: There is none that fits.
        """
        kinds = (float, bool, dict, RowStore, RowStore, RowStore)
        return cls(*checkpoint.load(out / CHECKPOINT, config, kind=kinds))


class ViewingRecords:
    """The records of one viewing so far: ``with records: records.add(still, mapped)``.

    Attributes:
        percepts: A row a frame.
        faces: A row a face.
        looks: What looks are coded from.
    """

    def __init__(self, viewing: Viewing, options: PerceiveOptions, kept: ViewingCheckpoint | None = None):
        """Begin empty, or go on from a checkpoint, which the viewing takes over as well.

        Args:
            viewing: What is kept; it has been prepared, or is restored here.
            options: Say what is kept, and where.
            kept: The checkpoint, if there is one.

        Raises:
            CheckpointError: The checkpoint is of another video or of other options, or the log lacks rows of it.
            OutputError: The folder cannot be written.
        """
        self._viewing, self._options = viewing, options
        self._began_s = time.perf_counter() - (0.0 if kept is None else kept.wall_s)
        self._every = options.overlay_every if options.overlay else None
        if kept is not None:
            viewing.restore(kept.state)
            self._check_options(kept.state)
        out, names, pattern_size = options.out, viewing.names, viewing.watcher.perceiver.pattern_size
        self.percepts = PerceptLog(out, names, kept and kept.percepts)
        self.faces = PeopleLog(out, kept and kept.faces)
        self.looks = LooksLog(out, names, pattern_size, kept and kept.looks)
        self._film = PartedReel(log_folder(out), HEIGHT, WIDTH, RATE / (self._every or 1), viewing.frames)
        self._drawing = FootageOverlay(names, viewing.rgb, viewing.config.attention, options.blur_faces)

    def _check_options(self, state: dict[str, Any]) -> None:
        begun = f"the viewing in {self._options.out} was begun with"
        if state["blur_faces"] != self._options.blur_faces:
            raise CheckpointError(f"{begun} `blur_faces={state['blur_faces']}`; resume with that")
        every = state["overlay_every"]
        if every != self._every:
            raise CheckpointError(
                f"{begun} {f'`overlay_every={every}`' if every else '`overlay=False`'}; resume with that"
            )

    @property
    def wall_seconds(self) -> float:
        """For how long the video was watched so far, by all processes."""
        return time.perf_counter() - self._began_s

    def add(self, still: Still, mapped: FrameMap) -> None:
        """Keep the frame that was viewed last.

        Args:
            still: The frame.
            mapped: From pixels of the video to those of the robot's image.

        Raises:
            OutputError: The log cannot be written.
            VideoError: The overlay cannot be written.
        """
        viewing, frame = self._viewing, self._viewing.frames - 1
        self.percepts.add(viewing.watcher, still.number, still.fresh)
        if still.fresh:
            self.faces.add(viewing.visible_faces, viewing.chosen, frame, still.number)
        if viewing.config.looks and frame % viewing.config.coding.every == 0:
            self.looks.add(viewing)
        if self._every is not None and frame % self._every == 0:
            self._film.add(self._drawing.compose(still.image, mapped, viewing, self.percepts), frame)

    def save_checkpoint(self, finished: bool = False) -> None:
        """Finish a part of the overlay, and keep all that is needed to go on; ``finished``: there are all results.

        Raises:
            OutputError: The file cannot be written.
            VideoError: The overlay cannot be written.
        """
        self._film.cut()
        viewing = self._viewing
        state = {**viewing.state(), "overlay_every": self._every, "blur_faces": self._options.blur_faces}
        rows = self.percepts.rows, self.faces.rows, self.looks.rows
        kept = ViewingCheckpoint(self.wall_seconds, finished, state, *rows)
        checkpoint.save(self._options.out / CHECKPOINT, tuple(kept), viewing.config)

    def write(self) -> None:
        """Write ``percepts.parquet``, ``people.parquet`` and ``overlay.mp4`` as far as the video was watched.

        Raises:
            OutputError: A file cannot be written.
            VideoError: The overlay cannot be put together.
        """
        out, people, start_s = self._options.out, self._viewing.people, self._viewing.footage.start_s
        self.percepts.write(out / "percepts.parquet", start_s)
        if people is not None:
            self.faces.write(out / "people.parquet", start_s, people.owner)
        if self._every is not None:
            self._film.join(out / "overlay.mp4")

    def __enter__(self) -> "ViewingRecords":
        return self

    def __exit__(self, *raised: Any) -> None:
        self._film.__exit__(*raised)
