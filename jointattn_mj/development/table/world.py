"""The table without images: spots, objects on some of them, caregiver and robot (sections 4.3.1 and 5.3.1)."""

from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from jointattn_mj.contingency.online.events import Variable, Variables
from jointattn_mj.development.one_type import one_type
from jointattn_mj.development.table.caregiver import NOWHERE, OPTIONS, Rules, TableCaregiverConfig, rules, shift_gaze
from jointattn_mj.errors import ConfigError, ObservationError
from jointattn_mj.guards.border import checked_by, require_array
from jointattn_mj.guards.restored import check_alike, check_array
from jointattn_mj.io.compiled import njit
from jointattn_mj.io.held import Held
from jointattn_mj.options import Checked, Share, Whole

ROBOT, CAREGIVER, RETURNS_TO, OPTION, STEP = range(5)
"""Positions in ``TableState.state``."""
OBJECTS, KINDS, REPLACED_EVERY, PROFILE, ROBOT_FIRST = range(5)
"""Positions in ``TableState.layout``."""
LOOKS_AT, OPTION_TAKEN = "caregiver looks at", "caregiver's option"
"""Columns of the log that the robot does not know: CAREGIVER and OPTION of ``TableState.state``."""


@dataclass(frozen=True)
class TableConfig(Checked):
    """Settings of the world of chapters 4 and 5."""

    spots: Annotated[int, Whole("[2, 125]")] = 3
    """N, number of spots on the table."""
    objects: Annotated[int, Whole("[1, 125]")] = 2
    """M', number of objects on the table."""
    kinds: Annotated[int, Whole("[1, 125]")] = 1
    """M, number of kinds of objects, which the robot tells apart (S_2). Chapter 5 has one kind."""
    gestures: Annotated[int, Whole("[1, 125]")] = 4
    """N_h, number of the robot's hand gestures; nobody answers them."""
    replaced_every: Annotated[int, Whole("[1, 1e10]")] = 10
    """L, steps after which the objects are placed anew."""
    profile: bool = True
    """Whether the caregiver's profile is a result of its own (R_2 of chapter 5; chapter 4 has none)."""
    order: Literal["caregiver_first", "robot_first"] = "caregiver_first"
    """Order within a step. ``caregiver_first``, section 4.3.1: objects are placed, the caregiver shifts, the robot
    observes sensors and results, the robot acts. ``robot_first``: the robot acts and observes the results, objects are
    placed, the caregiver shifts, the robot observes the sensors."""
    caregiver: TableCaregiverConfig = field(default_factory=TableCaregiverConfig)
    """How the caregiver shifts gaze."""
    wrong: Share = 0.0
    """Share of observations that are wrong: a face that is seen to look elsewhere, an object that is missed where one
    is, or seen where none is."""
    profile_shows: Literal["gaze", "nothing"] = "gaze"
    """What the robot sees of the caregiver's gaze in a profile. ``gaze``: where it goes. ``nothing``: a spot drawn anew
    in each step, for runs in which there is nothing to find."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.order == "robot_first" and (self.wrong or self.profile_shows == "nothing"):
            raise ConfigError("wrong observations and profiles that show nothing need order caregiver_first")
        if self.objects > self.spots:
            raise ConfigError(f"a table needs as many spots as objects, or more; got {self.spots} for {self.objects}")
        if not (self.kinds == 1 or self.kinds >= self.objects):
            raise ConfigError(f"kinds must be 1, or enough for {self.objects} objects; got {self.kinds}")


CHAPTER_4 = TableConfig(
    spots=9, objects=3, kinds=10, gestures=10, profile=False,
    caregiver=TableCaregiverConfig(follow=0.8, lead=0.2, answer=0.0, follows_eye_contact=True),
)  # fmt: skip
"""Section 4.5.1."""
CHAPTER_5 = TableConfig()
"""Section 5.3.1 with the caregiver of section 5.3.2."""


def table_variables(config: TableConfig) -> Variables:
    """Sensors, actions and results of the robot at a table (Table 4.1, Table 5.1)."""
    spots = [f"spot {number}" for number in range(1, config.spots + 1)]
    kinds = ["object"] if config.kinds == 1 else [f"object {number}" for number in range(1, config.kinds + 1)]
    binary = ("no", "yes")
    results = [Variable("frontal face", binary), Variable("object", binary)]
    if config.profile:
        results.insert(1, Variable("profile", binary))
    return Variables(
        sensors=(
            Variable("caregiver's face", (*(f"at {spot}" for spot in spots), "at robot", "not seen")),
            Variable("object looked at", (*kinds, "none")),
        ),
        actions=(
            Variable("shift gaze", (*spots, "caregiver")),
            Variable("gesture", tuple(f"gesture {number}" for number in range(1, config.gestures + 1))),
        ),
        results=tuple(results),
    )


@one_type
class TableState(NamedTuple):
    """State of the table, for compiled code. Spots are 0 to N - 1; as a gaze target, N is the other's face."""

    full: np.ndarray
    """(N,) whether an object lies on a spot."""
    kind: np.ndarray
    """(N,) kind of the object on a spot."""
    state: np.ndarray
    """(5,) gaze targets of ROBOT and CAREGIVER, RETURNS_TO and OPTION of ``shift_gaze``, number of the STEP."""
    rules: Rules
    layout: np.ndarray
    """(5,) OBJECTS, KINDS, REPLACED_EVERY, PROFILE and ROBOT_FIRST of ``TableConfig``."""
    order: np.ndarray
    """(N,) spots, shuffled when objects are placed."""
    kinds: np.ndarray
    """(kinds,) likewise."""
    allowed: np.ndarray
    """(N,) working space: spots that the caregiver may choose."""
    wrong: float
    """Share of observations that are wrong."""
    shows_gaze: bool
    """Whether a profile shows where the caregiver looks."""
    world_random: np.random.Generator
    caregiver_random: np.random.Generator
    observation_random: np.random.Generator


