"""Seen live: agents, what is shown of them, the browser's viewer and its interface, and how it ends."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from jointattn_mj.cli.main import main
from jointattn_mj.cli.view import HERE, ViewOptions
from jointattn_mj.errors import ConfigError
from jointattn_mj.scene import gl
from jointattn_mj.tasks import load
from jointattn_mj.tasks.agents import AGENTS
from jointattn_mj.video.paint import GREEN
from jointattn_mj.viewing.guard import names_of, refusal
from jointattn_mj.viewing.show import Show, in_real_time

pytestmark = pytest.mark.integration

needs_gl = pytest.mark.skipif(not any(map(gl.available, gl.LIBRARIES)), reason="no OpenGL library to render with")
needs_mjviser = pytest.mark.skipif(find_spec("mjviser") is None, reason="no mjviser")


def show_of(task: str, agent: str, **settings) -> Show:
    environment = load("joint_attention", task, task_kwargs={"random": 0, "camera": False, **settings})
    return Show(environment, AGENTS[agent](environment, 0))


class TestAgents:
    @pytest.mark.parametrize("task", ["object_transfer", "follow", "turn_taking"])
    @pytest.mark.parametrize("agent", ["zero", "random", "oracle"])
    def test_actions_can_be_done(self, task, agent):
        environment = load("joint_attention", task, task_kwargs={"random": 0, "camera": False})
        made, spec = AGENTS[agent](environment, 0), environment.action_spec()
        timestep = environment.reset()
        for _ in range(5):
            action = np.asarray(made.act(timestep))
            assert action.shape == spec.shape
            assert (action >= spec.minimum).all()
            assert (action <= spec.maximum).all()
            timestep = environment.step(action)
        environment.close()

    def test_oracle_is_better_than_nothing(self):
        rewards = []
        for agent in ("zero", "oracle"):
            show = show_of("follow", agent)
            for _ in range(29):
                show.advance()
            rewards.append(show.reward)
        assert rewards[1] > 20 > rewards[0] + 5

    def test_random_goes_by_its_seed(self):
        environment = load("joint_attention", "follow", task_kwargs={"random": 0, "camera": False})
        first, same, other = (AGENTS["random"](environment, seed).act(environment.reset()) for seed in (1, 1, 2))
        np.testing.assert_array_equal(first, same)
        assert (first != other).any()

    @needs_gl
    def test_gaze_follower_goes_on_learning(self):
        """Another episode has another robot, with what the last one had learned."""
        show = show_of("object_transfer", "gaze_follower", camera=True, time_limit=8.0)
        before = show.robot
        for _ in range(239):
            show.advance()
        assert show.robot is before
        learned = before.weights()
        show.advance()
        assert show.episode == 2
        assert show.robot is not before
        for name, array in show.robot.weights().items():
            np.testing.assert_array_equal(array, learned[name])

    def test_gaze_follower_needs_images_in_time(self):
        with pytest.raises(ConfigError, match="object_transfer"):
            show_of("follow", "gaze_follower", camera=True)


class TestShow:
    def test_episodes(self):
        show = show_of("follow", "oracle")
        words = set()
        for _ in range(65):
            show.advance()
            words.add(show.words().split(",")[0])
        assert words == {"episode 1", "episode 2", "episode 3"}

    def test_sights_are_green_together(self):
        show = show_of("follow", "oracle")
        for _ in range(20):
            show.advance()
        assert [colour for _, colour in show.sights()] == [GREEN, GREEN]

    @needs_gl
    @pytest.mark.parametrize("task", ["object_transfer_hard", "turn_taking_hard"])
    def test_the_robots_view(self, task):
        """It changes as the head turns, and with another caregiver."""
        show = show_of(task, "oracle")
        first = show.eye().copy()
        assert first.shape == (480, 640, 3)
        assert first.std() > 20
        for _ in range(3):
            show.advance()
        later = show.eye().copy()
        assert (later != first).mean() > 0.05
        show.restart()
        assert (show.eye() != later).mean() > 0.05

    @needs_gl
    def test_percepts_are_drawn(self):
        show = show_of("object_transfer", "gaze_follower", camera=True)
        show.advance()
        with_percept, agent = show.eye().copy(), show.robot
        agent.percept = None
        assert (show.eye() != with_percept).mean() > 0.001

    def test_real_time(self):
        class Stub:
            seconds_a_step, steps = 0.02, 0

            def advance(self):
                self.steps += 1

        stub, drawn, pauses = Stub(), [], [True, True]
        started = time.perf_counter()
        in_real_time(stub, lambda: drawn.append(1), lambda: stub.steps < 10, lambda: bool(pauses and pauses.pop()))
        assert stub.steps == len(drawn) == 10
        assert time.perf_counter() - started > 0.1 + 0.15


class TestRefusal:
    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (("nothing",), ("no task 'nothing'", "object_transfer")),
            (("follow", "--agent", "gaze_follower"), ("object_transfer",)),
            (("follow", "--agent", "somebody"), ("somebody", "oracle")),
            (("follow", "--port", "70000"), ("port", "70000")),
            (("follow", "--seed", "-1"), ("seed", "-1")),
            (("follow", "--host", "192.0.2.1"), ("192.0.2.1", "--host")),
            ((), ("task",)),
        ],
        ids=["task", "agent's task", "agent", "port", "seed", "host", "nothing"],
    )
    @needs_mjviser
    def test_what_cannot_be_shown(self, capsys, arguments, words):
        with pytest.raises(SystemExit) as stop:
            main(["view", "--browser", *arguments])
        assert stop.value.code == 2
        message = capsys.readouterr().err.lower()
        for word in words:
            assert word in message

    def test_missing_package(self, monkeypatch, capsys):
        """It is asked for by name, before anything is loaded."""
        monkeypatch.delitem(sys.modules, "jointattn_mj.adapters.mjviser", raising=False)
        monkeypatch.setitem(sys.modules, "mjviser", None)
        monkeypatch.setattr("jointattn_mj.tasks.load", lambda *arguments: pytest.fail("was loaded"))
        with pytest.raises(SystemExit) as stop:
            main(["view", "follow", "--browser"])
        assert stop.value.code == 2
        assert "pip install 'jointattn-mj[view]'" in capsys.readouterr().err

    @needs_mjviser
    @pytest.mark.parametrize(("host", "warns"), [(HERE, False), ("0.0.0.0", True)])
    def test_warning(self, monkeypatch, capsys, host, warns):
        from jointattn_mj.adapters import mjviser

        class Stub:
            address = "http://somewhere"

            def __init__(self, show, host, port):
                self.host = host

            def run(self, goes_on):
                assert self.host == host

        monkeypatch.setattr(mjviser, "Browser", Stub)
        main(["view", "follow", "--browser", "--agent", "zero", "--host", host])
        out, err = capsys.readouterr()
        assert "http://somewhere" in out
        assert ("warning" in err and host in err) == warns

    def test_it_says_that_it_starts_before_anything_slow(self):
        code = """
