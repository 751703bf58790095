"""What is said while a run goes."""

import io
import time

import numpy as np
from numba import njit

import jointattn_mj.io.progress
from jointattn_mj.io.progress import COMPILING, duration, told_of_compiling
from jointattn_mj.io.progress import Progress as Shown
from jointattn_mj.sweeps import progress
from jointattn_mj.sweeps.progress import MOST_FAILURES, SweepProgress, rate
from jointattn_mj.sweeps.run import Tally

HALF = Tally(todo=10, stored=3, done=4, running=2, seconds={("a", "b"): (4, 40.0)})
HALF.left["a", "b"] = 6


class Screen(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_numbers_to_read():
    assert [rate(1200.0), rate(0.5), rate(0.001)] == ["1.2e+03/s", "30/min", "3.6/h"]
    assert [duration(7.4), duration(200), duration(7500)] == ["7 s", "3 min 20 s", "2 h 5 min"]
    assert [duration(20 * 86400), duration(4e9)] == ["20 days", "126 years"]


def test_a_line():
    text = SweepProgress(io.StringIO()).state(HALF, 2, 8.0)
    assert text == "4/10 trials, 2 running, 0 failed, 30/min, 30 s left"
    assert "no worker yet" in SweepProgress(io.StringIO()).state(Tally(todo=1), 0, 1.0)
    assert "2 deaths of workers" in SweepProgress(io.StringIO()).state(Tally(todo=1, deaths=2), 1, 1.0)


def test_a_log_is_not_flooded():
    log = io.StringIO()
    told = SweepProgress(log)
    told.begin(HALF, 2)
    for _ in range(50):
        told.tick(HALF, 2)
    told.end(HALF)
    assert log.getvalue().count("\n") == 2
    assert log.getvalue().startswith("10 trials to compute, 3 stored already\n")


def test_a_screen_line_changes_in_place(monkeypatch):
    monkeypatch.setattr(progress, "SCREEN_S", 0.0)
    screen = Screen()
    told = SweepProgress(screen)
    told.begin(HALF, 2)
    told.tick(HALF, 2)
    told.tick(HALF, 2)
    assert screen.getvalue().count("\r") == 2
    told.end(HALF)
    assert screen.getvalue().endswith("s\n")


def test_failures_are_listed_but_not_without_end():
    tally = Tally(todo=50, failed=[(f"cell {k}", "ValueError: no", f"do {k}") for k in range(MOST_FAILURES + 3)])
    log = io.StringIO()
    SweepProgress(log).end(tally)
    assert "  cell 0: ValueError: no\n    alone: do 0\n" in log.getvalue()
    assert log.getvalue().count("alone:") == MOST_FAILURES
    assert "and 3 more" in log.getvalue()


class TestLog:
    """Where there is no terminal."""

    def test_lines(self):
        shown = Shown("session", 26, "simulated min", digits=1, stream=io.StringIO())
        assert shown.line(12) == "session, 0.0 of 26.0 simulated min, 12 s so far"
        shown.to(6.5, "9 gaze shifts")
        assert shown.line(60) == "session, 6.5 of 26.0 simulated min, 3 min 0 s left, 9 gaze shifts, 1 min 0 s so far"
        shown.to(0.1)
        assert "left" not in shown.line(60)  # from so little nothing is known
        shown._compiling_s = 40
        shown.to(6.5)
        assert shown.line(100).startswith("session, 6.5 of 26.0 simulated min, 3 min 0 s left")
        shown.to(26)
        assert shown.line(240).startswith("writing results, 26.0 of 26.0")
        shown.doing("drawing")
        assert Shown("reading", stream=io.StringIO()).line(5) == "reading, 5 s so far"

    def test_somebody_says_that_it_goes_on(self, monkeypatch):
        """Also while nothing is told: a line first after some seconds, and then now and then."""
        monkeypatch.setattr(jointattn_mj.io.progress, "FIRST_S", 0.02)
        monkeypatch.setattr(jointattn_mj.io.progress, "LINE_S", 0.03)
        monkeypatch.delenv(jointattn_mj.io.progress.QUIET)
        log = io.StringIO()
        with Shown("waiting", stream=log):
            until = time.monotonic() + 20
            while log.getvalue().count("\n") < 3 and time.monotonic() < until:
                time.sleep(0.01)
        assert log.getvalue().splitlines()[2].startswith("waiting, ")
        said = log.getvalue()
        time.sleep(0.1)
        assert log.getvalue() == said

    def test_a_short_command_says_nothing(self):
        log = io.StringIO()
        with Shown("short", 3, stream=log) as shown:
            shown.add(3)
        assert log.getvalue() == ""


class TestBar:
    """On a terminal."""

    def test_it_tells_how_far(self):
        screen = Screen()
        with Shown("playing", 4, "episodes", stream=screen) as shown:
            shown.add()
            shown.say("a line above it")
            shown.to(4, "all well")
        assert "a line above it\n" in screen.getvalue()
        assert "4/4 episodes" in screen.getvalue()
        assert "all well" in screen.getvalue()
        assert "playing: 100%" in screen.getvalue()

    def test_a_screen_that_goes_away_ends_nothing(self):
        class Gone(Screen):
            def write(self, text):
                raise OSError(5, "Input/output error")

        with Shown("playing", 4, "episodes", stream=Gone()) as shown:
            shown.add()
            shown.say("lost")

    def test_compiling_is_announced(self):
        """What is in the cache, or compiled already, is not."""

        @njit
        def inner(x):
            return x + 1

        @njit
        def outer(x):
            return inner(x) * 2

        said = []
        for _ in range(2):
            screen = Screen()
            with Shown("life", 4, stream=screen):
                assert outer(np.int64(1)) == 4
            said.append(COMPILING in screen.getvalue())
        assert said == [True, False]


def test_compiling_is_told_in_a_log(monkeypatch):
    @njit
    def outer(x):
        return x + 2

    shown, during = Shown("life", stream=io.StringIO()), []
    told = shown._compiling
    monkeypatch.setattr(shown, "_compiling", lambda: (told(), during.append(shown.line(1)))[0])
    with shown:
        assert outer(np.int64(1)) == 3
    assert during == [f"{COMPILING}, 1 s so far"]
    assert shown.line(1) == "life, 1 s so far"


def test_compiling_is_told_once_and_only_when_it_happens():
    @njit
    def inner(x):
        return x + 1

    @njit
    def outer(x):
        return inner(x) * 2

    told = []

    def begin():
        told.append("begins")
        return lambda: told.append("is over")

    for _ in range(2):
        with told_of_compiling(begin):
            assert outer(np.int64(1)) == 4
    assert told == ["begins", "is over"]
