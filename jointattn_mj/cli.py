"""The command line, ``jointattn``."""

import io
import json
import re
import sys
from collections.abc import Callable
from contextlib import redirect_stderr
from typing import Annotated, Any, NoReturn

import cv2
import tyro
from tqdm import tqdm

from jointattn_mj.benchmark import BenchmarkOptions, run_benchmark
from jointattn_mj.discover_command import DiscoverOptions, run_discover
from jointattn_mj.errors import CheckpointError, ConfigError, JointAttnError, OutputError, SeriesError
from jointattn_mj.measure_command import MeasureOptions, run_measure
from jointattn_mj.recording.files import write_whole
from jointattn_mj.runner import RunOptions, run_session
from jointattn_mj.session import FRAMES_PER_MINUTE, Session, SessionConfig

BAD_USAGE, FAILED, INTERRUPTED = 2, 1, 130


def main(arguments: list[str] | None = None) -> None:
    """Run a sub-command. Exits with 2 where what was asked for cannot be done, 130 when interrupted."""
    cv2.setNumThreads(1)  # pictures are small: handing them round threads costs more than it gains
    try:
        _parse(arguments)()
    except (ConfigError, OutputError, CheckpointError, SeriesError) as error:
        _leave(str(error), BAD_USAGE)
    except JointAttnError as error:
        _leave(str(error), FAILED)
    except MemoryError as error:
        _leave(f"this machine has too little memory ({error}); ask for fewer minutes", FAILED)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


def _parse(arguments: list[str] | None) -> Callable[[], None]:
    """The command that the arguments ask for; bad usage ends in one line instead of tyro's boxes."""
    said = io.StringIO()
    try:
        with redirect_stderr(said):
            return tyro.extras.subcommand_cli_from_dict(
                _commands(),
                prog="jointattn",
                description="A robot that learns to look where somebody else is looking, in a 3D world without humans.",
                args=arguments,
            )
    except SystemExit as stop:
        if stop.code == 0:
            raise
        text = re.sub(r"[\u2500-\u257f]+|\x1b\[[0-9;]*m|Error parsing \S+: ", " ", said.getvalue())
        complaint, _, help_hint = " ".join(text.split()).partition("For full helptext, ")
        _leave(f"{complaint.strip()} ({help_hint.strip() or 'see jointattn --help'})", BAD_USAGE)


def _leave(message: str, code: int) -> NoReturn:
    print(f"jointattn: {message}", file=sys.stderr)
    sys.exit(code)


def _commands() -> dict[str, Callable[..., Any]]:
    def session(
        config: Annotated[SessionConfig, tyro.conf.arg(name="")],
        options: Annotated[RunOptions, tyro.conf.arg(name="")],
    ) -> Callable[[], None]:
        """Let robot and caregiver live together for some minutes, and write down everything (chapter 6).

        Leaves in --out: config.yaml, summary.json, gaze_shifts.parquet (a row a shift), frames.parquet (a row a frame),
        som.png, success.png (eq. 6.9), weights.npz, checkpoint.bin, and with --video a video.
        """
        return lambda: _run_with_bar(config, options)

    def benchmark(options: Annotated[BenchmarkOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Measure the closed loop beside rendering alone, the truth path, and dm_control's cartpole, in one run."""
        return lambda: _benchmark(options)

    def measure(options: Annotated[MeasureOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Measure how much a recorded variable says about what another does next: transfer entropy, T^C, SAC."""
        return lambda: _print_with_bar(run_measure, options)

    def discover(options: Annotated[DiscoverOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Find which events (sensor, action) -> result in a recording are contingent, and which values carry them."""
        return lambda: _print_with_bar(run_discover, options)

    return {"session": session, "benchmark": benchmark, "measure": measure, "discover": discover}


def _run_with_bar(config: SessionConfig, options: RunOptions) -> None:
    bar = tqdm(
        total=config.minutes,
        desc="getting to know the face",
        bar_format="{l_bar}{bar}| {n:.1f}/{total:g} simulated min [{elapsed}<{remaining}{postfix}]",
        disable=None,
    )

    def progress(session: Session) -> None:
        recent = [row.success for row in session.shifts if row.face_to_object]
        last = recent[-20:]
        rate = f"success {sum(map(bool, last)) / len(last):.0%} of the last {len(last)}" if last else "no success yet"
        bar.set_description_str("session", refresh=False)
        bar.set_postfix_str(f"{len(recent)} gaze shifts, {rate}", refresh=False)
        bar.update(session.frame / FRAMES_PER_MINUTE - bar.n)

    try:
        with bar:
            summary = run_session(config, options, progress)
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


def _print_with_bar(run: Callable[..., Any], options: Any) -> None:
    with tqdm(total=options.draws, desc="surrogates", leave=False, disable=None) as bar:
        result = run(options, bar.update)
    print(result.text())


def _benchmark(options: BenchmarkOptions) -> None:
    result = run_benchmark(options)
    print(result.text())
    if options.out is not None:
        text = json.dumps(result.rows(), indent=1) + "\n"
        write_whole(options.out, lambda path: path.write_text(text))


if __name__ == "__main__":
    main()
