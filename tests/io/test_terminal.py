"""Streams that cannot be written, and signals that end a command."""

import io
import os
import signal
import subprocess
import sys
import time

import pytest

from jointattn_mj.io.terminal import Unbroken, stopped_like_ctrl_c, unbroken_streams


class Full(io.StringIO):
    def write(self, text):
        raise OSError(28, "No space left on device")


class TestUnbroken:
    def test_written_as_it_is(self):
        stream = io.StringIO()
        out = Unbroken(stream)
        print("a line", file=out, flush=True)
        assert stream.getvalue() == "a line\n"
        assert (out.trouble, out.isatty(), out.encoding) == (None, False, stream.encoding)

    @pytest.mark.parametrize("broken", ["full", "closed"])
    def test_what_cannot_be_written_is_lost(self, broken):
        stream = Full() if broken == "full" else io.StringIO()
        if broken == "closed":
            stream.close()
        out = Unbroken(stream)
        for _ in range(2):
            print("a line", file=out, flush=True)
        assert out.isatty() is False
        assert out.trouble is not None

    def test_streams_are_put_back(self, monkeypatch):
        full = Full()
        monkeypatch.setattr(sys, "stdout", full)
        with unbroken_streams() as output:
            print("lost")
        assert sys.stdout is full
        assert output.trouble.errno == 28

    def test_no_stream_at_all(self, monkeypatch):
        """Python has none where a shell has closed it; libraries ask for its encoding."""
        monkeypatch.setattr(sys, "stdout", None)
        with unbroken_streams() as output:
            print("lost", sys.stdout.encoding)
        assert (sys.stdout, output.trouble) == (None, None)


class TestStops:
    @pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
    def test_are_one(self, number, monkeypatch):
        """The first one is KeyboardInterrupt; one more during the orderly end ends the process."""
        ended = []
        monkeypatch.setattr(os, "_exit", ended.append)
        kept = {stop: signal.getsignal(stop) for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
        try:
            with pytest.raises(KeyboardInterrupt), stopped_like_ctrl_c():
                os.kill(os.getpid(), number)
            os.kill(os.getpid(), number)
            assert ended == [130]
        finally:
            for stop, handler in kept.items():
                signal.signal(stop, handler)

    def test_what_is_ignored_stays_ignored(self):
        """nohup starts a program so."""
        kept = signal.signal(signal.SIGHUP, signal.SIG_IGN)
        try:
            with stopped_like_ctrl_c():
                os.kill(os.getpid(), signal.SIGHUP)
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        finally:
            signal.signal(signal.SIGHUP, kept)

    def test_handlers_are_put_back(self):
        before = signal.getsignal(signal.SIGTERM)
        with stopped_like_ctrl_c():
            assert signal.getsignal(signal.SIGTERM) is not before
        assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_that_python_discards_comes_again(number):
    class Finalised:
        def __del__(self):
            os.kill(os.getpid(), number)
            time.sleep(1)

    hook = sys.unraisablehook
    with pytest.raises(KeyboardInterrupt), stopped_like_ctrl_c():
        Finalised()
        time.sleep(30)
    assert sys.unraisablehook is hook


def test_an_interruption_in_code_from_text_ends_like_another(tmp_path):
    """As in a dataclass that is being made; ``python -m`` would end by the signal after it."""
    (tmp_path / "program.py").write_text(
        "import sys\n"
        "from jointattn_mj.io.terminal import INTERRUPTED, stopped_like_ctrl_c\n"
        "try:\n"
        "    with stopped_like_ctrl_c():\n"
        "        exec('raise KeyboardInterrupt')\n"
        "except KeyboardInterrupt:\n"
        "    sys.exit(INTERRUPTED)\n"
    )
    program = [sys.executable, "-m", "program"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    assert subprocess.run(program, env=environment).returncode == 130
