"""``jointattn session``: a session of gaze following, and how it goes."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

from jointattn_mj.api.session import LoggedSessionOptions, run_logged
from jointattn_mj.cli.running import going_on_from, one_thread
from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.presets import PRESETS, Preset
from jointattn_mj.gaze_following.session import FRAMES_PER_MINUTE, SessionRun
from jointattn_mj.gaze_following.summary import LATE_MINUTES
from jointattn_mj.gaze_following.varied_session import VariedSessionConfig, VariedSessionRun
from jointattn_mj.io.progress import Progress, count
from jointattn_mj.options import FLAT, Checked, meant, shown

LESS = "fewer minutes"
WORLDS = ("rendered", "video", "camera")
"""Worlds of --world."""
RECENT = 20
"""Gaze shifts over which the success rate beside the bar is taken."""


@dataclass(frozen=True)
class PresetOptions(Checked):
    """Which robot it is."""

    preset: Preset = "thesis"
    """Robot that gives --robot.* their defaults; each option can still be set by itself. thesis: chapter 6 as it is
    written; without motion cues two sessions in five end with a wrong map, in which faces lead to an object that the
    caregiver does not look at. cross_situational: learns which of the objects in view goes with a face, waits until the
    face is still, reads it again on the way, and codes faces more finely and without what is one person's; it ends with
    no wrong map, with and without motion cues, and follows strangers, too."""


def session(
    config: Annotated[VariedSessionConfig, FLAT],
    options: Annotated[LoggedSessionOptions, FLAT],
    preset: Annotated[PresetOptions, FLAT] = PresetOptions(),  # see defaults_for
) -> None:
    """Simulate a robot that learns to look where a caregiver looks (chapter 6).

    --world video puts a recorded person in the caregiver's place, --world camera one who is there; --world video --help
    and --world camera --help have their options.

    Leaves in --out: config.yaml, summary.json, gaze_shifts.parquet (a row a gaze shift), frames.parquet (a row a
    frame), som.png, success.png (eq. 6.9), weights.npz, checkpoint.bin, and with --video a video.
    """
    one_thread()
    bar = Progress("learning the caregiver's face", config.minutes, "simulated min", digits=1)
    recent, counted, of_all = deque[bool](maxlen=RECENT), 0, 0

    def progress(session: SessionRun) -> None:
        nonlocal counted, of_all
        new = [bool(row.success) for row in session.shifts[of_all:] if row.face_to_object]
        recent.extend(new)
        counted, of_all = counted + len(new), len(session.shifts)
        rate = f"success {sum(recent) / len(recent):.0%} of the last {len(recent)}" if recent else "no success yet"
        bar.doing("session")
        bar.to(session.frame / FRAMES_PER_MINUTE, f"{count(counted, 'gaze shift')}, {rate}")

    with going_on_from(options.out, "the session"), bar:
        summary = run_logged(config, options, progress, VariedSessionRun)
    late = summary.late_success_rate
    last = f" over the last {LATE_MINUTES:g} minutes" if config.minutes > LATE_MINUTES else ""
    print(
        f"{count(summary.gaze_shifts, 'gaze shift')} from the face to an object, {summary.successes} to where "
        f"the caregiver looked ({'-' if late is None else format(late, '.0%')}{last}), "
        f"in {summary.wall_seconds:.0f} s. Results: {options.out}"
    )


def in_world(words: Sequence[str]) -> tuple[Callable[..., None], list[str]]:
    """The command for the world that is asked for, and the other words.

    Args:
        words: What follows ``jointattn session``.

    Raises:
        ConfigError: There is no such world.
    """
    world, others, waiting = "rendered", [], False
    for word in words:
        if waiting or word.startswith("--world="):
            world, waiting = word.removeprefix("--world="), False
        elif word == "--world":
            waiting = True
        else:
            others.append(word)
    if waiting or world not in WORLDS:
        raise ConfigError(f"--world: expected one of {', '.join(WORLDS)}; got {shown(world)}{meant(world, WORLDS)}")
    if world == "rendered":
        return session, others
    from jointattn_mj.cli import table_session  # not needed by most, and slow to import

    command: Callable[..., None] = getattr(table_session, world)
    return command, others


def defaults_for(words: Sequence[str], config: Any, kind: type[Any] = VariedSessionConfig) -> Any:
    """The config that the options start from.

    Args:
        words: What follows ``jointattn session``.
        config: That of the file of --config; None without one.
        kind: Class of the config.

    Raises:
        ConfigError: Both a file and a preset are given.
    """
    following = [*words, ""][1:]
    named = [after if word == "--preset" else word.removeprefix("--preset=")
             for word, after in zip(words, following, strict=True) if word.partition("=")[0] == "--preset"]  # fmt: skip
    if named and config is not None:
        raise ConfigError(
            f"--preset {named[-1]} chooses other defaults than the file of --config, which holds them all; give one of "
            "the two"
        )
    start = config or kind()
    return replace(start, robot=PRESETS[named[-1]]) if named and named[-1] in PRESETS else start
