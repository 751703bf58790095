"""The file of a log, behind a pipe: Rerun's own writer hangs or dies where a disk is full."""

import os
import threading
from io import FileIO
from pathlib import Path


class Outlet:
    """Takes what Rerun writes to ``name`` and puts it into a file, until the disk is full; the rest is dropped.

    Attributes:
        name: Path that Rerun is to open, once; ``opened`` has to be told of it.
        error: Why the file could not be written any more, or None.
    """

    def __init__(self, path: Path):
        """Make the file.

        Raises:
            OSError: It is there already, or cannot be made.
        """
        self.error: str | None = None
        self._file = FileIO(path, "xb")
        self._end, self._beginning = os.pipe()
        self.name = f"/dev/fd/{self._beginning}"
        self._thread = threading.Thread(target=self._copy, daemon=True)
        self._thread.start()

    def opened(self) -> None:
        """Rerun has opened ``name``, or never will: the pipe ends when Rerun closes it."""
        os.close(self._beginning)

    def close(self) -> None:
        """Wait until everything is in the file; Rerun has closed ``name``."""
        self._thread.join()

    def _copy(self) -> None:
        with self._file:
            while piece := os.read(self._end, 1 << 16):
                try:
                    while self.error is None and piece:
                        piece = piece[self._file.write(piece) :]
                except OSError as error:
                    self.error = error.strerror or str(error)
        os.close(self._end)
