"""``python -m experiments.cross_situational.film``: two robots after 26 minutes of learning, side by side."""

from functools import partial
from pathlib import Path

import numpy as np
import tyro

from jointattn_mj.gaze_following.film.composer import recent, verdict_in_words
from jointattn_mj.gaze_following.film.overlay import RobotsView
from jointattn_mj.gaze_following.presets import PRESETS
from jointattn_mj.gaze_following.session import FRAMES_PER_SECOND, SessionConfig, SessionRun
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.model import assets_folder
from jointattn_mj.video.paint import GREEN, GREY, GROUND, PERSON, RED, WHITE, Box, ink_of, write
from jointattn_mj.video.reel import Reel

from .sweep import FILM

WIDTH, HEIGHT, COLUMN = 1280, 640, 640
VIEW_Y = 84
EVERY = 2
"""Frames of a session in one frame of the film."""
ROBOTS = {
    "The dissertation's rule": ("thesis", "robin.npz"),
    "What is contingent": ("cross_situational", "robin_cross_situational.npz"),
}
"""Preset and trained weights (``make trained``) by title."""


class Side:
    """One robot's half of the film."""

    def __init__(self, title: str, x: int, seed: int, seconds: float):
        """Begin its session.

        Args:
            title: Key of ``ROBOTS``.
            x: Left edge of the half, pixels.
            seed: Of the session.
            seconds: Its length.
        """
        preset, weights = ROBOTS[title]
        start = assets_folder() / "trained" / weights
        config = SessionConfig(minutes=seconds / 60, seed=seed, start_from=start, robot=PRESETS[preset])
        self.title, self.x, self.session = title, x, SessionRun(config)
        inks = [*(ink_of(item.rgb) for item in config.world.scene.objects), PERSON]
        self._view = RobotsView(self.session.names, inks, Box(x, VIEW_Y, COLUMN, 480))
        self.session.begin()

    def draw(self, canvas: np.ndarray, session: SessionRun) -> None:
        """Draw on ``canvas`` the robot's view, its last verdict and how often it was right, in this frame."""
        foot = VIEW_Y + 492
        self._view.draw(canvas, session)
        write(canvas, self.x + 16, 46, self.title, WHITE, 24, True)
        done = [row.success for row in session.shifts if row.face_to_object]
        right = self.x + COLUMN - 16
        write(canvas, right, foot, f"right: {sum(map(bool, done))} of {len(done)}", WHITE, 22, True, align="right")
        row = recent(session)
        if row is not None:
            write(canvas, self.x + 16, foot, verdict_in_words(row), GREEN if row.success else RED, 19)


def film(path: Path = FILM, seed: int = 1, seconds: float = 40.0) -> None:
    """Run both robots and film them.

    Args:
        path: Of the film.
        seed: Of both sessions, so that the caregiver does the same in both.
        seconds: Length.
    """
    sides = [Side(title, number * COLUMN, seed, seconds) for number, title in enumerate(ROBOTS)]
    canvas = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    with Reel(path, HEIGHT, WIDTH, FRAMES_PER_SECOND / EVERY) as reel:
        for frame in range(round(seconds * FRAMES_PER_SECOND)):
            shown = frame % EVERY == 0
            canvas[:] = GROUND
            write(canvas, 16, 8, "After 26 minutes: two robots, one caregiver who does the same for both", GREY, 21)
            write(canvas, WIDTH - 16, 8, f"{frame * FRAME_S:.0f} s", GREY, 21, align="right")
            for side in sides:
                side.session.step(partial(side.draw, canvas) if shown else None)
            if shown:
                reel.add(canvas)
    for side in sides:
        side.session.close()


if __name__ == "__main__":
    tyro.cli(film)
