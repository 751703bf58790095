"""The two figures of a session, drawn like the dissertation's: Fig. 6.6 and Fig. 6.8."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from jointattn_mj.gaze_following.shifts import Shifts
from jointattn_mj.gaze_following.summary import LEARNER, moving_average
from jointattn_mj.io.figures import save
from jointattn_mj.perception.som import SOM
from jointattn_mj.perception.state import StatePerception

FOUR_OBJECTS = 0.25


def draw_success(path: Path, shifts: Shifts, minutes: float) -> None:
    """Moving average of the rate of success, eq. 6.9 (Fig. 6.8), and who commanded the shifts."""
    times, rate = moving_average(shifts, minutes)
    counts = shifts.column("face_to_object") == 1
    at = shifts.column("landing_s")[counts] / 60
    learner = (shifts.column("commanded_by")[counts] == LEARNER).astype(float)
    figure = Figure(figsize=(6.4, 3.8), layout="constrained")
    axes = figure.subplots()
    axes.plot(times, rate, "x-", color="#c0392b", label="success of gaze shifts to objects, eq. 6.9")
    if len(at) > 10:
        window = np.ones(10) / 10
        axes.plot(
            np.convolve(at, window, "valid"), np.convolve(learner, window, "valid"),
            color="#7f8c8d", lw=1, label="share commanded by the learner (10 shifts)",
        )  # fmt: skip
    axes.axhline(FOUR_OBJECTS, ls=":", color="#2c3e50", label="one of four objects at random")
    axes.set(xlabel="time (simulated minutes)", ylabel="rate", xlim=(0, max(minutes, 1)), ylim=(0, 1))
    axes.legend(fontsize=8, loc="upper left")
    axes.grid(alpha=0.3)
    save(figure, path)


def draw_som(path: Path, som: SOM) -> None:
    """The learned map (Fig. 6.6): its cells' face patterns, or with the truth path its cells' head angles."""
    rows, columns = som.config.rows, som.config.columns
    figure = Figure(figsize=(6, 6), layout="constrained")
    axes = figure.subplots()
    if som.weights.shape[1] == StatePerception.pattern_size:
        yaw, pitch = som.weights.reshape(rows, columns, 2).transpose(2, 0, 1)
        axes.plot(yaw, pitch, "o-", yaw.T, pitch.T, "-", color="#2980b9", ms=4, lw=0.8)
        axes.set(xlabel="head yaw (deg, to her left)", ylabel="head pitch (deg, down)", title="SOM of head directions")
        axes.invert_yaxis()
    else:
        cells = som.images()
        side = cells.shape[-1]
        faces = cells.transpose(0, 2, 1, 3).reshape(rows * side, columns * side)
        axes.imshow(faces, cmap="gray")
        axes.set(xticks=(np.arange(columns) + 0.5) * side - 0.5, yticks=(np.arange(rows) + 0.5) * side - 0.5)
        axes.set_xticklabels(map(str, range(columns)))
        axes.set_yticklabels(map(str, range(rows)))
        axes.set(xlabel="SOM column", ylabel="SOM row", title="SOM of face patterns")
    save(figure, path)
