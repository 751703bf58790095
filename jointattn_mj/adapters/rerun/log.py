"""Writes a session to a log while it runs, without changing it."""

from pathlib import Path
from types import TracebackType

import rerun as rr

from jointattn_mj.adapters.rerun.curves import AgentCurves
from jointattn_mj.adapters.rerun.entities import IMAGE
from jointattn_mj.adapters.rerun.images import Images
from jointattn_mj.adapters.rerun.layout import layout
from jointattn_mj.adapters.rerun.outlet import Outlet
from jointattn_mj.adapters.rerun.percepts import Percepts
from jointattn_mj.adapters.rerun.rows import Rows
from jointattn_mj.adapters.rerun.scene import Scene
from jointattn_mj.errors import OutputError
from jointattn_mj.gaze_following.session import SessionRun
from jointattn_mj.io.checkpoint import fingerprint
from jointattn_mj.io.notices import notice
from jointattn_mj.video.paint import PERSON, Colour, ink_of


class SessionLog:
    """A log of a session: ``with SessionLog(path, session) as log: session.step(log)``.

    Where the file cannot be written any more, such as on a full disk, it says so once, and the session goes on.
    """

    def __init__(self, path: Path, session: SessionRun):
        """Prepare a log.

        Args:
            path: File to write.
            session: The session. Logs of the parts of a resumed one have the same id: opened together, they are one.
        """
        self._path, self._session = path, session
        self._log = rr.RecordingStream("jointattn session", recording_id=fingerprint(session.config))
        self._rows = Rows(self._log)
        self._open = False

    def __enter__(self) -> "SessionLog":
        """Open the file, and write what stays the same.

        Raises:
            OutputError: The file cannot be made, or is there already.
            VideoError: ffmpeg does not start.
        """
        try:
            self._outlet = Outlet(self._path)
            try:
                self._log.save(self._outlet.name, default_blueprint=layout())
            finally:
                self._outlet.opened()
        except (OSError, RuntimeError) as error:
            trouble = getattr(error, "strerror", None) or error
            raise OutputError(f"cannot write {self._path}: {trouble}; choose another file") from error
        self._open = True
        session = self._session
        inks: list[Colour] = [*(ink_of(item.rgb) for item in session.config.world.scene.objects), PERSON]
        self._parts = (
            Scene(self._rows, session.world),
            Percepts(self._rows, session.names, inks),
            AgentCurves(self._rows, session, inks),
        )
        self._images = Images(self._log, IMAGE)
        return self

    def __call__(self, session: SessionRun) -> None:
        """Log this frame of the session.

        Raises:
            VideoError: ffmpeg has given up.
            GLError: No image can be rendered here.
        """
        if self._outlet.error is not None:
            self._end()
        if not self._open:
            return
        self._rows.go_to(session.frame)
        self._images.add(session.frame, session.world.image())
        for part in self._parts:
            part.write(session)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file; an error that is already under way comes first."""
        try:
            self._images.finish()
            self._rows.flush()
        except Exception:
            if error is None:
                raise
        finally:
            self._end()

    def _end(self) -> None:
        """Finish the file, and say so where it could not be written."""
        if not self._open:
            return
        self._open = False
        self._log.flush()
        self._log.disconnect()
        self._outlet.close()
        if self._outlet.error is not None:
            notice(f"cannot write {self._path}: {self._outlet.error}; the session goes on without it")
