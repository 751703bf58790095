"""Names of the last version on the command line and in config files: taken, with a line that names the new one."""

import re
import warnings
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

import pytest

from jointattn_mj import Development, Session
from jointattn_mj.cli.old_names import with_names_of_today
from jointattn_mj.options import FLAT, GOES, TOP_LEVEL, Checked, RenamedWarning, Share

pytestmark = pytest.mark.integration


@dataclass(frozen=True)
class Inner(Checked):
    gain: Share = 0.5
    steady: bool = False
    shared: Annotated[Share, TOP_LEVEL] = 0.0
    parts: tuple[Literal["head", "hand"], ...] = ()

    RENAMED: ClassVar = {"place_gain": "gain", "still": "steady", "common": "shared"}
    OLD_CHOICES: ClassVar = {"parts": {"skull": "head"}}


@dataclass(frozen=True)
class Outer(Checked):
    agent: Inner = field(default_factory=Inner)
    source: Literal["state", "pixels"] = "pixels"

    RENAMED: ClassVar = {"mind": "agent", "perception": "source"}
    OLD_CHOICES: ClassVar = {"source": {"truth": "state"}}


def command(config: Annotated[Outer, FLAT]) -> None:
    """Do nothing."""


CASES = {
    "--mind.gain 0.1": "--agent.gain 0.1",
    "--agent.place-gain=0.1": "--agent.gain=0.1",
    "--mind.place_gain 0.1": "--agent.gain 0.1",
    "--mind.no-still": "--agent.no-steady",
    "--common 1": "--shared 1",
    "--source truth": "--source state",
    "--perception=truth": "--source=state",
    "--mind.parts skull hand skull": "--agent.parts head hand head",
    "truth --agent.parts truth": None,
    "--agent.gain 0.1 --source state --unknown.gain x --no-steady": None,
}


@pytest.mark.parametrize(("typed", "expected"), CASES.items())
def test_words(typed, expected):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        words = with_names_of_today(typed.split(), command)
    assert " ".join(words) == (expected or typed)
    assert bool(caught) == (expected is not None)
    assert all(issubclass(warning.category, RenamedWarning) for warning in caught)


def test_from_python():
    with pytest.warns(RenamedWarning) as caught:
        made = Outer(mind=Inner(place_gain=0.1, parts=("skull",)), perception="truth")
    assert made == Outer(Inner(gain=0.1, parts=("head",)), "state")
    said = [str(warning.message) for warning in caught]
    assert f"Outer.mind is now called agent{GOES}" in said
    assert f"Outer.source 'truth' is now called 'state'{GOES}" in said
    assert len(said) == 5
    with pytest.raises(TypeError, match="given twice"):
        Outer(mind=Inner(), agent=Inner())


def test_a_world_of_the_last_version(jointattn, tmp_path):
    file, text = tmp_path / "config.yaml", "world: rendered, mode: {}, steps: 3, mind: {{history: made}}"
    for world, mode in (("rendered", "turns"), ("realtime", "realtime")):
        file.write_text(f"config: {{{text.format(mode)}}}")
        outcome = jointattn("develop", world, "--config", file, "--out", "/proc/nowhere")
        *warned, refused = outcome.err.splitlines()
        assert outcome.code == 2 and "/proc/nowhere" in refused
        (line,) = warned
        assert "old names: mode is left out; mind is now agent; agent.history 'made' is now 'since_creation'" in line


SHORT = ("--minutes", 0.02, "--robot.familiarise.minutes", 0.02)


def test_a_session(jointattn, tmp_path):
    old = ("--perception", "truth", "--truth.face-noise-px", 1, "--world.behaviour.rest-place", 1.2, 0.3, 0.75)
    outcome = jointattn("session", *SHORT, *old, "--out", tmp_path)
    assert outcome.code == 0
    assert outcome.err == (
        "jointattn: warning: old names: --perception truth is now --perception state; "
        "--truth.face-noise-px is now --state.face-noise-px; "
        "--world.behaviour.rest-place is now --world.behaviour.rest-location; they go with the next version\n"
    )
    text = (tmp_path / "config.yaml").read_text()
    assert "perception: state" in text and "face_noise_px: 1.0" in text


@pytest.fixture(scope="module")
def file(jointattn, tmp_path_factory):
    out = tmp_path_factory.mktemp("first")
    outcome = jointattn("session", *SHORT, "--perception", "state", "--seed", 3, "--no-motion-cues", "--out", out)
    assert (outcome.code, outcome.err) == (0, "")
    return out / "config.yaml"


