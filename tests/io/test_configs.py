"""Configs written by a run and read back."""

import re
from dataclasses import replace

import pytest

from jointattn_mj.development.realtime.config import RealtimeDevelopmentConfig
from jointattn_mj.development.rendered.config import RenderedDevelopmentConfig
from jointattn_mj.development.table.config import TableDevelopmentConfig
from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig
from jointattn_mj.io.configs import config_of, read_config
from jointattn_mj.io.provenance import write_config
from jointattn_mj.options import GOES, RenamedWarning
from jointattn_mj.scene.model import ObjectConfig
from jointattn_mj.scene.people import FaceConfig

SESSION = VariedSessionConfig(minutes=2, seed=7, perception="state", start_from="weights.npz", variation="lights+pace")
SCENE = replace(SESSION.world.scene, objects=(ObjectConfig("cup", (1.0, 0.5, 0.0)),), face=FaceConfig())
CONFIGS = [
    SESSION,
    replace(SESSION, world=replace(SESSION.world, scene=SCENE)),
    PerceiveConfig("video.mp4", objects=("blue", "cup=#c03a2b"), fps=25.0),
    *(
        kind.of(preset="fast", steps=7)
        for kind in (TableDevelopmentConfig, RenderedDevelopmentConfig, RealtimeDevelopmentConfig)
    ),
    RenderedDevelopmentConfig.of(maps="continuous"),
    RenderedDevelopmentConfig.of(resolution="growing", babbling={"images": False}),
]


@pytest.mark.parametrize("config", CONFIGS, ids=lambda config: type(config).__name__)
def test_a_config_that_was_written_is_read_back(config, tmp_path):
    write_config(tmp_path / "config.yaml", config)
    assert read_config(tmp_path / "config.yaml", type(config)) == config


def test_fields_that_are_missing_have_their_defaults():
    assert config_of(VariedSessionConfig, {"seed": 3}) == VariedSessionConfig(seed=3)
    assert config_of(VariedSessionConfig, {"world": {"scene": {}}}) == VariedSessionConfig()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("config: {minuets: 3}", "no option 'minuets' .perhaps you meant 'minutes'"),
        ("config: {minutes: -3}", "minutes: expected a number"),
        ("config: {world: {scene: {caregiver: nobody}}}", "caregiver: expected one of"),
        ("config: {robot: 3}", "robot: expected a RobotConfig"),
        (
            "config: {world: {scene: {caregivr: noa}}}",
            "no option 'world.scene.caregivr' .perhaps you meant 'caregiver'",
        ),
        ("config: {truth: {}, state: {}}", "state is given twice: truth is its old name"),
        ("config: 3", "expected a mapping under config, got 3"),
        ("minutes: 3", "expected a mapping under the key config"),
        ("{", "expected a mapping under the key config"),
    ],
)
def test_what_is_no_config_is_named(text, words, tmp_path):
    (tmp_path / "config.yaml").write_text(text)
    with pytest.raises(ConfigError, match=words) as error:
        read_config(tmp_path / "config.yaml", VariedSessionConfig)
    assert str(tmp_path) in str(error.value)


@pytest.mark.parametrize(
    ("kind", "world", "said"),
    [
        (RenderedDevelopmentConfig, "rendered", ()),
        (RealtimeDevelopmentConfig, "realtime", ("world 'rendered' is now called 'realtime'",)),
    ],
)
def test_fields_of_the_last_version(kind, world, said, tmp_path):
    """What a run has left that was made with ``--world rendered --mode``."""
    path, config = tmp_path / "config.yaml", kind.of(steps=7)
    write_config(path, config)
    old = path.read_text().replace(f"world: {world}", f"world: rendered\n  mode: {world}").replace("agent:", "mind:")
    path.write_text(re.sub(r"stop_rule: confidence", "rule: certain", old))
    with pytest.warns(RenamedWarning) as caught:
        assert read_config(path, kind) == config
    warned = [str(warning.message).removesuffix(GOES) for warning in caught]
    names = "mode is left out", "mind is now called agent"
    deeper = "agent.detector.rule is now called agent.detector.stop_rule"
    choice = "agent.detector.stop_rule 'certain' is now called 'confidence'"
    assert set(warned) == {*names, deeper, choice, *said}


def test_a_file_that_is_missing(tmp_path):
    with pytest.raises(ConfigError, match="cannot read"):
        read_config(tmp_path / "config.yaml", VariedSessionConfig)
