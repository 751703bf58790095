"""Coding where a person looks: what can be told, what cannot, and that it says so."""

import csv
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from jointattn_mj.cli import perceive
from jointattn_mj.errors import ConfigError, FootageError, SeriesError
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.followed import FollowedFace
from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.looks.check import Codings
from jointattn_mj.footage.looks.coding import AWAY, PARTNER, UNSEEN, UNSURE, ObservedLooks, code_looks
from jointattn_mj.footage.looks.config import LooksConfig
from jointattn_mj.footage.looks.learning import NEVER, learn_evidence, posterior, smoothed
from jointattn_mj.footage.looks.locations import known_locations, last_locations, placements
from jointattn_mj.footage.looks.log import LooksLog
from jointattn_mj.footage.looks.tables import looks_spans, looks_table
from jointattn_mj.footage.people import Sighting
from jointattn_mj.footage.run import compared, run_perceive
from jointattn_mj.perception.percept import Percept
from jointattn_mj.recordings.agreement import kappa

NAMES = ("cup", "ball", "car")
SPOTS = np.array([[x, y] for x in (-2.0, -1.0, 0.0, 1.0, 2.0) for y in (1.0, 2.0)])
"""Where objects may lie, from the face, in its heights; a face is turned to one of them."""


def session(
    looks: int = 2400, moved: bool = True, away: float = 0.0, seed: int = 0
) -> tuple[ObservedLooks, np.ndarray]:
    """A person who looks at an object for 15 looks, and may then put it to another spot; and the targets."""
    rng = np.random.default_rng(seed)
    lies = rng.permutation(len(SPOTS))[: len(NAMES)]
    faces, px, targets = [], [], []
    for _ in range(looks // 15):
        target = int(rng.integers(len(NAMES)))
        free = np.setdiff1d(np.arange(len(SPOTS)), lies)
        spot = rng.choice(free) if rng.random() < away else lies[target]
        for _ in range(15):
            active = np.full(len(SPOTS), 0.02)
            active[spot if rng.random() < 0.95 else rng.integers(len(SPOTS))] = 1.0
            faces.append(active / active.sum())
            px.append(SPOTS[lies] + rng.normal(0, 0.01, (len(NAMES), 2)))
            targets.append(target if spot == lies[target] else len(NAMES))
        if moved:
            lies[target] = rng.choice(free)
    faced, placed = np.array(faces), np.array(px) * 40 + 100
    face = np.full((len(placed), 2), 100.0)
    yaw = faced @ SPOTS[:, 0] + rng.normal(0, 0.3, len(faced))
    return ObservedLooks(NAMES, faced, face, placed, yaw, np.zeros(len(placed), bool), 40.0, 0.2), np.array(targets)


def agreed(codes: np.ndarray, targets: np.ndarray) -> float:
    size = len(NAMES) + 1
    return kappa(np.bincount(codes * size + targets, minlength=size * size).reshape(size, size))


def changed(looks: ObservedLooks, **fields) -> ObservedLooks:
    return ObservedLooks(**{**vars(looks), **fields})


def test_objects_that_are_moved_are_told_apart():
    looks, targets = session()
    coded = code_looks(looks, LooksConfig())
    assert not coded.doubt
    assert agreed(coded.best, targets) > 0.9
    sure = (coded.posterior > 0.8).any(axis=1)
    assert sure.mean() > 0.8
    assert (coded.best == targets)[sure].mean() > 0.95


def test_nothing_is_coded_where_nothing_moves():
    looks, _ = session(moved=False)
    coded = code_looks(looks, LooksConfig())
    assert coded.placements.tolist() == [1, 1, 1]
    assert "little is moved" in coded.doubt
    assert set(coded.codes) == {coded.labels.index(UNSURE)}
    assert np.isnan(coded.posterior).all()
    assert coded.summary(LooksConfig())["sure"] == 0


def test_away_is_an_answer_that_can_be_left_out():
    looks, targets = session(3600, away=0.2)
    is_away = targets == len(NAMES)
    coded = code_looks(looks, LooksConfig())
    found, sure = coded.best == coded.labels.index(AWAY), (coded.posterior > 0.8).any(axis=1)
    assert found[~is_away].mean() < 0.02 < 5 * found[is_away].mean()  # rather too few: here nobody looks near objects
    assert sure.mean() > 0.5
    assert (coded.best == targets)[sure].mean() > 0.95
    without = code_looks(looks, LooksConfig(away=None))
    assert not (without.best == without.labels.index(AWAY)).any()
    assert agreed(without.best, targets) < agreed(coded.best, targets)


def test_hidden_object_stays_where_it_was():
    looks, targets = session()
    px = looks.px.copy()
    for at in range(0, len(px), 45):
        px[at + 3 : at + 12, targets[at + 3]] = np.nan
    hidden = np.isnan(px).any(axis=(1, 2))
    coded = code_looks(changed(looks, px=px), LooksConfig())
    assert (coded.best == targets)[hidden].mean() > 0.85


def test_moved_while_hidden_is_where_nobody_knows():
    """It is not taken for where it was; and whatever is seen again in its place has stayed there."""
    px = np.full((7, 2, 2), 5.0)
    px[2:4] = np.nan
    px[4:, 1] = 9.0
    cut = np.zeros(7, bool)
    filled = known_locations(px, cut, 1.0)
    assert np.array_equal(filled[:, 0], px[[0, 1, 0, 0, 4, 5, 6], 0])
    assert np.isnan(filled[2:4, 1]).all()
    cut[4] = True
    assert (known_locations(px, cut, 1.0)[2:4] == 5).all()  # what comes after a cut says nothing


def test_partner_who_sits_still_is_an_answer():
    """Looks at no object are those at the other face, to the side of all objects."""
    looks, targets = session(3600, away=0.25)
    aside, at_partner = np.full(len(SPOTS) + 1, 0.02), targets == len(NAMES)
    faces = np.column_stack([looks.faces, np.full(len(targets), 0.02)])
    aside[-1] = 1.0
    faces[at_partner] = aside
    partner = np.tile([220.0, 100.0], (len(targets), 1, 1))
    yaw = np.where(at_partner, 3.5, looks.yaw_deg)
    shown = changed(looks, names=(*NAMES, PARTNER), faces=faces, yaw_deg=yaw, px=np.hstack([looks.px, partner]))
    coded = code_looks(shown, LooksConfig())
    assert (coded.best == targets)[at_partner].mean() > 0.8
    assert (coded.best == targets)[~at_partner].mean() > 0.9


def test_few_placements_are_never_sure():
    looks, _ = session(225)
    coded = code_looks(looks, LooksConfig(placements=1))
    assert 1 < coded.placements.sum() < 40
    assert not coded.doubt
    assert np.nanmax(coded.posterior) < 0.8


def test_labels_tell_what_never_moves():
    looks, targets = session(moved=False)
    labels = np.where(np.arange(len(targets)) < 1500, targets, -1)
    coded = code_looks(looks, LooksConfig(), labels)
    assert not coded.doubt
    assert agreed(coded.best[1500:], targets[1500:]) > 0.95


def test_labels_help_to_tell_looks_away():
    looks, targets = session(3600, away=0.2, seed=1)
    labels = np.where(np.arange(len(targets)) < 1500, targets, -1)
    plain, helped = code_looks(looks, LooksConfig()), code_looks(looks, LooksConfig(), labels)
    kappas = [agreed(coded.best[1500:], targets[1500:]) for coded in (plain, helped)]
    assert kappas[1] > kappas[0] + 0.03


def test_face_that_is_lost_cannot_be_seen():
    looks, _ = session()
    face = looks.face_px.copy()
    face[300:340] = face[600:602] = np.nan
    coded = code_looks(changed(looks, face_px=face), LooksConfig())
    unseen = coded.codes == coded.labels.index(UNSEEN)
    assert unseen.nonzero()[0].tolist() == list(range(300, 340))
    assert np.isnan(coded.posterior[unseen]).all()
    assert np.isnan(coded.alone[600:602]).all()
    no_face = changed(looks, face_px=np.full(face.shape, np.nan))
    nobody = code_looks(no_face, LooksConfig())
    assert nobody.doubt == "the face was not seen"


def test_places_are_forgotten_after_a_cut():
    px = np.full((6, 1, 2), np.nan)
    px[1], px[4] = 3.0, 7.0
    cut = np.array([False, False, False, True, False, False])
    filled = last_locations(px, cut)[:, 0, 0]
    assert np.array_equal(filled, [np.nan, 3, 3, np.nan, 7, 7], equal_nan=True)


def test_placements_count_rests_in_different_places():
    path = [0.0] * 8 + [0.2, 0.5, 0.8] + [1.0] * 8 + [np.nan] * 5 + [1.0] * 8 + [0.5] * 2 + [0.0] * 6
    locations = np.stack([path, path], axis=1)[:, None]
    assert placements(locations).tolist() == [3]


def test_unknown_locations_are_never_chosen():
    looks, _ = session(300)
    px = looks.px / 40
    px[:, 1] = np.nan
    evidence = learn_evidence(looks.faces, px, LooksConfig())
    assert (evidence.looks[:, 1] == NEVER).all()
    assert (evidence.by_chance[:, 1] == NEVER).all()
    assert posterior(evidence.looks)[:, 1].max() < 1e-9
    assert (learn_evidence(looks.faces, np.full(px.shape, np.nan), LooksConfig()).looks == NEVER).all()


def test_smoothing_agrees_with_the_sum_over_all_paths():
    rng = np.random.default_rng(0)
    evidence, stay = rng.normal(0, 1, (4, 3)), 0.7
    paths = np.array(np.meshgrid(*[range(3)] * 4, indexing="ij")).reshape(4, -1)
    weight = np.exp(0.5 * sum(evidence[i, paths[i]] for i in range(4)))
    for i in range(3):
        weight *= np.where(paths[i] == paths[i + 1], stay, (1 - stay) / 2)
    expected = [[weight[paths[i] == k].sum() / weight.sum() for k in range(3)] for i in range(4)]
    assert np.allclose(smoothed(evidence, stay, 0.5), expected)


@pytest.mark.parametrize("y", [4.0, 100.0, 215.0])
def test_the_height_of_a_face_is_not_cut_by_the_border(tmp_path, y):
    """It is the unit of distances."""
    face, faces = np.array([140.0, y, 24.0, 30.0]), FollowedFace()
    chosen = Sighting(1, 1, True, True, np.zeros(15), face, 0.0, 1.0)
    mapped = FrameMap.fitted(320, 240)
    faces.show(chosen, np.zeros((240, 320, 3), np.uint8), mapped)
    perceiver = SimpleNamespace(
        faces=faces,
        fix=faces.detect(np.zeros((240, 320)), None, None),
        pattern_size=4,
        face_pattern=lambda: np.zeros(4),
    )  # fmt: skip
    percept = Percept(np.array([True]), np.array([[152.0, y + 15]]), np.array([False]))
    log = LooksLog(tmp_path, ("face",), 4)
    log.add(
        SimpleNamespace(
            watcher=SimpleNamespace(perceiver=perceiver, percept=percept), chosen=chosen, visible_faces=[chosen],
            mapped=mapped, frames=1,
        )
    )  # fmt: skip
    assert log.rows.read()[0, 1] == 33


def test_table_and_events_say_the_same():
    looks, _ = session(600)
    coded = code_looks(looks, LooksConfig())
    frames = np.arange(600) * 6
    spans = looks_spans(coded, frames, 3600)
    assert spans[0].start == 0
    assert [span.end for span in spans[:-1]] == [span.start for span in spans[1:]]
    assert spans[-1].end == 3600
    table = looks_table(coded, frames / 30)
    codes = table["looks_at"].to_pylist()
    assert all(codes[span.start // 6] == span.code for span in spans)
    assert {f"{name}_posterior" for name in (*NAMES, AWAY)} <= set(table.column_names)


def coding(path: Path, *rows: tuple[float, float, str], tier: str = "gaze") -> Path:
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(
            [("onset_s", "offset_s", "tier", "code"), *((a, b, tier, code) for a, b, code in rows)]
        )
    return path


def test_kappa_is_of_what_both_answer(tmp_path):
    mine = coding(tmp_path / "a.csv", (0, 10, "cup"), (10, 20, "ball"), (20, 30, "turn"), (30, 40, "away"))
    own = coding(tmp_path / "b.csv", (0, 5, "cup"), (5, 15, "ball"), (15, 25, UNSURE), (25, 60, "away"))
    found = Codings.read(mine).compare(Codings.read(own))
    assert found["seconds"] == 25  # 0 to 15 and 30 to 40
    assert found["left_out"] == pytest.approx(15 / 40)
    counts = np.array([[5, 5, 0], [0, 5, 0], [0, 0, 10]])
    assert found["kappa"] == pytest.approx(kappa(counts))
    assert found["observed"] == pytest.approx(20 / 25)


def test_one_code_alone_has_no_kappa(tmp_path):
    """JSON knows no NaN, and the command says it in words."""
    mine = Codings.read(coding(tmp_path / "a.csv", (0, 10, "cup")))
    found = compared(mine, coding(tmp_path / "events.csv", (0, 10, "cup")).parent)
    assert found["kappa"] is None and found["low"] is None
    looks = {"placements": {}, "coded": False, "why_not": "no", "check": found}
    assert "kappa has no meaning, as both have one code alone, over 10 s" in perceive._of_looks(looks)


@pytest.mark.parametrize("theirs", [(20, 30, "cup"), (0, 10, UNSURE), (0, 10, UNSEEN)])
def test_no_time_in_which_both_answer_is_a_result(tmp_path, theirs):
    """A video in which nobody is seen, or nothing is sure, has been watched all the same."""
    mine = Codings.read(coding(tmp_path / "a.csv", (0, 10, "cup")))
    found = compared(mine, coding(tmp_path / "events.csv", theirs).parent)
    assert found["kappa"] is None and (found["seconds"], found["left_out"]) == (0, 1)
    looks = {"placements": {}, "coded": False, "why_not": "no", "check": found}
    assert "there is no time in which both say where somebody looks" in perceive._of_looks(looks)


def test_codings_that_cannot_be_compared(tmp_path):
    mine = coding(tmp_path / "a.csv", (0, 10, "cup"))
    two = tmp_path / "c.csv"
    two.write_text("onset_s,offset_s,tier,code\n0,1,a,cup\n0,1,b,cup\n")
    with pytest.raises(SeriesError, match="one tier"):
        Codings.read(two)
    with pytest.raises(SeriesError, match="'cup' until 10 s and 'ball' from 5 s"):
        Codings.read(coding(tmp_path / "d.csv", (0, 10, "cup"), (5, 12, "ball")))
    with pytest.raises(ConfigError, match="looks must be set"):
        run_perceive(PerceiveConfig(tmp_path / "no.mp4"), PerceiveOptions(tmp_path / "out", check=mine))
    with pytest.raises(ConfigError, match=r"labels .* looks must be set"):
        run_perceive(PerceiveConfig(tmp_path / "no.mp4", labels=mine), PerceiveOptions(tmp_path / "out"))


def test_codes_of_other_things_are_refused_before_the_video_is_watched(tmp_path):
    """In capitals, say; a check may have some codes beside the objects, and labels none."""
    config, out = PerceiveConfig(tmp_path / "no.mp4", objects=("blue",), looks=True), PerceiveOptions(tmp_path / "out")
    other = coding(tmp_path / "a.csv", (0, 1, "BLUE"))
    with pytest.raises(SeriesError, match="'BLUE' is none of blue, partner, away"):
        run_perceive(config, replace(out, check=other))
    both = coding(tmp_path / "b.csv", (0, 1, "blue"), (1, 2, "hands"))
    with pytest.raises(FootageError, match="does not exist"):
        run_perceive(config, replace(out, check=both))
    with pytest.raises(SeriesError, match="'hands' is none of"):
        run_perceive(replace(config, labels=both), out)


def test_labels_at_times(tmp_path):
    mine = Codings.read(coding(tmp_path / "a.csv", (0, 1, "cup"), (1, 2, "turn"), (2, 3, "ball")))
    assert mine.at(np.arange(8) * 0.5, ("ball", "cup")).tolist() == [1, 1, -1, -1, 0, 0, -1, -1]
    with pytest.raises(SeriesError, match="'cup' is none of ball"):
        mine.at(np.arange(8) * 0.5, ("ball",))
    with pytest.raises(SeriesError, match="no look between"):
        mine.at(np.arange(8) + 10.0, ("ball", "cup"))
