"""Some turns of a life as a film: what the robot sees, the same from outside, and what moves its gaze.

A copy of the life is filmed; the life itself goes on as without a film.
"""

import pickle
from pathlib import Path
from types import TracebackType
from typing import Self

import cv2
import numpy as np

from jointattn_mj.development.behaviour import BEHAVIOURS, SHORT, BehaviourLog
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import FACE, OBJECT, meanings
from jointattn_mj.development.rendered.observer import ObservedRun
from jointattn_mj.development.rendered.run import RenderedRun
from jointattn_mj.development.table.world import CAREGIVER
from jointattn_mj.scene.camera import FOCAL_PX
from jointattn_mj.scene.looker import Pose
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.movement import minimum_jerk
from jointattn_mj.scene.world import World
from jointattn_mj.video.onlooker import Onlooker
from jointattn_mj.video.paint import (
    FAINT,
    GREEN,
    GREY,
    GROUND,
    PANEL,
    PERSON,
    ROBOT,
    WHITE,
    Box,
    Colour,
    brackets,
    disc,
    shade,
    write,
)
from jointattn_mj.video.reel import Reel

WIDTH, HEIGHT, RATE = 1280, 720, 30
MOVING, RESTING = 8, 7
"""Images in which bodies move to where a turn puts them, and in which they stay there: half a second a turn."""
SCALE = 2
EYE = Box(16, 88, SCALE * IMAGE_WIDTH, SCALE * IMAGE_HEIGHT)
OUTSIDE = Box(672, 88, 592, 340)
_DRIVERS = Box(672, 440, 592, 268)
_STRIP = Box(16, 580, 640, 128)
_SHOWN = 16
"""Turns in the strip."""
INKS: tuple[Colour, ...] = (
    (236, 112, 99),
    (93, 173, 226),
    (88, 214, 141),
    (245, 176, 65),
    (187, 143, 206),
    (118, 215, 196),
)
"""Of modules, in the order in which they were made."""
BEHAVIOUR_INKS: tuple[Colour, ...] = (
    (236, 112, 99), (240, 178, 122), (230, 110, 170), (93, 173, 226), (140, 148, 158), (169, 204, 227),
)  # fmt: skip