import sys
from jointattn_mj.cli import view as view_command
view_command._serve = lambda options: print({"numpy", "mujoco", "cv2", "numba"} & set(sys.modules))
view_command.view(view_command.ViewOptions("follow", browser=True))
"""
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
        assert (done.stdout, done.stderr) == ("set()\n", "jointattn: the view of follow is starting\n")

    def test_this_machine_alone_unless_asked(self):
        assert ViewOptions("follow").host == "127.0.0.1"


def listening() -> set[str]:
    """Addresses at which something listens, as the kernel writes them."""
    rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    return {row[1] for row in rows if row[3] == "0A"}


@pytest.fixture
def served():
    """A running ``jointattn view``, and its address."""
    command = [sys.executable, "-m", "jointattn_mj.cli.main", "view", "follow_hard", "--browser", "--port", "18480"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        address = process.stdout.readline().split()[0]
        yield process, address
        if process.poll() is None:
            process.kill()


OWN = {"Upgrade": "websocket", "Host": "127.0.0.1:8080", "Origin": "http://127.0.0.1:8080"}


class TestGuard:
    @pytest.mark.parametrize(
        "change",
        [
            {},
            {"Upgrade": "WebSocket", "Host": "localhost:8080", "Origin": "http://localhost:8080"},
            {"Host": "[::1]:8080", "Origin": "http://[::1]:8080"},
            {"Host": "localhost:9000", "Origin": "http://localhost:9000"},  # through a tunnel
            {"Host": "lab:8080", "Origin": "https://lab:8080"},
            {"Upgrade": "", "Origin": ""},
            {"Upgrade": "", "Origin": "http://evil.example"},  # a link to our page
        ],
    )
    def test_own(self, change):
        assert refusal(OWN | change, {"Lab"}) is None

    @pytest.mark.parametrize(
        "change",
        [
            {"Origin": "http://evil.example"},
            {"Origin": "http://127.0.0.1:3000"},
            {"Origin": "http://127.0.0.1:8080.evil.example"},
            {"Origin": "null"},
            {"Origin": ""},
            {"Host": "evil.example:8080", "Origin": "http://evil.example:8080"},
            {"Host": "evil.example:8080", "Upgrade": ""},
            {"Host": "", "Origin": "http://"},
            {"Host": "[:8080", "Origin": "http://[:8080"},
        ],
    )
    def test_others(self, change):
        assert refusal(OWN | change, {"lab"})

    def test_names(self):
        assert names_of("127.0.0.1") == {"127.0.0.1"}
        assert names_of("0.0.0.0") == {"0.0.0.0", socket.gethostname()}


@needs_gl
@needs_mjviser
class TestServer:
    @pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="asks Linux who listens")
    def test_on_this_machine_alone_until_it_is_stopped(self, served):
        process, address = served
        port = int(address.rsplit(":", 1)[1])
        assert address.startswith("http://127.0.0.1:")
        assert {address for address in listening() if address.endswith(f":{port:04X}")} == {f"0100007F:{port:04X}"}
        with urllib.request.urlopen(address, timeout=10) as answer:
            assert answer.status == 200
            assert b"<html" in answer.read().lower()
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=15)
        assert process.returncode == 0
        assert "Traceback" not in err

    def test_own_pages_only(self, served):
        """Another page in the same browser, or a name that somebody lets point here, is refused; nothing is sent."""
        import viser
        from websockets.exceptions import InvalidStatus
        from websockets.sync.client import connect

        _, address = served
        where, protocol = address.replace("http", "ws"), [f"viser-v{viser.__version__}"]
        port = where.rsplit(":", 1)[1]
        with connect(where, origin=address, subprotocols=protocol) as own:
            assert own.recv(timeout=20)
        with connect(f"ws://localhost:{port}", origin=f"http://localhost:{port}", subprotocols=protocol) as own:
            assert own.recv(timeout=20)
        for origin in ("http://evil.example", "http://127.0.0.1:1", f"http://localhost:{port}", "null", None):
            with pytest.raises(InvalidStatus) as refused:
                connect(where, origin=origin, subprotocols=protocol)
            assert refused.value.response.status_code == 403
        with socket.create_connection(("127.0.0.1", int(port)), timeout=20) as rebound:
            rebound.sendall(f"GET / HTTP/1.1\r\nHost: evil.example:{port}\r\n\r\n".encode())
            assert b" 403 " in rebound.recv(100)

    def test_nothing_is_shared(self):
        """viser offers an address for everybody; here nobody gets one."""
        from jointattn_mj.adapters.mjviser import Browser

        browser = Browser(show_of("follow", "oracle"), HERE, 18481)
        try:
            assert browser._server.request_share_url() is None
        finally:
            browser.run(lambda: False)

    @pytest.mark.slow
    @pytest.mark.skipif(find_spec("playwright") is None or not shutil.which("chromium"), reason="no browser")
    def test_in_a_browser(self, served, tmp_path):
        """The words go on, so the show runs; the image of the robot's view is there."""
        from playwright.sync_api import sync_playwright

        _, address = served
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        with sync_playwright() as play:
            browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=flags)
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            page.goto(address)
            words = page.get_by_text("episode", exact=False).first
            words.wait_for(timeout=30_000)
            first = words.inner_text()
            page.wait_for_timeout(4000)
            assert words.inner_text() != first
            assert page.locator("img").count() >= 1
            page.screenshot(path=os.environ.get("SCREENSHOT", str(tmp_path / "view.png")))
            browser.close()


@pytest.mark.slow
@needs_gl
@pytest.mark.skipif(not shutil.which("Xvfb"), reason="no virtual display")
def test_in_a_window():
    """Where there is a display, a window; a scheduler's kind signal ends it."""
    with subprocess.Popen(["Xvfb", ":79", "-screen", "0", "640x480x24"]) as display:
        time.sleep(1)
        command = [sys.executable, "-m", "jointattn_mj.cli.main", "view", "follow"]
        environment = os.environ | {"DISPLAY": ":79"}
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
            time.sleep(12)
            assert process.poll() is None
            process.terminate()
            said, _ = process.communicate(timeout=15)
        display.terminate()
    assert (process.returncode, said) == (0, b"jointattn: the view of follow is starting\n")
