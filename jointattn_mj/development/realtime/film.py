"""A film of some seconds of a real-time run, in real time."""

import pickle

from jointattn_mj.development.realtime.run import FRAMES_PER_MINUTE, RealtimeRun
from jointattn_mj.development.rendered.film import OUTSIDE, RATE, Film, sensed, still, with_views
from jointattn_mj.video.onlooker import Onlooker

EVERY = 2
"""Frames of the run from one image of the film to the next; each image is shown so often, which gives 15 a second."""


class RealtimeFilm(Film):
    """``with RealtimeFilm(path) as film: film.scene(run, "before", seconds=10)``."""

    def scene(self, run: RealtimeRun, title: str, seconds: float = 10.0) -> None:
        """Film the next seconds of a copy of ``run``.

        Args:
            run: The run, which stays as it is.
            title: Words at the top.
            seconds: Simulated time.

        Raises:
            GLError: No image can be rendered here.
            VideoError: ffmpeg has given up.
        """
        copy: RealtimeRun = pickle.loads(pickle.dumps(run))
        onlooker = Onlooker(copy.world, OUTSIDE.width, OUTSIDE.height)
        first, radius = copy.frame, copy.config.senses.centre_radius_deg

        def shoot() -> None:
            if (copy.frame - first) % EVERY == 0 and copy.frame - first <= seconds * RATE:
                minute, second = divmod(copy.frame * 60 / FRAMES_PER_MINUTE, 60)
                when = f"minute {minute:.0f}:{second:04.1f}, step {copy.steps_done:,}"
                driver = int(copy.agent.state.driver[0])
                canvas = still(copy, title, when, driver, copy.world.caregiver.looks_at)
                words = f"last step {sensed(copy)}" if copy.steps_done else ""
                image = with_views(canvas, copy.world, onlooker, radius, words)
                for _ in range(EVERY):
                    self._reel.add(image)

        copy.on_frame = shoot
        try:
            while copy.frame - first < seconds * RATE and copy.steps_done < copy.n_steps:
                copy.advance(1)
        finally:
            onlooker.close()
            copy.close()