class RunFilm:
    """``with RunFilm(path) as film: film.scene(run, "before", n_steps=12)``."""

    def __init__(self, path: Path):
        self._reel = Reel(path, HEIGHT, WIDTH, RATE)

    def __enter__(self) -> Self:
        """Start ffmpeg.

        Raises:
            VideoError: There is no ffmpeg program, or it does not start.
        """
        self._reel.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the file; an error that is already under way comes first."""
        self._reel.__exit__(kind, error, traceback)

    def scene(self, run: RenderedRun, title: str, n_steps: int = 12) -> None:
        """Film the next ``n_steps`` turns of a copy of ``run``, as far as it can still live.

        Raises:
            GLError: No image can be rendered here.
            VideoError: ffmpeg has given up.
        """
        copy: RenderedRun = pickle.loads(pickle.dumps(run))
        world = copy.stage.world
        onlooker = Onlooker(world, OUTSIDE.width, OUTSIDE.height)
        try:
            for _ in range(min(n_steps, copy.n_steps - copy.steps_done)):
                driver = int(copy.agent.state.driver[0]) if copy.steps_done else -1
                before = world.pose()
                copy.advance(1)
                looks_at = copy.stage.table.state[CAREGIVER]
                canvas = still(copy, title, f"turn {copy.steps_done:,}", driver, looks_at)
                for pose in _way(before, world.pose()):
                    world.stand(pose)
                    self._reel.add(with_views(canvas, world, onlooker, copy.config.senses.centre_radius_deg))
        finally:
            onlooker.close()
            world.close()


def _way(before: Pose, after: Pose) -> list[Pose]:
    """From one pose to the next, and a rest there; objects and hand are put at once."""
    moving = [after._replace(qpos=before.qpos + p * (after.qpos - before.qpos)) for p in minimum_jerk(MOVING)]
    return moving + [after] * RESTING


def with_views(still: np.ndarray, world: World, onlooker: Onlooker, radius_deg: float) -> np.ndarray:
    """``still`` with both views as things stand now; what is within ``radius_deg`` of the centre is gazed at."""
    canvas = still.copy()
    eye = EYE.of(canvas)
    size = (EYE.width, EYE.height)
    eye[:] = cv2.resize(world.image(), size, interpolation=cv2.INTER_CUBIC)
    radius = SCALE * np.radians(radius_deg) * FOCAL_PX
    disc(eye, np.array(size) / 2, radius, ROBOT, 1)
    OUTSIDE.of(canvas)[:] = onlooker.render()
    if onlooker.together:
        write(canvas, OUTSIDE.x + OUTSIDE.width - 12, OUTSIDE.y + 8, "joint attention", GREEN, 16, True, align="right")
        brackets(eye, np.array(size) / 2, 2.2 * radius, GREEN, 3)
    return canvas


def still(run: ObservedRun, title: str, when: str, driver: int, looks_at: int) -> np.ndarray:
    """All that does not move while bodies do; ``looks_at``: where she looks, in truth."""
    canvas = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
    write(canvas, 16, 12, title, WHITE, 22, True)
    write(canvas, WIDTH - 16, 16, when, WHITE, 18, align="right")
    write(canvas, EYE.x, 58, "What the robot sees", WHITE, 16, True)
    write(canvas, EYE.x + EYE.width, 60, _sensed(run), ROBOT, 14, True, align="right")
    write(canvas, OUTSIDE.x, 58, "From outside", WHITE, 16, True)
    where = "at the robot" if looks_at == run.spots else f"at place {looks_at + 1}"
    write(canvas, OUTSIDE.x + OUTSIDE.width, 60, f"she looks {where} (truth)", PERSON, 14, align="right")
    _draw_drivers(canvas, run, driver)
    _draw_strip(canvas, run)
    return canvas


def _sensed(run: ObservedRun) -> str:
    """What the robot takes the middle of the image for, and for people what it mostly means."""
    face, known = run.agent.variables.sensors[0], run.named_variables().sensors[0]
    value, there = (int(run.log(name, run.steps_done - 1)[0]) for name in (FACE, OBJECT))
    if value < len(face.values) - 1:
        return f"{face.values[value]} (mostly: looks {known.values[value]})"
    return "an object" if there else "nothing"


def _draw_drivers(canvas: np.ndarray, run: DevelopmentRun, driver: int) -> None:
    """The modules that there are, and which of them has just moved the gaze."""
    area = _DRIVERS.of(canvas)
    area[:] = PANEL
    write(area, 14, 10, "What moves its gaze", WHITE, 16, True)
    made = [one for one in run.found if one.module is not None]
    known = meanings(run.named_variables(), run.agent.modules)
    rows = [("born with: at random", GREY, driver >= len(made))]
    for number, (one, meaning) in enumerate(zip(made, known, strict=True)):
        rows.append((f"{number + 1}  {meaning.label}", INKS[number % len(INKS)], driver == number))
        write(area, area.shape[1] - 14, 68 + 28 * number, f"turn {one.step:,}", GREY, 14, align="right")
    for row, (words, ink, active) in enumerate(rows[:8]):
        y = 40 + 28 * row
        if active:
            shade(area[y - 3 : y + 23], ink, 0.35)
            disc(area, np.array([20.0, y + 10.0]), 6, ink)
        write(area, 36, y, words if len(words) < 56 else words[:53] + "...", WHITE if active else ink, 15, active)


def _draw_strip(canvas: np.ndarray, run: DevelopmentRun) -> None:
    """What the robot did in its last turns, by the names of Fig. 5.5."""
    area = _STRIP.of(canvas)
    area[:] = PANEL
    write(area, 14, 8, "What it did, turn by turn", WHITE, 14, True)
    done = BehaviourLog(run)[-_SHOWN:]
    for location, kind in enumerate(done):
        x = 14 + 38 * location
        area[32:62, x : x + 34] = BEHAVIOUR_INKS[kind]
        write(area, x + 17, 38, SHORT[kind], GROUND, 13, True, align="centre")
    for number, words in enumerate(BEHAVIOURS):
        x, y = 14 + 312 * (number % 2), 68 + 19 * (number // 2)
        end = write(area, x, y, SHORT[number], BEHAVIOUR_INKS[number], 13, True)
        write(area, end + 8, y, words, GREY if number in done else FAINT, 13)