def table_witnessed(config: TableConfig) -> dict[str, tuple[str, ...]]:
    """Columns of the log that the robot does not know, and the names of their values."""
    spots = tuple(f"spot {number}" for number in range(1, config.spots + 1))
    return {LOOKS_AT: (*spots, "robot"), OPTION_TAKEN: OPTIONS}


def new_table(config: TableConfig, seed: np.random.SeedSequence) -> TableState:
    """A table before the first step; robot and caregiver look at each other.

    Args:
        config: Rules of the table.
        seed: Of the places of objects and of the caregiver.
    """
    world, caregiver, observation = (np.random.default_rng(child) for child in seed.spawn(3))
    layout = (config.objects, config.kinds, config.replaced_every, config.profile, config.order == "robot_first")
    return TableState(
        full=np.zeros(config.spots, np.bool_),
        kind=np.zeros(config.spots, np.int64),
        state=np.array([config.spots, config.spots, NOWHERE, 0, 0], np.int64),
        rules=rules(config.caregiver),
        layout=np.array(layout, np.int64),
        order=np.arange(config.spots),
        kinds=np.arange(config.kinds),
        allowed=np.zeros(config.spots, np.bool_),
        wrong=float(config.wrong),
        shows_gaze=config.profile_shows == "gaze",
        world_random=world,
        caregiver_random=caregiver,
        observation_random=observation,
    )


def check_table(table: TableState, config: TableConfig) -> None:
    """Refuse a table from a checkpoint that compiled code cannot use.

    Args:
        table: State of the table.
        config: Its rules.

    Raises:
        ValueError: It is not one of ``config``, or holds a spot that does not exist.
    """
    model = new_table(config, np.random.SeedSequence(0))
    check_alike(table, model)
    face = config.spots
    largest = [face, face, face - 1, len(OPTIONS) - 1, np.iinfo(np.int64).max]
    check_array("state of the table", table.state, (5,), np.int64, [0, 0, NOWHERE, 0, 0], largest)
    check_array("kinds of objects", table.kind, (face,), np.int64, 0, config.kinds - 1)
    check_array("layout of the table", table.layout, (5,), np.int64, model.layout, model.layout)
    for name, order in (("spots", table.order), ("kinds", table.kinds)):
        if not np.array_equal(np.sort(order), np.arange(len(order))):
            raise ValueError(f"{name} of the table must each occur once")
    if (table.rules, table.wrong, table.shows_gaze) != (model.rules, model.wrong, model.shows_gaze):
        raise ValueError("rules of the table are others than its config's")


@njit(cache=True, borrows=True, forceinline=True)
def _shuffle_first(items: np.ndarray, count: int, random: np.random.Generator) -> None:
    for i in range(count):
        other = i + int(random.random() * (len(items) - i))
        items[i], items[other] = items[other], items[i]


