"""Calls from Python with arguments that make no sense: an error with a name, and nothing worse."""

import itertools
import random
from collections.abc import Iterator

from tools.reliability.malformed import Input, anything, refused

WORLD = """
import sys, warnings
import numpy as np
import jointattn_mj
from jointattn_mj.errors import JointAttnError
nan, inf = float("nan"), float("inf")
x, y, z = np.random.default_rng(0).integers(0, 3, (3, 200))
try:
    {call}
except JointAttnError as error:
    print(f"{{type(error).__name__}}: {{str(error).splitlines()[0]}}", file=sys.stderr)
    sys.exit(2)
"""
SERIES = (
    "None", "[]", "[nan] * 200", "[inf] * 200", "[1.5] * 200", "x[:7]", "x.reshape(2, 100)", "'word'", "[None] * 200",
    "[object()] * 200", "x + 1j", "x.astype(float) + 0.5", "[10 ** 30] * 200", "[[1], [2, 3]]", "{}", "5", "b'bytes'",
    "np.array(x, dtype=object)", "np.full(200, 2 ** 63 - 1)", "np.full(200, -(2 ** 63))",
)  # fmt: skip
MAYBE = {"x + 1j", "np.array(x, dtype=object)", "np.full(200, 2 ** 63 - 1)", "np.full(200, -(2 ** 63))",
         "[10 ** 30] * 200"}  # fmt: skip
"""Of which a measure may make something."""
SCALARS = ("nan", "inf", "-inf", "1e308", "-1", "2 ** 63", "None", "'word'", "[]", "10 ** 400", "1j")
MEASURES = ("transfer_entropy", "mutual_information", "linear_granger")
CONDITIONAL = ("state_action_contingency", "combined_transfer_entropy", "conditional_mutual_information",
               "contingent_saliency", "local_contingency")  # fmt: skip
TASKS = ("object_transfer", "object_transfer_hard", "follow", "follow_hard", "turn_taking", "turn_taking_hard")
ACTIONS = (
    "[nan, 0]", "[inf, 0]", "[0, -inf]", "[1e308, 0]", "[0]", "[0, 0, 0]", "[]", "None", "'ab'", "[None, None]",
    "[[0, 0]]", "[0.5j, 0]", "nan", "[10 ** 400, 0]", "{}", "[2 ** 63, 0]", "[-1, nan]",
    "np.array([0, 0], dtype=object)", "['0', '0']",
)  # fmt: skip
TAKEN = {"[1e308, 0]", "[2 ** 63, 0]", "np.array([0, 0], dtype=object)"}
"""Which may be clipped, or be right."""
NAMES = {"object_transfer": "ObjectTransfer", "follow": "Follow", "turn_taking": "TurnTaking"}
TASK_KWARGS = (
    "{'random': nan}", "{'random': -1}", "{'random': 'x'}", "{'time_limit': nan}", "{'time_limit': -1}",
    "{'time_limit': 'x'}", "{'people': ('nobody',)}", "{'variation': 'weather'}", "{'variation': 5}", "{'no': 1}",
    "{'camera': 'perhaps'}", "{'world': 5}", "5", "'x'", "{'time_limit': inf, 'random': 1.5}",
)  # fmt: skip
CONFIGS = {
    "jointattn_mj.gaze_following.session.SessionConfig": (
        "minutes",
        "seed",
        "perception",
        "success",
        "start_from",
        "robot",
        "world",
    ),
    "jointattn_mj.development.table.config.TableDevelopmentConfig": (
        "world",
        "preset",
        "steps",
        "seed",
        "reactive",
        "sample_every",
        "agent",
    ),
    "jointattn_mj.development.rendered.run.RenderedConfig": ("calibration", "exploration", "senses"),
    "jointattn_mj.development.realtime.run.RealtimeConfig": (
        "looks_every",
        "shift_frames",
        "variation",
        "familiarise_minutes",
    ),
    "jointattn_mj.scene.variation.VariationConfig": ("light_strength", "people", "object_size", "camera_noise"),
    "jointattn_mj.development.agent.DeveloperConfig": ("history", "memory", "horizon", "most_modules"),
    "jointattn_mj.development.table.world.TableConfig": ("spots", "objects", "kinds", "gestures", "order"),
    "jointattn_mj.contingency.TestOptions": ("surrogates", "resamples", "block", "level", "permute"),
}


