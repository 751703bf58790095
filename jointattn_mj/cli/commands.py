"""What ``jointattn`` can do: the table of its commands, and the overview that is printed from it.

Each command has a module of its name in this package, with a function of that name, whose docstring and parameters are
its help and its options, and ``LESS``, what to ask for where memory is short. Nothing of a command is imported before
it is asked for.
"""

from typing import NamedTuple


class Command(NamedTuple):
    """A line of the overview."""

    does: str
    leaves: str


ABOUT = "A robot that learns to look where somebody else is looking, in a 3D world without humans."
JOBS: dict[str, dict[str, Command]] = {
    "Simulate": {
        "session": Command(
            "Simulate a robot that learns to follow a caregiver's gaze (chapter 6).",
            "tables of gaze shifts and frames, learned weights, figures, a summary; --video, --rerun",
        ),
        "develop": Command(
            "Simulate a robot that finds contingent events and develops joint attention (chapters 4, 5, 7).",
            "modules and what they mean, behaviour over time, learned maps, a summary; --video",
        ),
    },
    "Look at people": {
        "perceive": Command(
            "Show what the robot perceives and attends to in a video of a person at a table.",
            "tables of percepts and fixations, figures, a summary, an annotated video",
        ),
        "recordings": Command(
            "Make one page of coded interaction: timelines, joint attention, transitions, contingency.",
            "report.html, a paragraph on methods, CSV and JSON, figures",
        ),
        "measure": Command(
            "Measure how much one recorded variable says about the next value of another.",
            "a table of measures with intervals and p-values; --out for files",
        ),
        "discover": Command(
            "Find the contingent events (sensor, action) -> result of a recording.",
            "a ranking of events with p-values; --out for files",
        ),
        "transitions": Command(
            "Count what follows what in coded interaction: lag-sequential analysis.",
            "a table of transitions with residuals, odds ratios and p-values; --out for files",
        ),
        "agreement": Command(
            "Compare two coders of the same recordings by Cohen's kappa.",
            "a table of tiers and codes; --out for files",
        ),
        "looks": Command(
            "Write the looks of a robot and its caregiver as files of ELAN, BORIS or Datavyu.",
            "a file for each recording",
        ),
    },
    "Try and compare": {
        "experiment": Command(
            "List, run and report the claims of the dissertation.",
            "one file a trial; a report page with figures, claims.json, claims.csv",
        ),
        "play": Command(
            "Let an agent play episodes of a task of the dm_control suite.",
            "returns with intervals; --out for files, --video",
        ),
        "view": Command("Watch an agent in a task, in a window or in a browser.", "nothing"),
        "benchmark": Command("Measure how fast simulation, perception and analysis run.", "a table; --out for a file"),
    },
}
COMMANDS = {name: command for job in JOBS.values() for name, command in job.items()}


def overview() -> str:
    """All commands by job: what each does and leaves."""
    lines = ["usage: jointattn COMMAND [options]", "", ABOUT]
    for job, commands in JOBS.items():
        lines += ["", f"{job}:"]
        for name, command in commands.items():
            lines += [f"  {name:12}{command.does}", f"  {'':12}Leaves {command.leaves}."]
    return "\n".join(
        [
            *lines,
            "",
            "jointattn COMMAND --help      everyday options of a command",
            "jointattn COMMAND --help-all  all of its options",
            "jointattn --version           the version that is installed",
        ]
    )
