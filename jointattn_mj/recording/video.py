"""The session's video as a file: H.264 in a fragmented mp4 that plays even when it was cut short.

``composer`` makes the pictures; this file brings them to ffmpeg. The session is only looked at: it goes on as without
a film.
"""

import os
from contextlib import suppress
from pathlib import Path
from types import TracebackType

import imageio_ffmpeg
import mediapy

from jointattn_mj.errors import VideoError
from jointattn_mj.recording.composer import HEIGHT, WIDTH, Composer
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.session import Session

QUALITY = 26
"""x264's constant rate factor; less is better and bigger. 24 adds a sixth to the size, 28 takes a seventh off."""
INSTALL = "Install ffmpeg (`apt-get install ffmpeg`, or `pip install imageio-ffmpeg`), or run without the video."


class Film:
    """Writes a video while it is shown a session: ``with Film(path, session) as film: session.step(film)``.

    The file is a fragmented mp4: what was written of it more than a second or two ago plays, whatever becomes of the
    process.
    """

    def __init__(self, path: Path, session: Session, every: int = 1):
        """``every``: only every so manieth frame is drawn and written; the video runs at real time all the same."""
        self._every = every
        self._composer = Composer(session)
        rate = 1 / (FRAME_S * every)
        arguments = (
            f"-preset veryfast -g {max(1, round(rate))} -movflags frag_keyframe+empty_moov+default_base_moof "
            "-flush_packets 1"
        )
        self._writer = mediapy.VideoWriter(path, (HEIGHT, WIDTH), fps=rate, crf=QUALITY, ffmpeg_args=arguments)

    def __enter__(self) -> "Film":
        """Start ffmpeg.

        Raises:
            VideoError: There is no ffmpeg program, or it does not start.
        """
        find_ffmpeg()
        try:
            self._writer.__enter__()
        except (OSError, RuntimeError) as error:
            raise VideoError(f"the video cannot be written to {self._writer.path} ({error}). {INSTALL}") from error
        return self

    def __call__(self, session: Session) -> None:
        """Draw and write this frame of the session.

        Raises:
            VideoError: ffmpeg has given up.
            GLError: No picture can be rendered here.
        """
        if session.frame % self._every:
            return
        picture = self._composer.compose(session)
        try:
            self._writer.add_image(picture)
        except (OSError, RuntimeError) as error:
            raise VideoError(self._failure(error)) from error

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file and free what pictures needed; an error that is already under way comes first."""
        self._composer.close()
        try:
            self._writer.close()
        except (OSError, RuntimeError) as trouble:
            if error is None:
                raise VideoError(self._failure(trouble)) from trouble

    def _failure(self, error: Exception) -> str:
        return (
            f"ffmpeg stopped writing {self._writer.path} ({error}); is the disk full? If this ffmpeg lacks H.264, "
            f"take another one. {INSTALL}"
        )


def find_ffmpeg() -> None:
    """Let mediapy use the system's ffmpeg, or where there is none the one that comes with imageio-ffmpeg.

    Raises:
        VideoError: There is neither.
    """
    if mediapy.video_is_available():
        return
    with suppress(RuntimeError):
        mediapy.set_ffmpeg(os.fspath(imageio_ffmpeg.get_ffmpeg_exe()))
    if not mediapy.video_is_available():
        raise VideoError(f"a video needs the program ffmpeg, and none was found. {INSTALL}")
