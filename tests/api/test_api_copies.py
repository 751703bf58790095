"""Results can be pickled and copied, and cannot be changed."""

import copy
import dataclasses
import pickle
from pathlib import Path

import pytest
from clips import Clip, encode

from jointattn_mj import ClaimResult, Development, DevelopmentResult, Session, SessionResult, perceive, run_claim
from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.agent import FamiliariseConfig, RobotConfig
from jointattn_mj.perception.som import SOMConfig
from jointattn_mj.scene import gl

pytestmark = pytest.mark.integration

WAYS = {"pickle": lambda result: pickle.loads(pickle.dumps(result)), "copy": copy.copy, "deepcopy": copy.deepcopy}
SHORT = RobotConfig(familiarise=FamiliariseConfig(minutes=0.05))
needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")


def session(folder: Path) -> list[SessionResult]:
    result = Session(minutes=0.2, perception="state", robot=SHORT).run()
    result.save(folder / "out")
    opened = SessionResult.open(folder / "out")
    return [result, opened, SessionResult.open(folder / "out")] if len(opened.frames) else []


def development(folder: Path) -> list[DevelopmentResult]:
    result = Development("fast", steps=4000, seed=1).run()
    assert result.modules
    result.save(folder / "out")
    return [result, DevelopmentResult.open(folder / "out")]


def rendered_development(folder: Path) -> list[DevelopmentResult]:
    return [Development(world="rendered", steps=30).run()]


def realtime_development(folder: Path) -> list[DevelopmentResult]:
    return [Development(world="realtime", minutes=0.05).run()]


def claim(folder: Path) -> list[ClaimResult]:
    return [run_claim("1.1", folder / "out", runs=1, jobs=1, registry="toys.registry")]


def perception(folder: Path) -> list:
    video = encode(folder / "clip.mkv", Clip.rendered("amara", 12, seed=3).images)
    result = perceive(video, folder / "out", overlay=False, som=SOMConfig(updates=100))
    return [*list(result)[:1], result.percepts, result]


MADE = [
    session, development, claim, pytest.param(perception, marks=needs_gl),
    pytest.param(rendered_development, marks=needs_gl), realtime_development,
]  # fmt: skip


@pytest.mark.parametrize("make", MADE)
def test_copies_are_equal(make, tmp_path):
    results = make(tmp_path)
    for result in results:
        for name, way in WAYS.items():
            assert way(result) == result, name
            assert repr(way(result)) == repr(result)


def test_a_development_is_its_config():
    development = Development("fast", steps=4000, seed=1)
    assert development == Development("fast", steps=4000, seed=1) != development.replace(seed=2)
    assert (development.steps, development.replace(seed=2).seed, development.preset) == (4000, 2, "fast")
    assert all(way(development) == development for way in WAYS.values())
    with pytest.raises(dataclasses.FrozenInstanceError):
        development.config = None
    with pytest.raises(AttributeError, match="no attribute 'stesp'"):
        development.stesp  # noqa: B018
    for wrong, words in (({"stesp": 3}, "'steps'"), ({"preset": "thesis"}, "make another Development")):
        with pytest.raises(ConfigError, match=words):
            development.replace(**wrong)
    with pytest.raises(ConfigError, match="config: expected a DevelopmentConfig; got 3"):
        Development.from_config(3)


@pytest.mark.parametrize("choice", [{"maps": "continuous"}, {"resolution": "growing"}])
def test_options_from_which_others_follow_are_not_replaced(choice):
    """Those that follow would keep the values of the other choice."""
    development = Development("fast", world="rendered")
    assert Development("fast", world="rendered", **choice).rendered != development.rendered
    with pytest.raises(ConfigError, match="maps and resolution; make another"):
        development.replace(**choice)


def test_a_session_with_other_options():
    session = Session(minutes=2, perception="state", seed=1, preset="cross_situational", motion_cues=False)
    other = session.replace(seed=2, robot={"gaze": {"gate": "open"}}, caregiver="noa")
    assert other == Session(
        2, 2, "state", preset="cross_situational", motion_cues=False, robot={"gaze": {"gate": "open"}}, caregiver="noa"
    )
    assert session.seed == 1 and other.replace() == other and type(other) is Session
    for wrong, words in (
        ({"sede": 3}, "'seed'"),
        ({"preset": "thesis"}, "make another Session"),
        ({"seed": -1}, "seed"),
    ):
        with pytest.raises(ConfigError, match=words):
            session.replace(**wrong)


@pytest.mark.parametrize("make", MADE[:3])
def test_results_do_not_change(make, tmp_path):
    result = make(tmp_path)[0]
    for name in ("folder", "summary", "new"):
        with pytest.raises((dataclasses.FrozenInstanceError, AttributeError)):
            setattr(result, name, 3)
