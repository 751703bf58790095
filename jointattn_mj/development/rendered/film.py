"""A film of some steps of a run: the robot's image, the scene from outside, and which module moves the gaze.

A copy of the run is filmed; the run itself goes on as without a film.
"""

import pickle
from collections.abc import Callable
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
from jointattn_mj.scene.looker import TurnWorld
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
"""Images of a step in which bodies move, and in which they rest: half a second a step."""
SCALE = 2
EYE = Box(16, 88, SCALE * IMAGE_WIDTH, SCALE * IMAGE_HEIGHT)
OUTSIDE = Box(672, 88, 592, 340)
_DRIVERS = Box(672, 440, 592, 268)
_STRIP = Box(16, 580, 640, 128)
_SHOWN = 16
"""Steps in the strip."""
INKS: tuple[Colour, ...] = (
    (236, 112, 99),
    (93, 173, 226),
    (88, 214, 141),
    (245, 176, 65),
    (187, 143, 206),
    (118, 215, 196),
)
"""Colours of modules, in the order in which they were made."""
BEHAVIOUR_INKS: tuple[Colour, ...] = (
    (236, 112, 99), (240, 178, 122), (230, 110, 170), (93, 173, 226), (140, 148, 158), (169, 204, 227),
)  # fmt: skip


class Film:
    """A video file, and the steps of a run in it; ``with RunFilm(path) as film: film.scene(run, "before")``."""

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

    def _shoot(
        self, world: TurnWorld, n_steps: int, radius_deg: float, advance: Callable[[], tuple[np.ndarray, str]]
    ) -> None:
        """Film some steps: bodies move to where each step puts them, and rest there.

        Args:
            world: The bodies.
            n_steps: How many steps.
            radius_deg: What is so near to the centre of view is gazed at.
            advance: Does a step; returns the canvas without both views, and what the robot senses then.
        """
        onlooker = Onlooker(world, OUTSIDE.width, OUTSIDE.height)
        try:
            for _ in range(n_steps):
                before = world.pose()
                canvas, sensed = advance()
                after = world.pose()
                for share in minimum_jerk(MOVING):
                    world.stand(after._replace(qpos=before.qpos + share * (after.qpos - before.qpos)))
                    self._reel.add(with_views(canvas, world, onlooker, radius_deg, ""))
                world.stand(after)
                for _ in range(RESTING):
                    self._reel.add(with_views(canvas, world, onlooker, radius_deg, sensed))
        finally:
            onlooker.close()
            world.close()


class RunFilm(Film):
    """A film of a run at the rendered table."""

    def scene(self, run: RenderedRun, title: str, n_steps: int = 12) -> None:
        """Film the next steps of a copy of ``run``.

        Args:
            run: The run, which stays as it is.
            title: Words at the top.
            n_steps: How many steps; fewer if the run ends before.

        Raises:
            GLError: No image can be rendered here.
            VideoError: ffmpeg has given up.
        """
        copy: RenderedRun = pickle.loads(pickle.dumps(run))

        def advance() -> tuple[np.ndarray, str]:
            driver = int(copy.agent.state.driver[0]) if copy.steps_done else -1
            copy.advance(1)
            looks_at = int(copy.stage.table.state[CAREGIVER])
            return still(copy, title, f"step {copy.steps_done:,}", driver, looks_at), sensed(copy)

        radius = copy.config.senses.centre_radius_deg
        self._shoot(copy.stage.world, min(n_steps, copy.n_steps - copy.steps_done), radius, advance)


def with_views(canvas: np.ndarray, world: World, onlooker: Onlooker, radius_deg: float, sensed: str) -> np.ndarray:
    """The canvas with both views as bodies stand now.

    Args:
        canvas: (h, w, 3) all that does not move; not changed.
        world: The bodies.
        onlooker: Camera outside.
        radius_deg: What is so near to the centre of view is gazed at.
        sensed: What the robot senses, in words.
    """
    canvas = canvas.copy()
    eye = EYE.of(canvas)
    size = (EYE.width, EYE.height)
    eye[:] = cv2.resize(world.image(), size, interpolation=cv2.INTER_CUBIC)
    radius = SCALE * np.radians(radius_deg) * FOCAL_PX
    disc(eye, np.array(size) / 2, radius, ROBOT, 1)
    write(canvas, EYE.x + EYE.width, 60, sensed, ROBOT, 14, True, align="right")
    OUTSIDE.of(canvas)[:] = onlooker.look()
    if onlooker.together:
        write(canvas, OUTSIDE.x + 120, 58, "joint attention", GREEN, 16, True)
        brackets(eye, np.array(size) / 2, 2.2 * radius, GREEN, 3)
    return canvas


