"""Some seconds of a life in real time as a film, as fast as they were lived."""

import pickle

from jointattn_mj.development.realtime.run import FRAMES_PER_MINUTE, RealtimeLife
from jointattn_mj.development.rendered.film import OUTSIDE, RATE, LifeFilm, still, with_views
from jointattn_mj.video.onlooker import Onlooker

EVERY = 2
"""Frames of a life from one picture of its film to the next, each of which is shown twice: fifteen a second."""


class RealtimeFilm(LifeFilm):
    """``with RealtimeFilm(path) as film: film.watch(life, "before", seconds=10)``."""

    def watch(self, life: RealtimeLife, title: str, seconds: float = 10.0) -> None:
        """Film the next ``seconds`` of a copy of ``life``.

        Raises:
            GLError: No picture can be rendered here.
            VideoError: ffmpeg has given up.
        """
        copy: RealtimeLife = pickle.loads(pickle.dumps(life))
        onlooker = Onlooker(copy.world, OUTSIDE.width, OUTSIDE.height)
        first, radius = copy.frame, copy.config.senses.centre_radius_deg

        def shoot() -> None:
            if (copy.frame - first) % EVERY == 0 and copy.frame - first <= seconds * RATE:
                minute, second = divmod(copy.frame * 60 / FRAMES_PER_MINUTE, 60)
                when = f"minute {minute:.0f}:{second:04.1f}, step {copy.lived:,}"
                driver = int(copy.mind.mind.driver[0])
                canvas = still(copy, title, when, driver, copy.world.caregiver.looks_at)
                picture = with_views(canvas, copy.world, onlooker, radius)
                for _ in range(EVERY):
                    self._reel.add(picture)

        copy.on_frame = shoot
        try:
            while copy.frame - first < seconds * RATE and copy.lived < copy.turns:
                copy.live(1)
        finally:
            onlooker.close()
            copy.close()