@njit(cache=True, borrows=True, forceinline=True)
def place_objects(table: TableState) -> None:
    """Put the objects on random spots."""
    objects, kinds = table.layout[OBJECTS], table.layout[KINDS]
    _shuffle_first(table.order, objects, table.world_random)
    if kinds > 1:
        _shuffle_first(table.kinds, objects, table.world_random)
    for spot in range(len(table.full)):
        table.full[spot] = False
    for number in range(objects):
        table.full[table.order[number]] = True
        table.kind[table.order[number]] = table.kinds[number] if kinds > 1 else 0


@njit(cache=True, borrows=True, forceinline=True)
def _write_results(table: TableState, r: np.ndarray) -> None:
    state, face = table.state, len(table.full)
    at_face = state[ROBOT] == face
    frontal = at_face and state[CAREGIVER] == face
    r[0] = frontal
    if table.layout[PROFILE]:
        r[1] = at_face and not frontal
    r[len(r) - 1] = not at_face and table.full[state[ROBOT]]


@njit(cache=True, borrows=True, forceinline=True)
def _mistake(table: TableState, s: np.ndarray, r: np.ndarray) -> None:
    """Let the robot see something else than what is there, as often as configured."""
    face, random = len(table.full), table.observation_random
    if table.state[ROBOT] == face:
        if not table.shows_gaze and s[0] != face:
            s[0] = int(random.random() * face)
        if random.random() < table.wrong:
            other = int(random.random() * face)
            s[0] = other + (other >= s[0])
            r[0] = s[0] == face
            if table.layout[PROFILE]:
                r[1] = s[0] != face
    elif random.random() < table.wrong:
        there = r[len(r) - 1] == 0
        kinds = table.layout[KINDS]
        s[1] = int(random.random() * kinds) if there else kinds
        r[len(r) - 1] = there


def check_step(table: Any, a: np.ndarray, s: np.ndarray, r: np.ndarray) -> None:
    """Refuse what ``step`` cannot do.

    Args:
        table: Of ``step``, as the others.
        a: Likewise.
        s: Likewise.
        r: Likewise.

    Raises:
        ObservationError: Compiled code would look it up elsewhere.
    """
    if not isinstance(table, TableState):
        raise ObservationError(f"expected a TableState, as new_table makes it; got {type(table).__name__}")
    require_array("where the robot looks, and its gesture", a, (2,), "iu")
    require_array("where the robot looks", a[:1], (1,), "iu", 0, len(table.full))
    require_array("sensors to be written", s, (2,), "i")
    require_array("results to be written", r, (2 + int(table.layout[PROFILE]),), "i")


@checked_by(check_step)
@njit(cache=True, borrows=True, forceinline=True)
def step(table: TableState, a: np.ndarray, s: np.ndarray, r: np.ndarray) -> None:
    """Let the robot act and the caregiver answer, in the configured order.

    Args:
        table: State of the table, changed in place.
        a: (2,) the robot's actions: gaze target from now on, and gesture.
        s: (2,) is written: values of the sensors then.
        r: (results,) is written: values of the results.
    """
    state, face = table.state, len(table.full)
    if state[STEP] > 0:
        state[ROBOT] = a[0]
    if table.layout[ROBOT_FIRST]:
        _write_results(table, r)
    if state[STEP] % table.layout[REPLACED_EVERY] == 0:
        place_objects(table)
    state[CAREGIVER], state[RETURNS_TO], state[OPTION] = shift_gaze(
        table.rules,
        table.full,
        state[ROBOT],
        state[CAREGIVER],
        state[RETURNS_TO],
        table.caregiver_random,
        table.allowed,
    )
    if state[ROBOT] == face:
        s[0] = state[CAREGIVER]
        s[1] = table.layout[KINDS]
    else:
        s[0] = face + 1
        s[1] = table.kind[state[ROBOT]] if table.full[state[ROBOT]] else table.layout[KINDS]
    if not table.layout[ROBOT_FIRST]:
        _write_results(table, r)
        if table.wrong > 0.0 or not table.shows_gaze:
            _mistake(table, s, r)
    state[STEP] += 1


@njit(cache=True)
def hold(table: TableState) -> Held:
    """A table, to be handed over once for many calls of ``step_held``."""
    return Held(table)


@njit(cache=True)
def step_held(held: Held, a: np.ndarray, s: np.ndarray, r: np.ndarray) -> None:
    """``step``, for calls from Python in every step; ``check_step`` says what it takes.

    Args:
        held: The table, changed in place.
        a: As ``step``, like all others.
        s: Likewise.
        r: Likewise.
    """
    step(held.value, a, s, r)
