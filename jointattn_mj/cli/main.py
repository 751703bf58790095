"""The command line, ``jointattn``. What a command needs is imported when it is asked for."""

import io
import json
import os
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from typing import Annotated, Any

import tyro

from jointattn_mj.cli.usage import complaint, without_class
from jointattn_mj.errors import (
    CheckpointError,
    ConfigError,
    ExtraError,
    FootageError,
    JointAttnError,
    OutputError,
    SeriesError,
)
from jointattn_mj.io.terminal import INTERRUPTED, stopped_like_ctrl_c, unbroken_streams
from jointattn_mj.options import meant, shown

BAD_USAGE, FAILED = 2, 1
LESS = {
    "session": "fewer minutes",
    "develop": "fewer steps or minutes",
    "perceive": "a shorter video",
    "measure": "fewer surrogates, or a shorter file",
    "discover": "fewer surrogates or events, or a shorter file",
    "benchmark": "fewer seconds",
    "experiment": "fewer jobs at once",
    "play": "a shorter episode",
}
"""What to ask for where memory is short."""
TRACEBACK = "JOINTATTN_TRACEBACK"
"""Environment variable: 1 shows the traceback of what nobody had foreseen."""


def main(arguments: list[str] | None = None) -> None:
    """Run a sub-command. Exits with 2 where what was asked for cannot be done, 1 where it failed, 130 when interrupted,
    and with nothing else; what is wrong is said in one line."""
    given = sys.argv[1:] if arguments is None else arguments
    with unbroken_streams() as output:
        code = _run(given)
        output.flush()
        trouble = output.trouble
        if trouble is not None and not isinstance(trouble, BrokenPipeError):  # who reads no further needs no message
            _say(f"cannot write to the standard output: {getattr(trouble, 'strerror', None) or trouble}")
            code = code or FAILED
    if code:
        sys.exit(code)


def _run(arguments: list[str]) -> int:
    """The exit code of a command line."""
    try:
        with stopped_like_ctrl_c():
            _parse(arguments)()
        return 0
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else FAILED if stop.code else 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except (ConfigError, OutputError, CheckpointError, SeriesError, FootageError, ExtraError) as error:
        _say(str(error))
        return BAD_USAGE
    except JointAttnError as error:
        _say(str(error))
    except MemoryError as error:
        less = LESS.get(arguments[0] if arguments else "", "less")
        _say(f"this machine has too little memory{f' ({error})' if str(error) else ''}; ask for {less}")
    except OSError as error:
        _say(f"{error.filename}: {error.strerror}" if error.filename is not None else str(error))
    except Exception as error:
        _say(_unforeseen(error))
    return FAILED


def _unforeseen(error: Exception) -> str:
    """One line for a fault of this program; the traceback is kept in a file, or shown where that is asked for."""
    told = "".join(traceback.format_exception(error))
    where = f"{TRACEBACK}=1 shows where"
    if os.environ.get(TRACEBACK):
        print(told, end="", file=sys.stderr)
        where = "its traceback stands above"
    else:
        try:
            with tempfile.NamedTemporaryFile("w", prefix="jointattn-", suffix=".txt", delete=False) as file:
                file.write(f"{sys.argv}\n{told}")
            where = f"its traceback is in {file.name}"
        except OSError:
            pass
    said = f"{type(error).__name__}: {' '.join(str(error).split())[:300]}".removesuffix(": ")
    return f"{said}. This is a fault of jointattn; please report it, {where}"


def _say(message: str) -> None:
    print(f"jointattn: {' '.join(message.split())}", file=sys.stderr)


def _parse(arguments: list[str]) -> Callable[[], None]:
    """The command that the arguments ask for; bad usage ends in one line instead of tyro's boxes."""
    if arguments[:1] == ["develop"]:
        from jointattn_mj.cli.develop import with_world

        arguments = with_world(arguments)
    said = io.StringIO()
    asked = [arguments[0]] if arguments and arguments[0] in COMMANDS else list(COMMANDS)
    if arguments and arguments[0] not in COMMANDS and not arguments[0].startswith("-"):
        known = ", ".join(COMMANDS)
        _say(f"no command {shown(arguments[0])}{meant(arguments[0], COMMANDS)}; there are {known}")
        raise SystemExit(BAD_USAGE)
    try:
        with redirect_stderr(said):
            return tyro.extras.subcommand_cli_from_dict(
                {name: COMMANDS[name](arguments) for name in asked},
                prog="jointattn",
                description="A robot that learns to look where somebody else is looking, in a 3D world without humans.",
                args=arguments,
            )
    except ConfigError as error:
        _say(without_class(str(error)))
        raise SystemExit(BAD_USAGE) from error
    except SystemExit as stop:
        if stop.code == 0:
            raise
        _say(complaint(said.getvalue()))
        raise SystemExit(BAD_USAGE) from stop


