"""Every field of every config says what it may be, and nothing else gets in."""

import dataclasses
import importlib
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import pytest

import experiments
import jointattn_mj
from experiments.registry import REGISTRY
from jointattn_mj import Development, Session, perceive, read_recordings, recordings, run_claim
from jointattn_mj.development.rendered.stage import StageConfig
from jointattn_mj.errors import ConfigError, JointAttnError
from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.gaze_following.agent import RobotConfig
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.gaze_following.gate import GazeConfig
from jointattn_mj.gaze_following.learners import LearnerConfig
from jointattn_mj.gaze_following.run import SessionOptions
from jointattn_mj.gaze_following.session import SessionConfig
from jointattn_mj.options import (
    LONGEST_NAME,
    Checked,
    Choice,
    Interval,
    Real,
    RenamedWarning,
    Whole,
    old_choices,
    old_names,
    rule_of,
    shown,
)
from jointattn_mj.perception.som import SOMConfig
from jointattn_mj.scene.model import SceneConfig
from jointattn_mj.scene.variation import VariationConfig

HUGE = [float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 2**63, -(2**63), 10**5000]


def dataclasses_of(package: Any) -> Iterator[type]:
    """All that a package defines, without modules whose extras are not installed. Modules that define none are not
    imported: some bring PyTorch, which takes seconds."""
    for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        spec = find_spec(found.name)
        if spec is None or spec.origin is None or "@dataclass" not in Path(spec.origin).read_text("utf-8"):
            continue
        try:
            module = importlib.import_module(found.name)
        except (ImportError, JointAttnError):
            continue
        for kind in vars(module).values():
            if isinstance(kind, type) and dataclasses.is_dataclass(kind) and kind.__module__ == module.__name__:
                yield kind


def parts(hint: Any) -> Iterator[type]:
    """The classes that an annotation mentions."""
    if isinstance(hint, type) and not get_args(hint):
        yield hint
    for part in get_args(hint) if get_origin(hint) is not Literal else ():
        yield from parts(part)


def named_as_configs() -> set[type]:
    """Dataclasses that are called so, those in their fields, and what the claims' settings are."""
    kinds = {kind for package in (jointattn_mj, experiments) for kind in dataclasses_of(package)}
    found = {kind for kind in kinds if kind.__name__.endswith(("Config", "Options"))}
    found |= {type(setting.config) for claim in REGISTRY.values() for setting in claim.settings.values()} - {dict}
    todo = list(found)
    while todo:
        for hint in get_type_hints(todo.pop(), include_extras=True).values():
            new = {kind for kind in parts(hint) if dataclasses.is_dataclass(kind)} - found
            new = {kind for kind in new if kind.__module__.split(".")[0] in ("jointattn_mj", "experiments")}
            found |= new
            todo += new
    return found


def of_checked(kind: type = Checked) -> Iterator[type]:
    for child in kind.__subclasses__():
        if child.__module__.split(".")[0] in ("jointattn_mj", "experiments"):
            yield child
        yield from of_checked(child)


NAMED = named_as_configs()
CONFIGS = sorted(set(of_checked()), key=lambda kind: (kind.__module__, kind.__name__))
FIELDS = [(config, field.name) for config in CONFIGS for field in dataclasses.fields(config)]


def hint_of(config: type, name: str) -> Any:
    return get_type_hints(config, include_extras=True)[name]


def marks(hint: Any) -> list[Any]:
    return [mark for mark in get_args(hint)[1:] if isinstance(mark, (Interval, Choice))]


def right(hint: Any) -> Any:
    """A value that an annotation allows."""
    if get_origin(hint) is Annotated:
        found = marks(hint)
        if not found:
            return right(get_args(hint)[0])
        return (found[0].low + found[0].high) // 2 if isinstance(found[0], Interval) else found[0].names[0]
    if get_origin(hint) in (Union, UnionType):
        return right(get_args(hint)[0])
    if get_origin(hint) is Literal:
        return get_args(hint)[0]
    if get_origin(hint) is tuple:
        return tuple(right(part) for part in get_args(hint) if part is not Ellipsis)
    return example(hint) if dataclasses.is_dataclass(hint) else {str: "a", Path: Path("a"), bool: True}.get(hint)


def example(config: type) -> Any:
    """A config with its defaults, and something right where there are none."""
    hints = get_type_hints(config, include_extras=True)
    missing = [
        field.name
        for field in dataclasses.fields(config)
        if field.default is field.default_factory is dataclasses.MISSING
    ]
    return config(**{name: right(hints[name]) for name in missing})


