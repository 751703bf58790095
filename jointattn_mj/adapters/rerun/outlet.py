"""The file of a log, behind a pipe: Rerun's own writer hangs or crashes when a disk is full."""

import os
import threading
from io import FileIO
from pathlib import Path


class Outlet:
    """Takes what Rerun writes to ``name`` and puts it into a file, until the disk is full; the rest is dropped.

    Attributes:
        name: Path for Rerun to open, once; call ``opened`` afterwards.
        error: Why the file could not be written any more; None while it can.
    """

    def __init__(self, path: Path):
        """Create the file.

        Raises:
            OSError: It exists already, or cannot be created.
        """
        self.error: str | None = None
        self._file = FileIO(path, "xb")
        self._end, self._beginning = os.pipe()
        self.name = f"/dev/fd/{self._beginning}"
        self._thread = threading.Thread(target=self._copy, daemon=True)
        self._thread.start()

    def opened(self) -> None:
        """Say that Rerun has opened ``name``, or never will: the pipe then ends when Rerun closes it."""
        os.close(self._beginning)

    def close(self) -> None:
        """Wait until all is in the file, after Rerun has closed ``name``."""
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