def titled(title: str, when: str, looks_at: int, spots: int) -> np.ndarray:
    """A canvas with its headings.

    Args:
        title: Words at the top left.
        when: Words at the top right.
        looks_at: Gaze target of the caregiver, in truth; ``spots`` for the robot.
        spots: Number of spots.
    """
    canvas = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
    write(canvas, 16, 12, title, WHITE, 22, True)
    write(canvas, WIDTH - 16, 16, when, WHITE, 18, align="right")
    write(canvas, EYE.x, 58, "Robot's camera", WHITE, 16, True)
    write(canvas, OUTSIDE.x, 58, "From outside", WHITE, 16, True)
    where = "the robot" if looks_at == spots else f"spot {looks_at + 1}"
    write(canvas, OUTSIDE.x + OUTSIDE.width, 60, f"caregiver looks at {where} (truth)", PERSON, 14, align="right")
    return canvas


def still(run: ObservedRun, title: str, when: str, driver: int, looks_at: int) -> np.ndarray:
    """All of an image that does not move.

    Args:
        run: The run.
        title: Words at the top left.
        when: Words at the top right.
        driver: Module that has just moved the gaze; -1 for none.
        looks_at: Gaze target of the caregiver, in truth.
    """
    canvas = titled(title, when, looks_at, run.spots)
    _draw_drivers(canvas, run, driver)
    _draw_strip(canvas, run)
    return canvas


def sensed(run: ObservedRun) -> str:
    """What the robot sensed in the last step, and for a category of faces the caregiver's usual gaze target."""
    face, known = run.agent.variables.sensors[0], run.named_variables().sensors[0]
    value, there = (int(run.log(name, run.steps_done - 1)[0]) for name in (FACE, OBJECT))
    if value < len(face.values) - 1:
        return f"sensed: {face.values[value]} (mostly looks {known.values[value]})"
    return "sensed: an object" if there else "sensed: neither face nor object"


def _draw_drivers(canvas: np.ndarray, run: DevelopmentRun, driver: int) -> None:
    """List the modules, and mark the one that has just moved the gaze."""
    area = _DRIVERS.of(canvas)
    area[:] = PANEL
    write(area, 14, 10, "What moves the robot's gaze", WHITE, 16, True)
    made = [one for one in run.found if one.module is not None]
    known = meanings(run.named_variables(), run.agent.modules)
    rows = [("initial module: at random", GREY, driver >= len(made))]
    for number, (one, meaning) in enumerate(zip(made, known, strict=True)):
        rows.append((f"{number + 1}  {meaning.label}", INKS[number % len(INKS)], driver == number))
        write(area, area.shape[1] - 14, 68 + 28 * number, f"step {one.step:,}", GREY, 14, align="right")
    for row, (words, ink, active) in enumerate(rows[:8]):
        y = 40 + 28 * row
        if active:
            shade(area[y - 3 : y + 23], ink, 0.35)
            disc(area, np.array([20.0, y + 10.0]), 6, ink)
        write(area, 36, y, words if len(words) < 66 else words[:63] + "...", WHITE if active else ink, 13, active)


def _draw_strip(canvas: np.ndarray, run: DevelopmentRun) -> None:
    """Show what the robot did in its last steps, by the names of Fig. 5.5."""
    area = _STRIP.of(canvas)
    area[:] = PANEL
    write(area, 14, 8, "What the robot did, step by step", WHITE, 14, True)
    done = BehaviourLog(run)[-_SHOWN:]
    for number, kind in enumerate(done):
        x = 14 + 38 * number
        area[32:62, x : x + 34] = BEHAVIOUR_INKS[kind]
        write(area, x + 17, 38, SHORT[kind], GROUND, 13, True, align="centre")
    for number, words in enumerate(BEHAVIOURS):
        x, y = 14 + 312 * (number % 2), 68 + 19 * (number // 2)
        end = write(area, x, y, SHORT[number], BEHAVIOUR_INKS[number], 13, True)
        write(area, end + 8, y, words, GREY if number in done else FAINT, 13)
