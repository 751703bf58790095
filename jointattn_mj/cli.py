"""The command line, ``jointattn``."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import tyro
from tqdm import tqdm

from jointattn_mj.errors import CheckpointError, ConfigError, JointAttnError, OutputError

BAD_USAGE, FAILED, INTERRUPTED = 2, 1, 130


def main(arguments: list[str] | None = None) -> None:
    """Run a sub-command. Exits with 2 where what was asked for cannot be done, 130 when interrupted."""
    try:
        tyro.extras.subcommand_cli_from_dict(
            _commands(),
            prog="jointattn",
            description="A robot that learns to look where somebody else is looking, in a 3D world that needs no human.",
            args=arguments,
            config=(tyro.conf.AvoidSubcommands,),
        )
    except (ConfigError, OutputError, CheckpointError) as error:
        _leave(error, BAD_USAGE)
    except JointAttnError as error:
        _leave(error, FAILED)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


def _leave(error: JointAttnError, code: int) -> None:
    print(f"jointattn: {error}", file=sys.stderr)
    sys.exit(code)


def _commands() -> dict[str, Callable[..., Any]]:
    from jointattn_mj.benchmark import BenchmarkOptions, run_benchmark
    from jointattn_mj.runner import RunOptions, run_session
    from jointattn_mj.session import FRAMES_PER_MINUTE, Session, SessionConfig

    def session(
        config: Annotated[SessionConfig, tyro.conf.arg(name="")],
        options: Annotated[RunOptions, tyro.conf.arg(name="")],
    ) -> None:
        """Let robot and caregiver live together for some minutes, and write down everything (chapter 6).

        Leaves in --out: config.yaml, summary.json, gaze_shifts.parquet (a row a shift), frames.parquet (a row a frame),
        som.png, success.png (eq. 6.9), weights.npz, checkpoint.bin, and with --video a video.
        """
        bar = tqdm(
            total=config.minutes,
            bar_format="{l_bar}{bar}| {n:.1f}/{total:g} simulated min [{elapsed}<{remaining}{postfix}]",
            disable=None,
        )

        def progress(session: Session) -> None:
            rows = [row.success for row in session.shifts if row.face_to_object]
            recent = rows[-20:]
            bar.set_postfix_str(
                f"{len(rows)} gaze shifts, success {sum(recent) / len(recent):.0%} of the last {len(recent)}"
                if recent
                else "no gaze shift yet",
                refresh=False,
            )
            bar.update(session.frame / FRAMES_PER_MINUTE - bar.n)

        try:
            with bar:
                summary = run_session(config, options, progress)
        except KeyboardInterrupt:
            if (options.out / "checkpoint.bin").exists():
                print(f"jointattn: stopped; the same command with --resume goes on from {options.out}", file=sys.stderr)
            raise
        rate = "-" if summary["late_rate"] is None else f"{summary['late_rate']:.0%}"
        print(
            f"{summary['gaze_shifts']} gaze shifts from the face to an object, {summary['successes']} to where the "
            f"caregiver looked ({rate} over the last 6 minutes), in {summary['wall_seconds']:.0f} s. "
            f"Results: {options.out}"
        )

    def benchmark(options: Annotated[BenchmarkOptions, tyro.conf.arg(name="")]) -> None:
        """Measure the closed loop beside rendering alone, the truth path, and dm_control's cartpole, in one run."""
        result = run_benchmark(options)
        print(result.text())
        if options.out is not None:
            Path(options.out).write_text(json.dumps(result.rows(), indent=1) + "\n")

    return {"session": session, "benchmark": benchmark}
