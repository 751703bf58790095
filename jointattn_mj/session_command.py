"""``jointattn session``: a session with a bar that shows how it goes."""

import sys
from collections import deque

from tqdm import tqdm

from jointattn_mj.runner import RunOptions, run_session
from jointattn_mj.session import FRAMES_PER_MINUTE, Session
from jointattn_mj.varied_session import VariedSession, VariedSessionConfig


def run_with_bar(config: VariedSessionConfig, options: RunOptions) -> None:
    """Run the session, and say in a line what came of it; errors are :func:`runner.run_session`'s."""
    bar = tqdm(
        total=config.minutes,
        desc="getting to know the face",
        bar_format="{l_bar}{bar}| {n:.1f}/{total:g} simulated min [{elapsed}<{remaining}{postfix}]",
        disable=None,
    )

    last, counted, of_all = deque[bool](maxlen=20), 0, 0

    def progress(session: Session) -> None:
        nonlocal counted, of_all
        new = [bool(row.success) for row in session.shifts[of_all:] if row.face_to_object]
        last.extend(new)
        counted, of_all = counted + len(new), len(session.shifts)
        rate = f"success {sum(last) / len(last):.0%} of the last {len(last)}" if last else "no success yet"
        bar.set_description_str("session", refresh=False)
        bar.set_postfix_str(f"{counted} gaze shifts, {rate}", refresh=False)
        bar.update(session.frame / FRAMES_PER_MINUTE - bar.n)

    try:
        with bar:
            summary = run_session(config, options, progress, VariedSession)
    except KeyboardInterrupt:
        if (options.out / "checkpoint.bin").exists():
            print(f"jointattn: stopped; the same command with --resume goes on from {options.out}", file=sys.stderr)
        else:
            print("jointattn: stopped before the session began; nothing was written", file=sys.stderr)
        raise
    late = summary["late_rate"]
    print(
        f"{summary['gaze_shifts']} gaze shifts from the face to an object, {summary['successes']} to where "
        f"the caregiver looked ({'-' if late is None else format(late, '.0%')} over the last 6 minutes), "
        f"in {summary['wall_seconds']:.0f} s. Results: {options.out}"
    )