def wrong(hint: Any) -> Iterator[Any]:
    """Values that an annotation does not allow."""
    if get_origin(hint) is Annotated:
        found = marks(hint)
        if not found:
            yield from wrong(get_args(hint)[0])
        elif isinstance(found[0], Interval):
            yield from (*HUGE, "1", True, np.True_, None, [1], np.float64("nan"), 1j)
            if isinstance(found[0], Whole):
                yield from (0.5, 3.0)
        else:  # a Choice
            name = found[0].names[0]
            yield from ("", "no such", f"{name}+", 0, True, None, (name,))
            if name.lower() not in found[0].other_names:
                yield name.swapcase()
    elif get_origin(hint) in (Union, UnionType):
        options = [option for option in get_args(hint) if option is not NoneType]
        assert len(options) == 1, f"a test for {hint} is missing"
        yield from (value for value in wrong(options[0]) if value is not None or len(get_args(hint)) == 1)
    elif get_origin(hint) is Literal:
        yield from ("", "no such", get_args(hint)[0].swapcase(), 0, True, None, (get_args(hint)[0],))
    elif get_origin(hint) is tuple:
        items = [part for part in get_args(hint) if part is not Ellipsis]
        good = tuple(right(part) for part in items)
        yield from (None, "a", 1, np.zeros(3))
        if Ellipsis not in get_args(hint):
            yield from ((), (*good, good[0]))
        for location, item in enumerate(items):
            for value in wrong(item):
                yield (*good[:location], value, *good[location + 1 :])
    elif hint is Path:
        yield from (None, 3.5, True, "a\0b", Path("x" * (LONGEST_NAME + 1)), Path("a/" * 3000), b"a")
    elif hint is str:
        yield from (None, 3.5, True, b"a", "a\0b", ("a",))
    elif hint is bool:
        yield from (None, 0, 1, 1.0, "True", float("nan"))
    elif hint is not Any:
        yield from (None, 0, "a", object(), {})


def test_each_dataclass_with_options_is_checked():
    """A new one cannot be forgotten."""
    assert len(NAMED) > 60
    assert not [kind for kind in NAMED if not issubclass(kind, Checked)]
    assert set(CONFIGS) >= NAMED


def test_each_number_declares_finite_bounds():
    numbers = 0
    for config, name in FIELDS:
        rule_of(hint_of(config, name))  # raises where an int or a float stands alone
        todo = [hint_of(config, name)]
        while todo:
            hint = todo.pop()
            todo += get_args(hint) if get_origin(hint) is not Annotated else ()
            if get_origin(hint) is Annotated:
                if not marks(hint):
                    todo.append(get_args(hint)[0])
                for mark in (mark for mark in marks(hint) if isinstance(mark, Interval)):
                    numbers += 1
                    assert isinstance(mark, Real if get_args(hint)[0] is float else Whole), (config, name)
                    assert -(2**63) < mark.low < mark.high < 2**63, (config, name)
    assert numbers > 250
    for bare in (int, float, int | None, tuple[float, ...]):
        with pytest.raises(TypeError, match="interval"):
            rule_of(bare)


@pytest.mark.parametrize("config", CONFIGS, ids=lambda kind: f"{kind.__module__.split('.', 1)[1]}.{kind.__name__}")
def test_nothing_wrong_gets_in(config):
    """Of each field NaN, infinity, 1e308, 2^63, other types and misspelt choices, and the error names it."""
    good = example(config)
    assert replace(good) == good
    for field in dataclasses.fields(config):
        values = list(wrong(hint_of(config, field.name)))
        assert values or hint_of(config, field.name) is Any
        for value in values:
            if config is Session and isinstance(getattr(good, field.name), Checked) and value in (None, {}):
                continue  # a part as it is
            with pytest.raises(ConfigError) as refused:
                replace(good, **{field.name: value})
            message = str(refused.value)
            assert message.removeprefix(f"{config.__name__}.").startswith(f"{field.name}: expected "), message
            assert len(message.splitlines()) == 1
            assert len(message) < 400


@pytest.mark.parametrize("config", CONFIGS, ids=lambda kind: f"{kind.__module__.split('.', 1)[1]}.{kind.__name__}")
def test_old_names_lead_to_new_ones(config):
    names = {field.name for field in dataclasses.fields(config)}
    assert set(config.ADVANCED) <= names
    assert set(old_names(config).values()) <= names
    assert not names & set(old_names(config))
    for name, choices in old_choices(config).items():
        for old, new in choices.items():
            with pytest.warns(RenamedWarning, match=f"'{old}' is now called '{new}'"):
                assert getattr(replace(example(config), **{name: old}), name) == new


@pytest.mark.parametrize(
    "use",
    [
        lambda: SessionConfig(perception="truth"),
        lambda: replace(SessionConfig(), perception="truth"),
        lambda: Session(perception="truth"),
        lambda: Development(agent={"history": "made"}),
        lambda: Development("fast", mind={}),
    ],
)
def test_a_warning_of_an_old_name_points_to_who_used_it(use):
    with pytest.warns(RenamedWarning) as warned:
        use()
    assert {warning.filename for warning in warned} == {__file__}


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda out: Session().run(out=out, video_every=0), "video_every: expected"),
        (lambda out: Development().run(out=out, checkpoint_every=0), "checkpoint_every: expected"),
        (lambda out: perceive("video.mp4", out=out, overlay_every=0), "overlay_every: expected"),
        (lambda out: run_claim("5.2", out=out, runs=0), "runs: expected"),
        (lambda out: run_claim("5.2", out=out, seed=-1), "seed: expected"),
        (lambda out: read_recordings("table.csv", ["gaze"], step=0), "step: expected"),
        (lambda out: recordings.read("table.csv", step=0), "step: expected"),
    ],
)
def test_errors_name_arguments_as_they_are_called(call, says, tmp_path):
    with pytest.raises(ConfigError, match=f"^{says}"):
        call(tmp_path / "out")


