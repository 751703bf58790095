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
               "contingent_saliency", "local_contingency", "situation_contingency")  # fmt: skip
TASKS = ("object_transfer", "object_transfer_hard", "follow", "follow_hard", "turn_taking", "turn_taking_hard")
ACTIONS = (
    "[nan, 0]", "[inf, 0]", "[0, -inf]", "[1e308, 0]", "[0]", "[0, 0, 0]", "[]", "None", "'ab'", "[None, None]",
    "[[0, 0]]", "[0.5j, 0]", "nan", "[10 ** 400, 0]", "{}", "[2 ** 63, 0]", "[-1, nan]",
    "np.array([0, 0], dtype=object)", "['0', '0']",
)  # fmt: skip
TAKEN = {"[1e308, 0]", "[2 ** 63, 0]", "np.array([0, 0], dtype=object)"}
"""Which may be clipped, or be right."""
STATE = "minutes=0.01, perception='state'"
CALLS = (
    "Session(minutes={})", "Session(seed={})", "Session(robot={})", "Development('fast', steps={})",
    "Development('local', world='realtime', minutes={})", "Development('local', world='rendered', seed={})",
    "Development({})", "Development('fast', world={})", f"Session({STATE}).run(out={{}})",
    f"Session({STATE}).run(progress={{}})", f"Session({STATE}, start_from={{}}).run()",
    f"Session({STATE}).run(resume={{}}, out='x')", "Development('local', steps=100).run(out={})",
    "Development('local', steps=100).run(checkpoint_every={}, out='y')", "perceive({})",
    "perceive('no.mp4', objects={})", "perceive('no.mp4', out={})", "perceive('no.mp4', looks={})",
    "run_claim({}, out='z')", "run_claim('5.2', out={}, runs=1)", "run_claim('5.2', out='z', runs=1, setting={})",
    "read_recordings('no.csv', {})", "read_recordings('no.csv', ['x'], step={})",
)  # fmt: skip
TAKEN_BY_CALLS = {
    "Development({})": {"None"},
    f"Session({STATE}).run(out={{}})": {"None", "'word'"},
    f"Session({STATE}, start_from={{}}).run()": {"None"},
    "Development('local', steps=100).run(out={})": {"None", "'word'"},
    "Development('local', steps=100).run(checkpoint_every={}, out='y')": {"None"},
    "run_claim('5.2', out={}, runs=1)": {"'word'"},
    "run_claim('5.2', out='z', runs=1, setting={})": {"None"},
}
"""Values with which they do something."""
QUICK = "jointattn_mj.contingency.TestOptions(surrogates=5, resamples=0)"
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
    "jointattn_mj.contingency.online.local.LocalConfig": (
        "draws",
        "best",
        "maps",
        "first_look",
        "look_again",
        "policy",
    ),
    "jointattn_mj.gaze_following.learners.LearnerConfig": ("code", "pairs", "smoothing", "forgetting", "units"),
    "jointattn_mj.footage.looks.config.LooksConfig": ("every", "tuning", "rounds", "away", "placements"),
    "jointattn_mj.contingency.PosteriorOptions": ("draws", "concentration"),
    "jointattn_mj.contingency.Timing": ("lag", "source_history", "target_history"),
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
        scan = _measure("scan_lags", "'transfer_entropy'", "x", series, "lags=(1, 2)", "options=" + QUICK)
        yield scan, f"scan_lags(.., x, {series})", series not in MAYBE
        data = f"{{'x': x, 'y': y, 'z': {series}}}"
        ranking = _measure("discover", data, "['x']", "['y']", "['z']", "options=" + QUICK)
        yield ranking, f"discover({{.., 'z': {series}}})", series not in MAYBE
    for value in SCALARS:
        yield _measure("transfer_entropy", "x", "y", f"base={value}"), f"transfer_entropy(base={value})", True
        yield _measure("assess", value, "x", "y"), f"assess({value}, x, y)", True
    for path in ("None", "5", "''", "'no.csv'", "'/'", "'/dev/null'", r"'a\0b'", "'x' * 5000"):
        read = f"from jointattn_mj import read_recordings; read_recordings({path}, ['x'])"
        yield read, f"read_recordings({path})", True


def jobs() -> Iterator[tuple[str, str, bool]]:
    """The same for what has a command of its own."""
    for call, value in itertools.product(CALLS, SCALARS):
        made = call.format(value)
        yield f"jointattn_mj.{made}", made, value not in TAKEN_BY_CALLS.get(call, ())


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


KINDS = {"measures": measures, "jobs": jobs, "configs": configs, "environments": environments}


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