def _session(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.cli.session import run_with_bar
    from jointattn_mj.gaze_following.run import SessionOptions
    from jointattn_mj.gaze_following.varied_session import VariedSessionConfig

    def session(
        config: Annotated[VariedSessionConfig, tyro.conf.arg(name="")],
        options: Annotated[SessionOptions, tyro.conf.arg(name="")],
    ) -> Callable[[], None]:
        """Let robot and caregiver live together for some minutes, and write down everything (chapter 6).

        Leaves in --out: config.yaml, summary.json, gaze_shifts.parquet (a row a shift), frames.parquet (a row a frame),
        som.png, success.png (eq. 6.9), weights.npz, checkpoint.bin, and with --video a video. --rerun FILE.rrd leaves a
        log that can be scrubbed in Rerun's viewer.
        """
        return lambda: _with_one_thread(run_with_bar, config, options)

    return session


def _develop(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.cli.develop import develop

    return develop(arguments)


def _perceive(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.cli.perceive import run_with_bar
    from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions

    def perceive(
        config: Annotated[PerceiveConfig, tyro.conf.arg(name="")],
        options: Annotated[PerceiveOptions, tyro.conf.arg(name="")],
    ) -> Callable[[], None]:
        """Watch a video of a person at a table: what the robot would perceive, and where it would look (6.3.2).

        The camera stands still, so a fixation is attention to a place in the image, and nothing turns.
        Leaves in --out: config.yaml, summary.json (with the mapping from the video to the robot's image),
        percepts.parquet (a row a frame), fixations.parquet, fixations.png, som.png, faces.parquet, overlay.mp4, and
        checkpoint.bin.
        """
        return lambda: _with_one_thread(run_with_bar, config, options)

    return perceive


def _benchmark(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.benchmarks.contingency import run_contingency_benchmark
    from jointattn_mj.benchmarks.loop import BenchmarkOptions, as_text, run_benchmark
    from jointattn_mj.benchmarks.steps import run_steps_benchmark
    from jointattn_mj.io.files import write_whole
    from jointattn_mj.io.progress import Progress

    def run(options: BenchmarkOptions) -> None:
        parts: dict[str, Callable[[], Any]] = {
            "scene": lambda: run_benchmark(options),
            "turns": lambda: run_steps_benchmark(options.blocks),
            "contingency": lambda: run_contingency_benchmark(options.blocks),
        }
        rows: dict[str, Any] = {}
        with Progress("measuring") as shown:
            for name in parts if options.what == "all" else [options.what]:
                shown.doing(f"measuring {name}")
                rows |= parts[name]().rows()
        print(as_text(rows))
        if options.out is not None:
            text = json.dumps(rows, indent=1) + "\n"
            write_whole(options.out, lambda path: path.write_text(text))

    def benchmark(options: Annotated[BenchmarkOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Measure, in one run: the closed loop beside rendering alone, the truth path, and dm_control's cartpole; turns
        from images beside rendering these; the search for contingency beside recomputation in numpy, and beside
        pyinform."""
        return lambda: _with_one_thread(run, options)

    return benchmark


def _measure(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.recordings.measure import MeasureOptions, run_measure

    def measure(options: Annotated[MeasureOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Measure how much a recorded variable says about what another does next: transfer entropy, T^C, SAC."""
        return lambda: _print_with_progress(run_measure, options)

    return measure


def _discover(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.recordings.discover import DiscoverOptions, run_discover

    def discover(options: Annotated[DiscoverOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Find which events (sensor, action) -> result in a recording are contingent, and which values carry them."""
        return lambda: _print_with_progress(run_discover, options)

    return discover


def _experiment(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.sweeps.command import ExperimentRunOptions, ListOptions, ReportOptions, do

    def experiment(
        command: Annotated[
            Annotated[ListOptions, tyro.conf.subcommand("list")]
            | Annotated[ExperimentRunOptions, tyro.conf.subcommand("run")]
            | Annotated[ReportOptions, tyro.conf.subcommand("report")],
            tyro.conf.arg(name=""),
        ],
    ) -> Callable[[], None]:
        """Try what the dissertation claims: list the claims, run them or run them on, report what came out."""
        return lambda: do(command)

    return experiment


def _view(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.cli.view import ViewOptions, view

    def command(options: Annotated[ViewOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Watch an agent in a task: in a window where there is a display, else in a browser, at an address that is
        printed and that this machine alone reaches."""
        return lambda: _with_one_thread(view, options)

    return command


def _play(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.viewing.play import PlayOptions, play

    def command(options: Annotated[PlayOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Let an agent play episodes of a task, and say what it earned: baselines for learners, with intervals.

        Leaves in --out: episodes.csv, episodes.json (with config and versions), and with --video a video.
        """
        return lambda: _with_one_thread(play, options)

    return command


COMMANDS = {
    "session": _session,
    "develop": _develop,
    "perceive": _perceive,
    "benchmark": _benchmark,
    "measure": _measure,
    "discover": _discover,
    "experiment": _experiment,
    "view": _view,
    "play": _play,
}
"""What makes each command; none is imported before it is asked for."""


def _with_one_thread(run: Callable[..., None], *arguments: Any) -> None:
    import cv2

    cv2.setNumThreads(1)  # images are small: handing them round threads costs more than it gains
    run(*arguments)


def _print_with_progress(run: Callable[..., Any], options: Any) -> None:
    from jointattn_mj.io.progress import Progress

    with Progress("reading", options.draws, "surrogates") as shown:
        result = run(options, lambda done: shown.add(done, "drawing"))
    print(result.text())


if __name__ == "__main__":
    main()
