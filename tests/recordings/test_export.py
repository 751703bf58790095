"""Events that are written for a coding program come back as they were, and a robot's looks are events."""

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from jointattn_mj import recordings
from jointattn_mj.errors import ConfigError, OutputError, SeriesError
from jointattn_mj.options import RenamedWarning
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.export import ENDINGS, write_events
from jointattn_mj.recordings.looks import LooksOptions, export_looks, looks_of

LOOKS = Events.of(
    ["infant", "infant", "mother", "infant", "mother"],
    ["cup, red", "face", 'a "b"', "cup, red", "face"],
    [0, 1.25, 0.5, 0, 0],
    [1.25, 3, 2, 2.001, 7],
    ["12.1", "12.1", "12.1", "2E1", "2E1"],
)


def rows(events: Events) -> list[tuple]:
    return list(zip(*(events.table[name] for name in events.table), strict=True))


@pytest.mark.parametrize("form", ENDINGS)
def test_what_is_written_is_read_back(tmp_path, form):
    paths = write_events(LOOKS, tmp_path / "looks", form)
    assert len(paths) == (2 if form in ("elan", "datavyu") else 1)
    assert rows(recordings.read(tmp_path / "looks").events) == rows(LOOKS)
    with pytest.raises(OutputError, match="is there already"):
        write_events(LOOKS, tmp_path / "looks", form)


def test_whole_seconds_stay_seconds(tmp_path):
    write_events(Events.of(["a"], ["x"], [0], [3000]), tmp_path, "table")
    assert recordings.read(tmp_path).events.table["offset"].tolist() == [3000]


def test_what_cannot_be_written_is_told(tmp_path):
    with pytest.raises(ConfigError, match=r"form: expected elan, .*; got 'word'"):
        write_events(LOOKS, tmp_path, "word")
    with pytest.raises(SeriesError, match="no events"):
        write_events(Events.of([], [], [], []), tmp_path)
    with pytest.raises(SeriesError, match="file name"):
        write_events(Events.of(["a", "a"], ["x", "x"], [0, 0], [1, 1], ["a/b", "a:b"]), tmp_path)


def table(folder, name, **columns):
    folder.mkdir(exist_ok=True)
    parquet.write_table(pa.table(columns), folder / name)


def test_a_session_lasts_as_long_as_its_frames(tmp_path):
    times = np.arange(6) / 30
    table(tmp_path, "frames.parquet", time_s=times, attended=["face", "face", "red", "red", "red", "face"],
          target=["red"] * 3 + ["blue"] * 3)  # fmt: skip
    found = looks_of(LooksOptions(tmp_path, tmp_path, name="robot"))
    assert rows(found) == [
        ("robot", "robot", "face", 0.0, 0.067),
        ("robot", "robot", "red", 0.067, 0.167),
        ("robot", "robot", "face", 0.167, 0.2),
        ("robot", "caregiver", "red", 0.0, 0.1),
        ("robot", "caregiver", "blue", 0.1, 0.2),
    ]


def test_partners_of_a_development_look_at_faces(tmp_path):
    columns = {"shift gaze": ["caregiver", "spot 1"], "caregiver looks at": ["robot", "robot"]}
    table(tmp_path / "run", "steps.parquet", **columns)
    options = LooksOptions(
        tmp_path / "run", tmp_path / "out", form="boris", robot="infant", caregiver="mother", step_s=2
    )
    export_looks(options)
    assert rows(recordings.read(tmp_path / "out").events) == [
        ("run", "infant", "face", 0, 2),
        ("run", "infant", "spot 1", 2, 4),
        ("run", "mother", "face", 0, 4),
    ]


def test_a_development_of_the_last_version_has_looks(tmp_path):
    table(tmp_path / "run", "turns.parquet", **{"shift gaze": ["caregiver"], "caregiver looks at": ["spot 1"]})
    with pytest.warns(RenamedWarning, match=r"turns\.parquet is now called steps\.parquet"):
        export_looks(LooksOptions(tmp_path / "run", tmp_path / "out", form="boris"))
    assert rows(recordings.read(tmp_path / "out").events) == [
        ("run", "robot", "face", 0, 1),
        ("run", "caregiver", "spot 1", 0, 1),
    ]


def test_a_video_has_people_beside_looks(tmp_path):
    """Two people are there at the same time, which no tier of ELAN could hold."""
    table(tmp_path, "percepts.parquet", time_s=[0.0, 0.1], attended=[None, "face"])
    (tmp_path / "events.csv").write_text(
        "onset_s,offset_s,tier,code,score\n0,3,person,person 1,0.9\n1,2,person,person 2?,0.8\n"
        "0.5,1,robot looks at,face,\n0,3,looks at,cup,0.7\n2,2.1,camera,cut,\n"
    )
    found = looks_of(LooksOptions(tmp_path, tmp_path, robot="infant", caregiver="mother", name="a"))
    assert sorted(rows(found)) == [
        ("a", "camera", "cut", 2, 2.1),
        ("a", "infant", "face", 0.5, 1),
        ("a", "mother", "cup", 0, 3),
        ("a", "person 1", "there", 0, 3),
        ("a", "person 2?", "there", 1, 2),
    ]
    write_events(found, tmp_path / "elan", "elan")
    assert sorted(rows(recordings.read(tmp_path / "elan" / "a.eaf").events)) == sorted(rows(found))


def test_of_an_earlier_video_only_attention_is_known(tmp_path):
    table(tmp_path, "percepts.parquet", time_s=[0.0, 0.1, 0.2], attended=[None, "face", "face"])
    found = looks_of(LooksOptions(tmp_path, tmp_path))
    assert found.tier_names == ("robot",)
    assert [(a, b) for *_, a, b in rows(found)] == [(0.1, 0.3)]


def test_a_folder_without_looks_is_told(tmp_path):
    with pytest.raises(OutputError, match="holds no looks"):
        looks_of(LooksOptions(tmp_path, tmp_path))
    with pytest.raises(ConfigError, match="tiers of their own"):
        LooksOptions(tmp_path, tmp_path, robot="a", caregiver="a")
