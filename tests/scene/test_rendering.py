"""Images from any thread, and one line in processes that cannot render."""

import copy
import gc
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from dm_control.mujoco import Physics
from dm_control.mujoco.wrapper import MjModel

from jointattn_mj.errors import GLError
from jointattn_mj.scene.rendering import RenderingPhysics
from jointattn_mj.scene.world import World, WorldConfig
from jointattn_mj.tasks import load

pytestmark = pytest.mark.integration


@pytest.fixture
def elsewhere():
    """Runs a function in another thread, and gives back what it returns."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        yield lambda act: pool.submit(act).result(timeout=60)


def follow(seed: int = 0):
    return load("joint_attention", "follow", task_kwargs={"random": seed})


def images(environment, steps: int = 5) -> np.ndarray:
    return np.array([environment.step(np.zeros(2)).observation["camera"] for _ in range(steps)])


def test_made_here_and_stepped_there(elsewhere):
    environment, reference = follow(), follow()
    environment.reset(), reference.reset()
    expected = images(reference, 10)
    np.testing.assert_array_equal(elsewhere(lambda: images(environment)), expected[:5])
    np.testing.assert_array_equal(images(environment), expected[5:])
    side = environment.physics.render(240, 320, camera_id="third_person")
    np.testing.assert_array_equal(
        elsewhere(lambda: environment.physics.render(240, 320, camera_id="third_person")), side
    )
    environment.close(), reference.close()


def test_first_rendered_there_and_closed_here(elsewhere, capfd):
    environment = follow()
    elsewhere(environment.reset)
    here = environment.step(np.zeros(2)).observation["camera"]
    assert here.std() > 10
    environment.close()
    another = follow()
    another.reset()
    elsewhere(another.close)
    forgotten = [follow()]
    forgotten[0].reset()
    elsewhere(forgotten.clear)
    gc.collect()
    assert "Traceback" not in capfd.readouterr().err


def test_several_threads_with_an_environment_each():
    def live(seed):
        environment = follow(seed)
        environment.reset()
        visible = images(environment, 15)
        environment.close()
        return visible

    with ThreadPoolExecutor(max_workers=3) as pool:
        together = list(pool.map(live, (1, 2, 3)))
    for seed, visible in zip((1, 2, 3), together, strict=True):
        np.testing.assert_array_equal(visible, live(seed))


def test_beside_contexts_of_dm_control(elsewhere):
    """Which leave theirs current in the thread, and have to find that it is not any more."""
    world = World.build(WorldConfig(), np.random.SeedSequence(0))
    plain = Physics.from_model(MjModel(copy.copy(world.model)))
    plain.data.qpos[:] = world.data.qpos
    plain.data.mocap_pos[:] = world.data.mocap_pos
    mujoco.mj_forward(plain.model.ptr, plain.data.ptr)
    expected = world.image().copy()
    for _ in range(3):
        np.testing.assert_array_equal(plain.render(240, 320, camera_id="robot/eye"), expected)
        world._image = None
        np.testing.assert_array_equal(world.image(), expected)
        world._image = None
        np.testing.assert_array_equal(elsewhere(world.image), expected)
    plain.free(), world.close()


def test_what_cannot_be_opened_is_one_line(monkeypatch, capfd):
    """As with a display that refuses: nothing is left half made, which would complain when it is thrown away."""
    physics = RenderingPhysics.from_xml_string("<mujoco/>")

    def refuse(*arguments):
        raise RuntimeError("no OpenGL")

    with monkeypatch.context() as patched:
        patched.setattr(mujoco, "MjrContext", refuse)
        with pytest.raises(GLError, match=r"(?s)no OpenGL.*apt-get"):
            physics.render(24, 32)
    gc.collect()
    assert capfd.readouterr().err == ""
    assert physics.render(24, 32).shape == (24, 32, 3)
    physics.free()


FORKED = """
import gc, multiprocessing, os, sys
import numpy as np
from jointattn_mj.errors import GLError
from jointattn_mj.tasks import load

def follow(camera):
    return load("joint_attention", "follow", task_kwargs={"random": 0, "camera": camera})

environment = follow(True)
environment.reset()

def child():
    for act in (lambda: environment.step(np.zeros(2)), lambda: follow(True).reset()):
        try:
            act()
        except GLError as error:
            print(error, flush=True)
    blind = follow(False)
    blind.reset()
    blind.step(np.zeros(2)), blind.close(), environment.close()
    print("blind", flush=True)

process = multiprocessing.get_context("fork").Process(target=child)
process.start()
process.join(60)
print("ended with", process.exitcode, flush=True)
if not os.fork():
    environment = None
    gc.collect()
    sys.exit()
print("and with", os.waitpid(-1, 0)[1])
print("still", environment.step(np.zeros(2)).observation["camera"].std() > 10)
"""


def test_a_forked_process_says_so_and_leaves():
    """It neither hangs nor dies; whoever it was forked from renders on."""
    quiet = ("-W", "ignore::DeprecationWarning")  # Python 3.12 and later warn of forks beside threads
    done = subprocess.run([sys.executable, *quiet, "-c", FORKED], capture_output=True, text=True, timeout=120)
    lines = done.stdout.splitlines()
    assert all("forked" in line and "spawn" in line for line in lines[:2])
    assert lines[2:] == ["blind", "ended with 0", "and with 0", "still True"]
    assert (done.returncode, done.stderr) == (0, "")
