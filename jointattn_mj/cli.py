"""The command line, ``jointattn``. What a command needs is imported when it is asked for."""

import io
import json
import re
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from typing import Annotated, Any, NoReturn

import tyro

from jointattn_mj.errors import (
    CheckpointError,
    ConfigError,
    ExtraError,
    FootageError,
    JointAttnError,
    OutputError,
    SeriesError,
)

BAD_USAGE, FAILED, INTERRUPTED = 2, 1, 130


def main(arguments: list[str] | None = None) -> None:
    """Run a sub-command. Exits with 2 where what was asked for cannot be done, 130 when interrupted."""
    try:
        _parse(sys.argv[1:] if arguments is None else arguments)()
    except (ConfigError, OutputError, CheckpointError, SeriesError, FootageError, ExtraError) as error:
        _leave(str(error), BAD_USAGE)
    except JointAttnError as error:
        _leave(str(error), FAILED)
    except MemoryError as error:
        _leave(f"this machine has too little memory ({error}); ask for fewer minutes", FAILED)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


def _parse(arguments: list[str]) -> Callable[[], None]:
    """The command that the arguments ask for; bad usage ends in one line instead of tyro's boxes."""
    said = io.StringIO()
    asked = [arguments[0]] if arguments and arguments[0] in COMMANDS else list(COMMANDS)
    try:
        with redirect_stderr(said):
            return tyro.extras.subcommand_cli_from_dict(
                {name: COMMANDS[name](arguments) for name in asked},
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


def _session(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.runner import RunOptions
    from jointattn_mj.session_command import run_with_bar
    from jointattn_mj.varied_session import VariedSessionConfig

    def session(
        config: Annotated[VariedSessionConfig, tyro.conf.arg(name="")],
        options: Annotated[RunOptions, tyro.conf.arg(name="")],
    ) -> Callable[[], None]:
        """Let robot and caregiver live together for some minutes, and write down everything (chapter 6).

        Leaves in --out: config.yaml, summary.json, gaze_shifts.parquet (a row a shift), frames.parquet (a row a frame),
        som.png, success.png (eq. 6.9), weights.npz, checkpoint.bin, and with --video a video. --rerun FILE.rrd leaves a
        log that can be scrubbed in Rerun's viewer.
        """
        return lambda: _with_one_thread(run_with_bar, config, options)

    return session


def _develop(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.develop_command import run_with_bar
    from jointattn_mj.development import DevelopConfig, DevelopOptions, mode_in, preset_in, world_in

    chosen = DevelopConfig.of(preset_in(arguments))
    if world_in(arguments) == "rendered":
        from jointattn_mj.realtime_development import RealtimeDevelopConfig
        from jointattn_mj.rendered_development import RenderedDevelopConfig

        kind = RealtimeDevelopConfig if mode_in(arguments) == "realtime" else RenderedDevelopConfig
        chosen = kind.of(preset_in(arguments, default="fast"))

    def develop(
        options: Annotated[DevelopOptions, tyro.conf.arg(name="")],
        config: Annotated[DevelopConfig, tyro.conf.arg(name="")] = chosen,
    ) -> Callable[[], None]:
        """Let a robot find what is contingent, make modules of it, and so develop joint attention (chapters 4 and 5).

        Leaves in --out: config.yaml, summary.json (modules in their order, what they mean, behaviour by phases),
        sac.png (Fig. 5.3), behaviour.png (Fig. 5.5), maps.png, module_1.csv and so on (the learned maps),
        turns.parquet (a row a turn), contingency.parquet, checkpoint.bin, and with --video a video. The defaults below
        are those of --preset and --world.
        """
        return lambda: run_with_bar(config, options)

    return develop


def _perceive(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
    from jointattn_mj.perceive_command import run_with_bar

    def perceive(
        config: Annotated[PerceiveConfig, tyro.conf.arg(name="")],
        options: Annotated[PerceiveOptions, tyro.conf.arg(name="")],
    ) -> Callable[[], None]:
        """Watch a video of a person at a table: what the robot would perceive, and where it would look (6.3.2).

        The camera stands still, so a fixation is attention to a place in the picture, and nothing turns.
        Leaves in --out: config.yaml, summary.json (with the mapping from the video to the robot's picture),
        percepts.parquet (a row a frame), fixations.parquet, fixations.png, som.png, faces.parquet, overlay.mp4, and
        checkpoint.bin.
        """
        return lambda: _with_one_thread(run_with_bar, config, options)

    return perceive


def _benchmark(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.benchmark import BenchmarkOptions, as_text, run_benchmark
    from jointattn_mj.contingency_benchmark import run_contingency_benchmark
    from jointattn_mj.recording.files import write_whole
    from jointattn_mj.turns_benchmark import run_turns_benchmark

    def run(options: BenchmarkOptions) -> None:
        rows: dict[str, Any] = {}
        if options.what in ("scene", "all"):
            rows |= run_benchmark(options).rows()
        if options.what in ("turns", "all"):
            rows |= run_turns_benchmark(options.blocks).rows()
        if options.what in ("contingency", "all"):
            rows |= run_contingency_benchmark(options.blocks).rows()
        print(as_text(rows))
        if options.out is not None:
            text = json.dumps(rows, indent=1) + "\n"
            write_whole(options.out, lambda path: path.write_text(text))

    def benchmark(options: Annotated[BenchmarkOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Measure, in one run: the closed loop beside rendering alone, the truth path, and dm_control's cartpole; turns
        from pictures beside rendering these; the search for contingency beside recomputation in numpy, and beside
        pyinform."""
        return lambda: _with_one_thread(run, options)

    return benchmark


def _measure(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.measure_command import MeasureOptions, run_measure

    def measure(options: Annotated[MeasureOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Measure how much a recorded variable says about what another does next: transfer entropy, T^C, SAC."""
        return lambda: _print_with_bar(run_measure, options)

    return measure


def _discover(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.discover_command import DiscoverOptions, run_discover

    def discover(options: Annotated[DiscoverOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Find which events (sensor, action) -> result in a recording are contingent, and which values carry them."""
        return lambda: _print_with_bar(run_discover, options)

    return discover


def _experiment(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.laboratory.command import ListOptions, ReportOptions, RunOptions, do

    def experiment(
        command: Annotated[
            Annotated[ListOptions, tyro.conf.subcommand("list")]
            | Annotated[RunOptions, tyro.conf.subcommand("run")]
            | Annotated[ReportOptions, tyro.conf.subcommand("report")],
            tyro.conf.arg(name=""),
        ],
    ) -> Callable[[], None]:
        """Try what the dissertation claims: list the claims, run them or run them on, report what came out."""
        return lambda: do(command)

    return experiment


def _view(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.view_command import ViewOptions, view

    def command(options: Annotated[ViewOptions, tyro.conf.arg(name="")]) -> Callable[[], None]:
        """Watch an agent in a task: in a window where there is a display, else in a browser, at an address that is
        printed and that this machine alone reaches."""
        return lambda: _with_one_thread(view, options)

    return command


def _play(arguments: Sequence[str] = ()) -> Callable[..., Any]:
    from jointattn_mj.play import PlayOptions, play

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

    cv2.setNumThreads(1)  # pictures are small: handing them round threads costs more than it gains
    run(*arguments)


def _print_with_bar(run: Callable[..., Any], options: Any) -> None:
    from tqdm import tqdm

    with tqdm(total=options.draws, desc="surrogates", leave=False, disable=None) as bar:
        result = run(options, bar.update)
    print(result.text())


if __name__ == "__main__":
    main()