def test_a_config_shows_what_differs_from_its_defaults():
    assert repr(SessionConfig()) == "SessionConfig()"
    config = SessionConfig(minutes=2, perception="state", robot=RobotConfig(learner=LearnerConfig(rate=0.1)))
    assert repr(config) == (
        "SessionConfig(minutes=2, perception='state', robot=RobotConfig(learner=LearnerConfig(rate=0.1)))"
    )
    assert eval(repr(config), {kind.__name__: kind for kind in CONFIGS}) == config
    assert repr(SessionOptions(Path("a"))) == f"SessionOptions(out={Path('a')!r})"


@pytest.mark.parametrize("config", CONFIGS, ids=lambda kind: f"{kind.__module__.split('.', 1)[1]}.{kind.__name__}")
def test_reprs_are_short(config):
    assert len(repr(example(config))) < 200


@pytest.mark.parametrize(
    ("make", "field", "meant"),
    [
        (lambda: LearnerConfig(code="Population"), "code", "population"),
        (lambda: AttentionConfig(recovery="Min"), "recovery", "min"),
        (lambda: GazeConfig(gate="Open"), "gate", "open"),
        (lambda: SessionConfig(success="lauch"), "success", "launch"),
        (lambda: SceneConfig(caregiver="robyn"), "caregiver", "robin"),
        (lambda: VariationConfig(people=("noa", "Kai")), "people", "kai"),
        (lambda: StageConfig(variation="lights+peple"), "variation", "people"),
    ],
)
def test_a_misspelt_choice_is_recognised(make, field, meant):
    with pytest.raises(ConfigError, match=rf"\.{field}: expected .*\(perhaps you meant '{meant}'\)"):
        make()


def test_what_is_harmless_is_taken_as_plain_values():
    config = SessionConfig(minutes=np.float64(2.5), seed=np.int32(3))
    assert (type(config.minutes), type(config.seed)) == (float, int)
    units = LearnerConfig(units=tuple(np.array([7, 9]))).units
    assert units == (7, 9)
    assert {type(unit) for unit in units} == {int}
    assert type(SessionConfig(minutes=26).minutes) is int  # a checkpoint's fingerprint knows it for 26.0
    assert type(SceneConfig(caregiver=np.str_("noa")).caregiver) is str
    assert AttentionConfig(motion_cues=np.False_).motion_cues is False
    assert SessionOptions("out/a").out == Path("out/a")


def test_bounds_belong_to_an_interval_as_it_is_written():
    @dataclass(frozen=True)
    class Half(Checked):
        open: Annotated[float, Real("(0, 1)")] = 0.5
        closed: Annotated[int, Whole("[0, 2e3]")] = 0

    assert [Half(closed=value).closed for value in (0, 2000)] == [0, 2000]
    for wrong_value in ({"open": 0}, {"open": 1.0}, {"closed": -1}, {"closed": 2001}):
        with pytest.raises(ConfigError, match=next(iter(wrong_value))):
            Half(**wrong_value)
    with pytest.raises(ConfigError, match=r"Half.open: expected a number in \(0, 1\); got nan$"):
        Half(open=float("nan"))
    for text in ("0, 1", "[0 1]", "[a, b]"):
        with pytest.raises(ValueError, match=r"interval|float"):
            Real(text)


def test_contradictions():
    """What no field can say alone."""
    for make, words in (
        (lambda: LearnerConfig(pan_range_deg=(5.0, -5.0)), "pan_range_deg"),
        (lambda: replace(SessionConfig().world.layout, x_range=(1.0, 1.0)), "x_range"),
        (lambda: replace(SessionConfig().pixels.faces, add_view_below=0.6), "redetect_below"),
    ):
        with pytest.raises(ConfigError, match=words):
            make()
    assert SOMConfig(rate_start=1, sigma_end=5.0).rate_start == 1


def test_long_values_are_cut():
    assert shown("a\nb") == r"'a\nb'"
    assert "very many digits" in shown(10**5000)
    assert len(shown("x" * 10_000)) < 100


def test_a_list_is_kept_as_a_tuple():
    assert LearnerConfig(units=[21, 11]) == LearnerConfig(units=(21, 11))
    assert isinstance(LearnerConfig(units=[21, 11]).units, tuple)
    with pytest.raises(ConfigError, match="expected a tuple"):
        PerceiveConfig("a.mp4", objects="red")
