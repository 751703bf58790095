"""The session's video as a file.

``composer`` makes the images and ``reel`` sends them to ffmpeg. A film changes nothing in the session.
"""

from pathlib import Path
from types import TracebackType

from jointattn_mj.gaze_following.film.composer import HEIGHT, WIDTH, Composer
from jointattn_mj.gaze_following.session import SessionRun
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.video.reel import Reel


class Film:
    """Writes a video of a session: ``with Film(path, session) as film: session.step(film)``."""

    def __init__(self, path: Path, session: SessionRun, every: int = 1):
        """Prepare a film.

        Args:
            path: The mp4.
            session: The session.
            every: Draw one frame in N; the video runs in real time all the same.
        """
        self._every = every
        self._composer = Composer(session)
        self._reel = Reel(path, HEIGHT, WIDTH, 1 / (FRAME_S * every), quick=True)

    def __enter__(self) -> "Film":
        """Start ffmpeg.

        Raises:
            VideoError: There is no ffmpeg program, or it does not start.
        """
        self._reel.__enter__()
        return self

    def __call__(self, session: SessionRun) -> None:
        """Draw and write this frame of the session.

        Raises:
            VideoError: ffmpeg has given up.
            GLError: No image can be rendered here.
        """
        if session.frame % self._every == 0:
            self._reel.add(self._composer.compose(session))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file and free what images needed; an error that is already under way comes first."""
        self._composer.close()
        self._reel.__exit__(kind, error, traceback)