def measures() -> Iterator[tuple[str, str, bool]]:
    """Lines, a name for them, and whether they must be refused."""
    for series in SERIES:
        for name in MEASURES:
            yield _measure(name, series, "y"), f"{name}({series}, y)", series not in MAYBE
            yield _measure(name, "x", series), f"{name}(x, {series})", series not in MAYBE
        for name in CONDITIONAL:
            yield _measure(name, "x", series, "z"), f"{name}(x, {series}, z)", series not in MAYBE
        yield _measure("assess", "'transfer_entropy'", "x", series), f"assess(.., x, {series})", series not in MAYBE
    for value in SCALARS:
        yield _measure("transfer_entropy", "x", "y", f"base={value}"), f"transfer_entropy(base={value})", True
        yield _measure("assess", value, "x", "y"), f"assess({value}, x, y)", True
    for path in ("None", "5", "''", "'no.csv'", "'/'", "'/dev/null'", r"'a\0b'", "'x' * 5000"):
        read = f"from jointattn_mj import read_recordings; read_recordings({path}, ['x'])"
        yield read, f"read_recordings({path})", True


def configs() -> Iterator[tuple[str, str, bool]]:
    """The same for options as dataclasses."""
    for path, fields in CONFIGS.items():
        module, _, name = path.rpartition(".")
        for field, value in itertools.product(fields, SCALARS):
            call = f"from {module} import {name}; print({name}({field}={value}))"
            yield call, f"{name}({field}={value})", value in ("nan", "-inf", "1e308", "10 ** 400", "1j")


def environments() -> Iterator[tuple[str, str, bool]]:
    """The same for the tasks, from dm_control and Gymnasium."""
    for task in TASKS:
        base = task.removesuffix("_hard")
        name = NAMES[base] + ("Hard" if base != task else "")
        for action in ACTIONS:
            made = f"env = jointattn_mj.load('joint_attention', '{task}', task_kwargs={{'random': 0, 'camera': False}})"
            step = f"env.reset(); timestep = env.step({action}); assert np.isfinite(timestep.reward)"
            yield f"{made}; {step}", f"{task}: step({action})", action not in TAKEN
            made = f"import gymnasium; env = gymnasium.make('jointattn_mj:{name}-v0', camera=False).unwrapped"
            step = f"env.reset(seed=0); _, reward, *_ = env.step({action}); assert np.isfinite(reward)"
            yield f"{made}; {step}", f"{name}-v0: step({action})", action not in TAKEN
        for settings in TASK_KWARGS:
            made = f"env = jointattn_mj.load('joint_attention', '{task}', task_kwargs={settings}); env.reset()"
            yield made, f"load({task}, {settings})", "'camera'" not in settings
    for name in ("None", "5", "'no'", "''", "[]"):
        yield f"jointattn_mj.load({name}, 'follow')", f"load({name}, 'follow')", True
        yield f"jointattn_mj.load('joint_attention', {name})", f"load('joint_attention', {name})", True


KINDS = {"measures": measures, "configs": configs, "environments": environments}


def _measure(name: str, *arguments: str) -> str:
    return f"from jointattn_mj.contingency import {name}; print({name}({', '.join(arguments)}))"


def inputs(chance: random.Random, many: int) -> Iterator[Input]:
    """``many`` of them, as many of each kind."""
    for kind, listed in KINDS.items():
        calls = list(listed())
        chance.shuffle(calls)
        for call, what, must in calls[: -(-many // len(KINDS))]:
            result = refused if must else anything
            yield Input(f"Python, {kind}", what, source=WORLD.format(call=call), result=result)
