"""Where the person of a video looks, as coded, and what of the robot's shifts can be judged by it."""

import pytest

from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.footage.sessions.truth import NO_OBJECT, UNKNOWN, CodedLooks
from jointattn_mj.gaze_following.scoring import Judgement

CODING = """onset_s,offset_s,tier,code
0,1,looks at,partner
1,2.5,looks at,red
2.5,3,looks at,unsure
4,5,looks at,blue
"""


def coded(folder, text=CODING, names=("red", "blue")):
    path = folder / "coding.csv"
    path.write_text(text)
    return CodedLooks.read(path, names)


def test_looks_by_time(tmp_path):
    looks = coded(tmp_path)
    times = {
        0.5: NO_OBJECT,
        1.0: 0,
        2.49: 0,
        2.5: UNKNOWN,
        2.7: UNKNOWN,
        3.5: UNKNOWN,
        4.0: 1,
        5.0: UNKNOWN,
        -1: UNKNOWN,
    }
    assert {time: looks.at(time) for time in times} == times


def test_a_folder_of_perceive_is_read_as_its_events(tmp_path):
    (tmp_path / "events.csv").write_text(CODING)
    assert CodedLooks.read(tmp_path, ("red", "blue")).at(1.5) == 0


def test_codings_of_other_objects_are_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"none of the objects \(cup\).*blue, partner, red"):
        coded(tmp_path, names=("cup",))
    with pytest.raises(ConfigError, match="says of no time"):
        coded(tmp_path, "onset_s,offset_s,tier,code\n0,1,looks at,unsure\n")
    with pytest.raises(SeriesError):
        CodedLooks.read(tmp_path / "none.csv", ("red",))


@pytest.mark.parametrize(
    ("launch", "landing", "either"),
    [(True, False, True), (False, False, False), (None, True, True), (None, False, None), (True, None, True),
     (False, None, None), (None, None, None)],
)  # fmt: skip
def test_what_is_not_known_is_no_miss(launch, landing, either):
    judged = Judgement(launch, landing, 0, 0.0)
    assert judged.success("either") is either
    assert judged.success("launch") is launch
    assert judged.success("landing") is landing
