"""What is said while a run goes."""

import io

from jointattn_mj.laboratory import progress
from jointattn_mj.laboratory.progress import MOST_FAILURES, Progress, duration, rate
from jointattn_mj.laboratory.run import Tally

HALF = Tally(todo=10, stored=3, done=4, running=2, seconds={("a", "b"): (4, 40.0)})
HALF.left["a", "b"] = 6


class Screen(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_numbers_to_read():
    assert [rate(1200.0), rate(0.5), rate(0.001)] == ["1.2e+03/s", "30/min", "3.6/h"]
    assert [duration(7.4), duration(200), duration(7500)] == ["7 s", "3 min 20 s", "2 h 5 min"]


def test_a_line():
    text = Progress(io.StringIO()).state(HALF, 2, 8.0)
    assert text == "4/10 cells, 2 running, 0 failed, 30/min, 30 s left"
    assert "no worker yet" in Progress(io.StringIO()).state(Tally(todo=1), 0, 1.0)
    assert "2 deaths of workers" in Progress(io.StringIO()).state(Tally(todo=1, deaths=2), 1, 1.0)


def test_a_log_is_not_flooded():
    log = io.StringIO()
    told = Progress(log)
    told.begin(HALF, 2)
    for _ in range(50):
        told.tick(HALF, 2)
    told.end(HALF)
    assert log.getvalue().count("\n") == 2
    assert log.getvalue().startswith("10 cells to compute, 3 stored already\n")


def test_a_screen_line_changes_in_place(monkeypatch):
    monkeypatch.setattr(progress, "SCREEN_S", 0.0)
    screen = Screen()
    told = Progress(screen)
    told.begin(HALF, 2)
    told.tick(HALF, 2)
    told.tick(HALF, 2)
    assert screen.getvalue().count("\r") == 2
    told.end(HALF)
    assert screen.getvalue().endswith("s\n")


def test_failures_are_listed_but_not_without_end():
    tally = Tally(todo=50, failed=[(f"cell {k}", "ValueError: no", f"do {k}") for k in range(MOST_FAILURES + 3)])
    log = io.StringIO()
    Progress(log).end(tally)
    assert "  cell 0: ValueError: no\n    alone: do 0\n" in log.getvalue()
    assert log.getvalue().count("alone:") == MOST_FAILURES
    assert "and 3 more" in log.getvalue()
