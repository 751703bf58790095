"""Some seconds of a real-time run as a film, at their own pace."""

import pickle

from jointattn_mj.development.realtime.run import FRAMES_PER_MINUTE, RealtimeRun
from jointattn_mj.development.rendered.film import OUTSIDE, RATE, RunFilm, still, with_views
from jointattn_mj.video.onlooker import Onlooker, sights

EVERY = 2
"""Frames of a run from one image of its film to the next; each image is shown twice, fifteen a second."""


class RealtimeFilm(RunFilm):
    """``with RealtimeFilm(path) as film: film.watch(run, "before", seconds=10)``."""

    def watch(self, run: RealtimeRun, title: str, seconds: float = 10.0) -> None:
        """Film the next seconds of a copy of ``run``.

        Args:
            run: The run, at any step.
            title: Says what the scene is.
            seconds: Simulated seconds that are filmed.

        Raises:
            GLError: No image can be rendered here.
            VideoError: ffmpeg has given up.
        """
        copy: RealtimeRun = pickle.loads(pickle.dumps(run))
        onlooker = Onlooker(copy.world, OUTSIDE.width, OUTSIDE.height)
        first, radius = copy.frame, copy.config.senses.centre_radius_px

        def shoot() -> None:
            if (copy.frame - first) % EVERY == 0 and copy.frame - first <= seconds * RATE:
                minute, second = divmod(copy.frame * 60 / FRAMES_PER_MINUTE, 60)
                when = f"minute {minute:.0f}:{second:04.1f}, step {copy.steps_done:,}"
                driver = int(copy.agent.state.driver[0])
                canvas = still(copy, title, when, driver, copy.world.caregiver.looks_at)
                image = with_views(canvas, copy.world, onlooker, radius, _at_centre(copy))
                for _ in range(EVERY):
                    self._reel.add(image)

        copy.on_frame = shoot
        try:
            while copy.frame - first < seconds * RATE and copy.steps_done < copy.n_steps:
                copy.advance(1)
        finally:
            onlooker.close()
            copy.close()


def _at_centre(run: RealtimeRun) -> str:
    """What is at the centre of view now; what the robot takes it for is known when the fixation ends."""
    if run.world.head_moves():
        return "turns its head"
    hit = sights(run.world)[0].hit
    return "nothing" if hit is None else "a face" if hit == len(run.world.caregiver.objects) else "an object"