class TestConfigFile:
    def test_the_same_again(self, jointattn, file, tmp_path):
        for option in (("--config", file), (f"--config={file}",)):
            out = tmp_path / str(len(option))
            outcome = jointattn("session", *option, "--out", out)
            assert (outcome.code, outcome.err) == (0, "")
            assert (out / "config.yaml").read_bytes() == file.read_bytes()
            assert (out / "frames.parquet").read_bytes() == (file.parent / "frames.parquet").read_bytes()

    def test_options_override_it(self, jointattn, file, tmp_path):
        outcome = jointattn("session", "--seed", 4, "--config", file, "--motion-cues", "--out", tmp_path)
        assert (outcome.code, outcome.err) == (0, "")
        expected = file.read_text().replace("seed: 3", "seed: 4").replace("motion_cues: false", "motion_cues: true")
        assert (tmp_path / "config.yaml").read_text() == expected

    def test_of_the_last_version(self, jointattn, file, tmp_path):
        text = file.read_text().replace("perception: state", "perception: truth")
        old = tmp_path / "old.yaml"
        old.write_text(re.sub(r"^  state:", "  truth:", text, flags=re.M))
        outcome = jointattn("session", "--config", old, "--out", tmp_path / "out")
        assert outcome.code == 0
        assert (tmp_path / "out" / "config.yaml").read_bytes() == file.read_bytes()
        assert outcome.err == (
            "jointattn: warning: old names: truth is now state; perception 'truth' is now 'state'; "
            "they go with the next version\n"
        )

    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            ("minutes:", "minuts:", ("no option 'minuts' (perhaps you meant 'minutes')",)),
            ("seed: 3", "seed: -3", ("seed: expected a whole number", "got -3")),
            ("success: either", "success: landed", ("success", "perhaps you meant 'landing'")),
            ("config:", "confi:", ("no config.yaml of a run",)),
        ],
    )
    def test_what_it_may_not_say(self, jointattn, file, tmp_path, old, new, words):
        wrong = tmp_path / "wrong.yaml"
        wrong.write_text(file.read_text().replace(old, new, 1))
        outcome = jointattn("session", "--config", wrong, "--out", tmp_path / "out")
        assert outcome.code == 2
        assert outcome.err.count("\n") == 1
        for word in (str(wrong), *words):
            assert word in outcome.err
        assert not (tmp_path / "out").exists()

    @pytest.mark.parametrize(
        ("arguments", "text", "words"),
        [
            ("develop", "{world: rendered, maps: discrete}", "is of a run of develop rendered; this is develop table"),
            ("develop rendered", "{world: table}", "is of a run of develop table; this is develop rendered"),
            ("develop rendered", "{world: rendered, mode: realtime}", "is of a run of develop realtime; this is "),
            ("develop realtime", "{world: rendered, mode: turns}", "is of a run of develop rendered; this is "),
            ("session", "{world: table}", "is of a run of develop table; this is session"),
            ("session", "{video: a.mp4}", "is of a run of perceive; this is session"),
            ("perceive a.mp4", "{world: {}, robot: {}}", "is of a run of session; this is perceive"),
        ],
    )
    def test_of_another_command(self, jointattn, tmp_path, arguments, text, words):
        file = tmp_path / "config.yaml"
        file.write_text(f"config: {text}\n")
        outcome = jointattn(*arguments.split(), "--config", file, "--out", tmp_path / "out")
        assert (outcome.code, outcome.out) == (2, "")
        assert outcome.err.startswith(f"jointattn: {file} {words}") and outcome.err.count("\n") == 1

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (("session", "--config"), "expects a file"),
            (("session", "--config", "nowhere.yaml"), "cannot read nowhere.yaml"),
            (("play", "follow", "--agent", "zero", "--config", "a.yaml"), "play takes no --config"),
        ],
    )
    def test_no_file(self, jointattn, arguments, words):
        outcome = jointattn(*arguments)
        assert outcome.code == 2
        assert words in outcome.err


def test_an_old_name_from_python_is_told_of_once():
    for make, name in (
        (lambda: Development("fast", mind={}), "mind is now called agent"),
        (lambda: Session(perception="truth"), r"^Session.perception 'truth' is now called 'state'"),
        (lambda: Session(world={"behaviour": {"rest_place": (1.0, 0.4, 0.8)}}), "rest_place is now called"),
    ):
        with pytest.warns(RenamedWarning, match=name) as told:
            make()
        assert len(told) == 1
