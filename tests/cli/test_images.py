"""Sessions from the state load no OpenGL library, and whatever shows something does."""

import os
import subprocess
import sys
from dataclasses import fields

import pytest

from jointattn_mj.api.session import LoggedSessionOptions
from jointattn_mj.cli.images import needs_images

LOADED = """
import sys
from jointattn_mj.cli.main import main
sys.argv = ["jointattn", *sys.argv[1:]]
main()
print(sorted({"cv2", "OpenGL.EGL", "OpenGL.osmesa"} & set(sys.modules)))
"""


@pytest.mark.parametrize(
    "words",
    [
        "session --perception state --out a",
        "session --out a --perception=state --no-video --world.scene.caregiver noa",
        "session --perception pixels --perception state",
    ],
)
def test_a_session_from_the_state_needs_none(words):
    assert not needs_images(words.split())


@pytest.mark.parametrize(
    "words",
    [
        "", "session", "session --out state", "session --perception", "session --perception state --perception=pixels",
        "session --perception state --video", "session --perception state --video-every 3",
        "session --rerun a.rrd --perception state", "session --rerun=a.rrd --perception state",
        "session --world video --perception state", "session --config config.yaml",
        "play --perception state", "develop rendered --perception state",
    ],
)  # fmt: skip
def test_whatever_may_show_something_needs_them(words):
    assert needs_images(words.split())


def test_every_option_was_considered():
    """One that shows something has to stand among those that need images."""
    assert {field.name for field in fields(LoggedSessionOptions)} == {
        "out", "resume", "video", "video_every", "checkpoint_minutes", "rerun",
    }  # fmt: skip


@pytest.mark.integration
def test_a_command_loads_what_it_uses(tmp_path):
    words = ["session", "--perception", "state", "--minutes", "0.2", "--robot.familiarise.minutes", "0.1"]
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    done = subprocess.run(
        [sys.executable, "-c", LOADED, *words, "--out", str(tmp_path / "run")],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] == "[]"
