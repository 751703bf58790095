"""Columns are found by the names that they had in the last version."""

from jointattn_mj.footage.log import FRAME as PERCEPT
from jointattn_mj.gaze_following.columns import CANDIDATE, FRAME
from jointattn_mj.io.former_names import FORMER, present_name


def test_former_and_present_names():
    assert present_name("looked") == "perceived"
    assert present_name("red_seen") == "red_visible"
    assert present_name("light_red_x_m") == "light_red_x_m"
    assert {present_name(old) for old in FORMER} <= {*FRAME, *CANDIDATE, *PERCEPT, "step"}
