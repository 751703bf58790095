"""The views that Rerun's viewer opens a log with."""

import rerun.blueprint as rrb

from jointattn_mj.adapters.rerun import entities as at
from jointattn_mj.video.paint import GROUND

SECONDS = 20
"""How many seconds before the cursor curves show."""


def layout() -> rrb.Blueprint:
    """Make the views and their arrangement."""
    last = rrb.VisibleTimeRange(
        "time",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-SECONDS),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    eye = rrb.EyeControls3D(position=(0.5, -1.55, 1.55), look_target=(0.8, 0.0, 0.88), eye_up=(0, 0, 1))
    scene = [f"{at.WORLD}/**", f"- {at.FLOW}/**", f"- {at.VISIBLE}/**", f"- {at.GOAL}/**"]
    agent = rrb.Vertical(
        rrb.Spatial2DView(origin=at.EYE, name="What the robot sees", background=GROUND),
        rrb.TimeSeriesView(origin=at.INTEREST, name="Interest of each candidate (eq. 6.1)", time_ranges=[last]),
        rrb.StateTimelineView(origin=at.DOINGS, name="Who looks at what"),
        row_shares=[5, 3, 2],
    )
    words = rrb.TextLogColumns(timeline_columns=["time"], text_log_columns=["Body"])
    learning = rrb.Horizontal(
        rrb.Spatial2DView(origin=at.FACES, name="Faces on the map"),
        rrb.TensorView(origin=at.ACTIVATIONS, name="Activations of the map"),
        rrb.TextLogView(origin=at.SHIFTS, name="Gaze shifts", columns=words),
        column_shares=[2, 2, 4],
    )
    share = rrb.ScalarAxis(range=(-0.05, 1.05))
    decides = rrb.TimeSeriesView(
        origin=at.DECIDES, name="How often the learner decides (eq. 6.8) and succeeds (eq. 6.9)", axis_y=share
    )
    head = rrb.TimeSeriesView(origin=at.HEAD, name="Robot's head, degrees", time_ranges=[last])
    outside = rrb.Vertical(
        rrb.Spatial3DView(
            origin="/",
            contents=scene,
            name="From the side",
            eye_controls=eye,
            line_grid=False,
            background=GROUND,
        ),
        learning,
        rrb.Horizontal(decides, head),
        row_shares=[5, 3, 2],
    )
    return rrb.Blueprint(
        rrb.Horizontal(agent, outside, column_shares=[4, 5]),
        rrb.TimePanel(state="collapsed", timeline="time"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
        auto_layout=False,
    )
