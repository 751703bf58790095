"""``jointattn session``: a session that shows how it goes."""

import sys
from collections import deque

from jointattn_mj.api.session import LoggedSessionOptions, run_logged
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, SessionRun
from jointattn_mj.gaze_following.summary import LATE_MINUTES
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig, VariedSessionRun
from jointattn_mj.io.progress import Progress


def run_with_bar(config: VariedSessionConfig, options: LoggedSessionOptions) -> None:
    """Run the session, and say in a line what came of it; errors are those of :func:`run_logged`."""
    shown = Progress("getting to know the face", config.minutes, "simulated min", digits=1)

    recent, counted, of_all = deque[bool](maxlen=20), 0, 0

    def progress(session: SessionRun) -> None:
        nonlocal counted, of_all
        new = [bool(row.success) for row in session.shifts[of_all:] if row.face_to_object]
        recent.extend(new)
        counted, of_all = counted + len(new), len(session.shifts)
        rate = f"success {sum(recent) / len(recent):.0%} of the last {len(recent)}" if recent else "no success yet"
        shown.doing("session")
        shown.to(session.frame / FRAMES_PER_MINUTE, f"{counted} gaze shifts, {rate}")

    try:
        with shown:
            summary = run_logged(config, options, progress, VariedSessionRun)
    except KeyboardInterrupt:
        if (options.out / "checkpoint.bin").exists():
            print(f"jointattn: stopped; the same command with --resume goes on from {options.out}", file=sys.stderr)
        else:
            print("jointattn: stopped before the session began; nothing was written", file=sys.stderr)
        raise
    late = summary.late_success_rate
    last = f" over the last {LATE_MINUTES:g} minutes" if config.minutes > LATE_MINUTES else ""
    print(
        f"{summary.gaze_shifts} gaze shifts from the face to an object, {summary.successes} to where "
        f"the caregiver looked ({'-' if late is None else format(late, '.0%')}{last}), "
        f"in {summary.wall_seconds:.0f} s. Results: {options.out}"
    )
