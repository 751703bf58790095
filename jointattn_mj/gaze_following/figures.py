"""The two figures of a session, after Fig. 6.6 and Fig. 6.8 of the dissertation."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.gaze_following.shifts import Shifts
from jointattn_mj.gaze_following.summary import LEARNER, moving_average, rate_of_success
from jointattn_mj.io.figures import save
from jointattn_mj.perception.som import SOM
from jointattn_mj.perception.state import StatePerception

CURVE_MINUTES = 0.1
"""Time between two points of the curve of success, simulated minutes."""
MOST_POINTS = 2000
"""Most points of that curve."""
MOST_MARKS = 1500
"""Most gaze shifts that are drawn one by one."""
WINDOW = 10
"""Gaze shifts over which the share of the learner's is taken."""


def draw_success(path: Path, shifts: Shifts, minutes: float) -> None:
    """Draw how often the robot looked where the caregiver looked, over the session (eq. 6.9, Fig. 6.8).

    Args:
        path: PNG to write.
        shifts: All gaze shifts of the session.
        minutes: Length of the session, simulated minutes.
    """
    counts = (shifts.column("face_to_object") == 1) & ~np.isnan(shifts.column("success"))
    at, success = shifts.column("landing_s")[counts] / 60, shifts.column("success")[counts] == 1
    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    axes = figure.subplots()
    axes.set_title("How often the robot looked where the caregiver looked", loc="left", weight="bold")
    if len(at):
        first, last = float(at[0]), max(float(at[-1]), minutes)
        times = np.linspace(first, last, min(MOST_POINTS, 2 + int((last - first) / CURVE_MINUTES)))
        axes.plot(times, rate_of_success(times, at, success), color="#c0392b", lw=2, label="share of hits")
        axes.plot(*moving_average(shifts, minutes), "x", color="#7b241c", ms=6, label="the same at full minutes")
    else:
        axes.text(0.5, 0.5, "no gaze shift from the face to an object", ha="center", transform=axes.transAxes)
    if len(at) > WINDOW:
        learner = (shifts.column("commanded_by")[counts] == LEARNER).astype(float)
        window = np.ones(WINDOW) / WINDOW
        axes.plot(
            np.convolve(at, window, "valid"), np.convolve(learner, window, "valid"),
            color="#7f8c8d", lw=1, label=f"share commanded by the learner ({WINDOW} shifts)",
        )  # fmt: skip
    axes.axhline(1 / shifts.objects, ls=":", color="#2c3e50", label=f"chance: one of {shifts.objects} objects")
    if 0 < len(at) <= MOST_MARKS:
        axes.plot(at[success], np.full(success.sum(), 1.04), "|", color="#1e8449", label="one shift: a hit")
        axes.plot(at[~success], np.full((~success).sum(), -0.04), "|", color="#c0392b", label="one shift: a miss")
    axes.set(xlabel="time (simulated minutes)", ylabel="share of gaze shifts", ylim=(-0.08, 1.08))
    axes.set(xlim=(0, max(minutes, float(at[-1]) if len(at) else 0.0, 0.1)), yticks=np.linspace(0, 1, 6))
    axes.grid(alpha=0.3)
    figure.legend(
        fontsize=9, loc="outside lower left", ncols=3, frameon=False, title=_ABOUT_SUCCESS, title_fontsize=9,
        alignment="left",
    )  # fmt: skip
    save(figure, path)


_ABOUT_SUCCESS = (
    "Counted: gaze shifts from the caregiver's face to an object. A hit ends at the object that the caregiver "
    "looks at.\nThe curve is mov_ave(t) of eq. 6.9: the share of hits within one minute before and after t."
)


def draw_som(path: Path, som: SOM) -> None:
    """Draw what the units of the map of faces stand for (Fig. 6.6).

    Units hold face patterns, or how these deviate from the mean face, or, with ``perception state``, directions of the
    caregiver's head.

    Args:
        path: PNG to write.
        som: The map.
    """
    rows, columns = som.config.rows, som.config.columns
    figure = Figure(figsize=(6, 6.6), layout="constrained")
    axes = figure.subplots()
    if som.weights.shape[1] == StatePerception.pattern_size:
        yaw, pitch = som.weights.reshape(rows, columns, 2).transpose(2, 0, 1)
        axes.plot(yaw, pitch, "o-", yaw.T, pitch.T, "-", color="#2980b9", ms=4, lw=0.8)
        axes.set(xlabel="head yaw (deg, to the caregiver's left)", ylabel="head pitch (deg, down)")
        axes.set_title("Head directions the robot has learned to tell apart", loc="left", weight="bold")
        axes.invert_yaxis()
        about = "dot: the head direction of one unit"
    else:
        cells = som.images()
        side = cells.shape[-1]
        faces = cells.transpose(0, 2, 1, 3).reshape(rows * side, columns * side)
        axes.imshow(faces, cmap="gray")
        axes.set(xticks=(np.arange(columns) + 0.5) * side - 0.5, yticks=(np.arange(rows) + 0.5) * side - 0.5)
        axes.set_xticklabels(map(str, range(columns)))
        axes.set_yticklabels(map(str, range(rows)))
        axes.set(xlabel="column of the map", ylabel="row of the map")
        axes.set_title("Faces the robot has learned to tell apart", loc="left", weight="bold")
        about = "cell: the face pattern of one unit"
        if not som.standardises:
            about = "cell: how faces deviate from the person's mean face in one unit"
    figure.supxlabel(
        f"Each {about} of the self-organising map (Fig. 6.6).\nNeighbours are alike.",
        fontsize=9,
    )
    save(figure, path)
