"""Some steps of a run as a film: what the robot sees, the same from outside, and what moves its gaze.

A copy of the run is filmed; the run itself goes on as without a film.
"""

import pickle
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

import cv2
import numpy as np

from jointattn_mj.contingency.online.reactive import CuriousModule
from jointattn_mj.development.behaviour import BEHAVIOURS, SHORT, BehaviourLog
from jointattn_mj.development.loop import DevelopmentRun
from jointattn_mj.development.meaning import FACE, OBJECT, meanings
from jointattn_mj.development.rendered.observer import ObservedRun
from jointattn_mj.development.rendered.run import RenderedRun
from jointattn_mj.development.table.world import CAREGIVER
from jointattn_mj.scene.looker import Pose, TableWorld
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.scene.movement import minimum_jerk
from jointattn_mj.scene.world import World
from jointattn_mj.video.onlooker import Onlooker
from jointattn_mj.video.paint import (
    GREEN,
    GREY,
    GROUND,
    PANEL,
    PERSON,
    ROBOT,
    SMALL,
    TEXT,
    TITLE,
    WHITE,
    Box,
    Colour,
    brackets,
    disc,
    fitting,
    shade,
    width_of,
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
_DIM: Colour = (112, 122, 136)  # of behaviours that are not in the strip
_TURNS = "turns its head"
_STILL_DEG = 1.0  # a smaller turn of the head is not mentioned


Step = Callable[[], tuple[np.ndarray, str, str]]
"""Does a step; gives what stays the same in its images, and in words what the robot sees as it moves and rests."""


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
        """Film the next steps of a copy of ``run``.

        Args:
            run: The run, at any step.
            title: Says what the scene is.
            n_steps: Steps that are filmed; fewer at the end of the run.

        Raises:
            GLError: No image can be rendered here.
            VideoError: ffmpeg has given up.
        """
        copy: RenderedRun = pickle.loads(pickle.dumps(run))

        def step() -> tuple[np.ndarray, str, str]:
            driver = int(copy.agent.state.driver[0]) if copy.steps_done else -1
            head = copy.stage.world.head_angles()
            copy.advance(1)
            turns = np.abs(copy.stage.world.head_angles() - head).max() > np.radians(_STILL_DEG)
            looks_at, sensed = copy.stage.table.state[CAREGIVER], _sensed(copy)
            canvas = still(copy, title, f"step {copy.steps_done:,}", driver, looks_at)
            return canvas, _TURNS if turns else sensed, sensed

        last = min(n_steps, copy.n_steps - copy.steps_done)
        self._film(copy.stage.world, copy.config.senses.centre_radius_px, last, step)

    def _film(self, world: TableWorld, radius_px: float, n_steps: int, step: Step) -> None:
        """Film steps and close the world.

        Args:
            world: The world in which they happen.
            radius_px: Distance from the centre of view within which a thing is gazed at, pixels of the robot's image.
            n_steps: Steps that are filmed.
            step: Does one of them, and gives what is drawn beside both views.
        """
        onlooker = Onlooker(world, OUTSIDE.width, OUTSIDE.height)
        try:
            for _ in range(n_steps):
                before = world.pose()
                canvas, moving, resting = step()
                for number, pose in enumerate(_way(before, world.pose())):
                    world.stand(pose)
                    words = moving if number < MOVING - 1 else resting
                    self._reel.add(with_views(canvas, world, onlooker, radius_px, words))
        finally:
            onlooker.close()
            world.close()


def _way(before: Pose, after: Pose) -> list[Pose]:
    """Poses from one to the next, and a rest there; objects and hand are put at once."""
    moving = [after._replace(qpos=before.qpos + p * (after.qpos - before.qpos)) for p in minimum_jerk(MOVING)]
    return moving + [after] * RESTING


def with_views(still: np.ndarray, world: World, onlooker: Onlooker, radius_px: float, sees: str) -> np.ndarray:
    """An image of the film, (720, 1280, 3) uint8.

    Args:
        still: All that stays the same during a step.
        world: The world as it is now.
        onlooker: Renders it from outside.
        radius_px: Distance from the centre of view within which a thing is gazed at, pixels of the robot's image.
        sees: What the robot sees there, in words.
    """
    canvas = still.copy()
    eye, outside = EYE.of(canvas), OUTSIDE.of(canvas)
    size = (EYE.width, EYE.height)
    eye[:] = cv2.resize(world.image(), size, interpolation=cv2.INTER_CUBIC)
    radius = SCALE * radius_px
    disc(eye, np.array(size) / 2, radius, ROBOT, 2)
    write(canvas, EYE.x + EYE.width, 58, sees, GREY if sees == _TURNS else ROBOT, 18, True, align="right")
    outside[:] = onlooker.render()
    if onlooker.together:
        text = "joint attention"
        wide = width_of(text, 24, True) + 28
        left = (OUTSIDE.width - wide) // 2
        shade(outside[-52:-10, left : left + wide], GROUND, 0.85)
        write(outside, left + 14, OUTSIDE.height - 45, text, GREEN, 24, True)
        brackets(eye, np.array(size) / 2, 2.2 * radius, GREEN, 4)
    return canvas


def still(run: ObservedRun, title: str, when: str, driver: int, looks_at: int) -> np.ndarray:
    """All that stays the same during a step, (720, 1280, 3) uint8.

    Args:
        run: The run, after the step.
        title: Of the scene.
        when: Time or step, in words.
        driver: Module that moved the gaze; others than made modules are shown as the initial ones.
        looks_at: Spot at which the caregiver looks, from 0; the number of spots for the robot.
    """
    canvas = headed(title, when, looks_at, run.spots)
    _draw_drivers(canvas, run, driver)
    _draw_strip(canvas, run)
    return canvas


def headed(title: str, when: str, looks_at: int, spots: int) -> np.ndarray:
    """An image with its title and the names of both views, (720, 1280, 3) uint8.

    Args:
        title: Of the scene.
        when: Time or step, in words.
        looks_at: Spot at which the caregiver looks, from 0; ``spots`` for the robot.
        spots: Number of spots.
    """
    canvas = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
    left = write(canvas, WIDTH - 16, 14, when, WHITE, 22, align="right") - width_of(when, 22)
    write(canvas, 16, 10, title, WHITE, fitting(title, left - 40, (26, 22, 18, 15), True), True)
    write(canvas, EYE.x, 54, "What the robot sees", WHITE, 22, True)
    write(canvas, OUTSIDE.x, 54, "From outside", WHITE, 22, True)
    where = "the robot" if looks_at == spots else f"spot {looks_at + 1}"
    write(canvas, OUTSIDE.x + OUTSIDE.width, 58, f"the caregiver looks at {where}", PERSON, 18, align="right")
    return canvas


def _sensed(run: ObservedRun) -> str:
    """What the robot takes the centre of its image for, and in brackets what that mostly means."""
    face, known = run.agent.variables.sensors[0], run.named_variables().sensors[0]
    value, there = (int(run.log(name, run.steps_done - 1)[0]) for name in (FACE, OBJECT))
    if value < len(face.values) - 1:
        return f"{face.values[value]} (mostly: looks {known.values[value]})"
    return "an object" if there else "nothing"


def _draw_drivers(canvas: np.ndarray, run: DevelopmentRun, driver: int) -> None:
    """Draw a list of the modules, and mark which of them has just moved the gaze."""
    area = _DRIVERS.of(canvas)
    area[:] = PANEL
    write(area, 14, 8, "What moves its gaze", WHITE, TITLE, True)
    made = [detection for detection in run.detections if detection.module is not None]
    known = meanings(run.named_variables(), run.agent.modules)
    curious = any(isinstance(module, CuriousModule) for module in run.agent.reactive)
    rows = [("curiosity, as at first" if curious else "at random, as at first", "", GREY, driver >= len(made))]
    for number, (module, meaning) in enumerate(zip(made, known, strict=True)):
        ink = INKS[number % len(INKS)]
        rows.append((f"{number + 1}  {meaning.label}", f"step {module.step:,}", ink, driver == number))
    y = 40
    for words, when, ink, active in rows:
        parts = _wrapped(words, area.shape[1] - 50 - (width_of(when, SMALL) + 14), active)
        if y + 23 * len(parts) > len(area):
            break
        if active:
            shade(area[y - 2 : y + 23 * len(parts) + 1], ink, 0.35)
            disc(area, np.array([20.0, y + 11.0]), 7, ink)
        write(area, area.shape[1] - 14, y + 1, when, GREY, SMALL, align="right")
        for part in parts:
            write(area, 36, y, part, WHITE if active else ink, TEXT, active)
            y += 23
        y += 6


def _wrapped(text: str, width: float, bold: bool) -> list[str]:
    """``text`` in lines of at most ``width`` pixels, broken between words; at most three lines."""
    parts, line = list[str](), ""
    for word in text.split(" "):
        longer = f"{line} {word}" if line else word
        if line and width_of(longer, TEXT, bold) > width:
            parts.append(line)
            line = f"    {word}"
        else:
            line = longer
    parts.append(line)
    return parts if len(parts) <= 3 else [*parts[:2], f"{parts[2]} ..."]


def _draw_strip(canvas: np.ndarray, run: DevelopmentRun) -> None:
    """Draw what the robot did in its last steps, by the names of Fig. 5.5."""
    area = _STRIP.of(canvas)
    area[:] = PANEL
    write(area, 14, 5, "What it did, step by step", WHITE, TITLE, True)
    done = BehaviourLog(run)[-_SHOWN:]
    for column, kind in enumerate(done):
        x = 14 + 38 * column
        area[34:62, x : x + 35] = BEHAVIOUR_INKS[kind]
        write(area, x + 17, 39, SHORT[kind], GROUND, 13, True, align="centre")
    for number, words in enumerate(BEHAVIOURS):
        x, y = 14 + 312 * (number % 2), 66 + 20 * (number // 2)
        end = write(area, x, y, SHORT[number], BEHAVIOUR_INKS[number], SMALL, True)
        write(area, end + 8, y, words, WHITE if number in done else _DIM, SMALL)
