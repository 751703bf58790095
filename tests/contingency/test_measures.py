"""Measures against closed forms, pyinform, the formulas written out, and identities."""

import subprocess
import sys

import numpy as np
import pyinform
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slow_measures import Histogram, contingency, every_case, flow, saliency, transitions

import jointattn_mj.contingency as c
from jointattn_mj.contingency import information, table
from jointattn_mj.errors import SeriesError

CLOSED_FORMS = {
    "xor": (lambda s, a: s ^ a, 2, (1, 1, 1, 0, 0)),
    "and": (lambda s, a: s & a, 2, (0.188722, 0.5, 0.811278, 0.311278, 0.311278)),
    "s": (lambda s, a: s, 2, (0, 1, 1, 1, 0)),
    "a": (lambda s, a: a, 2, (0, 0, 1, 0, 1)),
    "same of 3": (lambda s, a: int(s == a), 3, (0.918296, 0.918296, 0.918296, 0, 0)),
    "same of 9": (lambda s, a: int(s == a), 9, (0.503258, 0.503258, 0.503258, 0, 0)),
}


def five(s, a, r):
    return (
        c.state_action_contingency(s, a, r),
        c.combined_transfer_entropy(s, a, r),
        c.transfer_entropy(c.joint(s, a), r),
        c.transfer_entropy(s, r),
        c.transfer_entropy(a, r),
    )


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_forms(name):
    result, values, expected = CLOSED_FORMS[name]
    assert five(*every_case(result, values)) == pytest.approx(expected, abs=1e-6)


def test_two_that_say_the_same():
    s, a, r = every_case(lambda s, a: s)
    same = [i for i in range(len(s)) if s[i] == a[i]]
    assert five(*([series[i] for i in same] for series in (s, a, r))) == pytest.approx((-1, 0, 1, 1, 1))


def random_series(seed, n=400, values=(4, 3, 3)):
    rng = np.random.default_rng(seed)
    s, a, r = (rng.integers(0, k, n) for k in values)
    follows = rng.random(n - 1) < 0.5
    r[1:][follows] = ((s + a) % values[2])[:-1][follows]
    return s, a, r


@pytest.mark.parametrize("seed", range(5))
def test_agrees_with_pyinform(seed):
    s, a, r = random_series(seed)
    assert c.transfer_entropy(s, r) == pytest.approx(pyinform.transfer_entropy(s, r, k=1), abs=1e-12)
    conditional = pyinform.transfer_entropy(s, r, k=1, condition=a)
    assert c.transfer_entropy(s, r, a) == pytest.approx(conditional, abs=1e-12)
    assert c.combined_transfer_entropy(s, a, r) == pytest.approx(conditional, abs=1e-12)
    local = pyinform.transfer_entropy(s, r, k=1, local=True).ravel()
    assert c.pointwise_transfer_entropy(s, r) == pytest.approx(local, abs=1e-12)
    mutual = pyinform.mutual_info(s[:-1], r[1:])
    assert c.mutual_information(s, r) == pytest.approx(mutual, abs=1e-12)


recordings = st.lists(
    st.integers(2, 14).flatmap(
        lambda n: st.tuples(*(st.lists(st.integers(0, 2), min_size=n, max_size=n) for _ in range(3)))
    ),
    min_size=1,
    max_size=3,
)


@settings(max_examples=60, deadline=None)
@given(recordings)
def test_agrees_with_the_formulas(parts):
    s, a, r = ([list(part[i]) for part in parts] for i in range(3))
    h = Histogram(transitions(s, a, r))
    assert c.transfer_entropy(s, r) == pytest.approx(flow(h, "s"), abs=1e-10)
    assert c.combined_transfer_entropy(s, a, r) == pytest.approx(flow(h, "s", "a"), abs=1e-10)
    assert c.state_action_contingency(s, a, r) == pytest.approx(contingency(h), abs=1e-10)
    assert c.mutual_information(s, r) == pytest.approx(flow(h, "s", before=""), abs=1e-10)
    assert c.conditional_mutual_information(s, r, a) == pytest.approx(flow(h, "s", "a", before=""), abs=1e-10)
    e = c.contingent_saliency(s, a, r)
    pairs = {(row[1], row[2]) for row in h.observed}
    for before, source, after, action in np.ndindex(e.shape):
        if (before, source) in pairs:
            expected = saliency(h, after, action, before, source)
            assert e[before, source, after, action] == pytest.approx(expected, abs=1e-10)
        else:
            assert np.isnan(e[before, source, after, action])
    weighted = sum(h.p(r=before, s=source) * e[before, source].sum() for before, source in pairs)
    assert weighted == pytest.approx(contingency(h), abs=1e-10)


@settings(max_examples=40, deadline=None)
@given(recordings)
def test_identities(parts):
    s, a, r = ([list(part[i]) for part in parts] for i in range(3))
    sac, both = c.state_action_contingency(s, a, r), c.transfer_entropy(c.joint(s, a), r)
    assert sac == pytest.approx(c.state_action_contingency(a, s, r), abs=1e-10)
    assert sac == pytest.approx(c.combined_transfer_entropy(s, a, r) - c.transfer_entropy(s, r), abs=1e-10)
    assert both == pytest.approx(c.transfer_entropy(a, r) + c.combined_transfer_entropy(s, a, r), abs=1e-10)
    assert c.combined_transfer_entropy(s, a, r) >= -1e-12
    for normalise in ("result", "smallest"):
        assert -1e-9 <= c.transfer_entropy(s, r, normalise=normalise) <= 1 + 1e-9
        assert -1e-9 <= c.combined_transfer_entropy(s, a, r, normalise=normalise) <= 1 + 1e-9
        assert abs(c.state_action_contingency(s, a, r, normalise=normalise)) <= 1 + 1e-9
    assert c.linear_granger(s, r, a) >= 0


@settings(max_examples=30, deadline=None)
@given(recordings, st.lists(st.integers(0, 10**12), min_size=3, max_size=3, unique=True))
def test_sparse_codes_change_nothing(parts, names):
    s, a, r = ([list(part[i]) for part in parts] for i in range(3))
    renamed = [[[names[value] for value in part] for part in series] for series in (s, a, r)]
    assert five(*renamed) == pytest.approx(five(s, a, r), abs=1e-10)


def test_counting_by_sorting_gives_the_same(monkeypatch):
    s, a, r = random_series(1)
    dense = five(s, a, r)
    monkeypatch.setattr(table, "DENSE", 0)
    monkeypatch.setattr(table.Steps, "transitions", 10, raising=False)
    assert five(s, a, r) == pytest.approx(dense, abs=1e-12)


def test_types_change_nothing():
    s, a, r = random_series(1)
    expected = five(s, a, r)
    for types in ((np.int32, np.int32, np.int32), (np.int8, np.int64, np.int32), (np.uint8, np.uint64, float)):
        assert five(*(x.astype(kind) for x, kind in zip((s, a, r), types, strict=True))) == pytest.approx(expected)
    assert c.transfer_entropy(s.astype(np.int32), r) == pytest.approx(expected[3])


def test_more_transitions_of_a_kind_than_are_listed():
    """Counts whose logarithm is computed."""
    s, a, r = (np.tile(series, 60) for series in random_series(1))
    h = table.steps(s, r, a).entries()
    assert h.counts.max() < 4096 < h.marginal("r").max()
    assert c.combined_transfer_entropy(s, a, r) == pytest.approx(
        c.combined_transfer_entropy(s, a, r, correction="miller_madow")
        + information.COMBINED.bias(h, "miller_madow") / np.log(2)
    )


def test_many_values_need_little_memory():
    n = 20_000
    s = np.arange(n) * 10**12
    assert c.transfer_entropy(s, np.arange(n) % 2) == pytest.approx(0, abs=1e-9)
    assert c.combined_transfer_entropy(s, s + 1, s + 2) == pytest.approx(0, abs=1e-9)


def test_pointwise():
    s, a, r = random_series(2)
    halves = [[series[:150], series[150:]] for series in (s, a, r)]
    for pointwise, measure, order in [
        (c.pointwise_combined_transfer_entropy, c.combined_transfer_entropy, "sar"),
        (c.pointwise_state_action_contingency, c.state_action_contingency, "sar"),
        (c.pointwise_mutual_information, c.mutual_information, "sr"),
        (c.pointwise_conditional_mutual_information, c.conditional_mutual_information, "sra"),
        (c.pointwise_transfer_entropy, c.transfer_entropy, "sra"),
    ]:
        given = dict(zip("sar", (s, a, r), strict=True))
        local = pointwise(*(given[name] for name in order))
        assert local.shape == (len(r) - 1,)
        assert local.mean() == pytest.approx(measure(*(given[name] for name in order)), abs=1e-12)
        given = dict(zip("sar", halves, strict=True))
        parts = pointwise(*(given[name] for name in order))
        assert [len(part) for part in parts] == [149, len(r) - 151]
        assert np.concatenate(parts).mean() == pytest.approx(measure(*(given[name] for name in order)), abs=1e-12)


def test_nothing_crosses_from_one_recording_into_the_next():
    copied = [np.array([0, 1, 0, 1]), np.array([0, 1, 0, 1])]
    assert c.mutual_information(copied, copied) == pytest.approx(0.918296, abs=1e-6)
    assert table.steps(copied, copied).transitions == 6


def test_one_value_says_nothing():
    s, a, r = random_series(3)
    flat = np.zeros_like(r)
    for measured in (five(flat, a, r)[1], five(s, a, flat), five(flat, flat, flat), c.linear_granger(s, flat)):
        assert measured == pytest.approx(np.zeros(np.shape(measured)), abs=1e-12)
    for normalise in ("result", "smallest"):
        assert c.state_action_contingency(flat, flat, flat, normalise=normalise) == 0
    assert c.transfer_entropy(flat, r, correction="miller_madow") == pytest.approx(0, abs=1e-12)
    assert c.transfer_entropy(flat, r, correction="shuffle") == pytest.approx(0, abs=1e-12)


def test_base():
    s, a, r = random_series(4)
    bits = c.state_action_contingency(s, a, r)
    assert c.state_action_contingency(s, a, r, base=np.e) == pytest.approx(bits * np.log(2))
    assert c.state_action_contingency(s, a, r, 4) == pytest.approx(bits / 2)
    with pytest.raises(SeriesError, match="base"):
        c.state_action_contingency(s, a, r, 1)


@pytest.mark.parametrize("measure", [c.transfer_entropy, c.combined_transfer_entropy, c.state_action_contingency])
def test_corrections_take_the_bias_off(measure):
    """Independent variables: each correction's mean is a small part of the plug-in's."""
    values: dict[str, list[float]] = {}
    for seed in range(60):
        rng = np.random.default_rng(seed)
        series = [rng.integers(0, k, 400) for k in ((5, 2) if measure is c.transfer_entropy else (5, 3, 2))]
        for correction in ("none", "miller_madow", "degrees_of_freedom", "shuffle"):
            value = measure(*series, correction=correction, seed=seed)
            values.setdefault(correction, []).append(value)
    mean = {correction: np.mean(of) for correction, of in values.items()}
    assert mean["none"] > 0.01
    for correction in ("miller_madow", "degrees_of_freedom", "shuffle"):
        assert abs(mean[correction]) < 0.15 * mean["none"], correction


def test_degrees_of_freedom_by_hand():
    """Two contexts r; in one, s takes 3 and r' 2 values, in the other s takes 1: df = 2."""
    s = [[value, 0] for value in (0, 1, 2, 0)] + [[1, 0]]
    r = [[0, after] for after in (0, 1, 1, 0)] + [[1, 1]]
    plain = c.transfer_entropy(s, r, base=np.e)
    corrected = c.transfer_entropy(s, r, base=np.e, correction="degrees_of_freedom")
    assert plain - corrected == pytest.approx(2 / (2 * 5))
    occupied = c.transfer_entropy(s, r, base=np.e, correction="miller_madow")
    assert plain - occupied == pytest.approx((2 + 4 - 3 - 4) / (2 * 5))


def test_unknown_choices():
    s, a, r = random_series(5)
    for wrong in ({"correction": "magic"}, {"normalise": "loud"}, {"correction": "shuffle", "surrogates": 0}):
        with pytest.raises(SeriesError, match=next(iter(wrong)) if len(wrong) == 1 else "surrogates"):
            c.state_action_contingency(s, a, r, **wrong)
    with pytest.raises(SeriesError, match="seed"):
        c.state_action_contingency(s, a, r, correction="shuffle", seed=-1)


def test_saliency_refuses_codes_that_index_nothing():
    s, a, r = random_series(6)
    with pytest.raises(SeriesError, match="recode"):
        c.contingent_saliency(s * 10**12, a, r)
    assert c.contingent_saliency(c.recode(s * 10**12)[0], a, r).shape == (3, 4, 3, 3)


class TestGranger:
    def test_sees_what_adds_up(self):
        s, _, r = random_series(7, 3000)
        noise = np.random.default_rng(0).random(3000) < 0.1
        r = np.concatenate([[0], s[:-1] % 2]) ^ noise
        assert c.linear_granger(s, r) > 0.2
        assert c.linear_granger(s[:-1], s[:-1]) == pytest.approx(0, abs=1e-9)
        assert c.linear_granger(s, np.concatenate([[0], s[:-1]])) == float("inf")

    def test_does_not_see_what_hangs_together(self):
        s, a, r = every_case(lambda s, a: int(s == a), 3)
        assert c.linear_granger(s, r, a) == pytest.approx(0, abs=1e-12)
        assert c.combined_transfer_entropy(s, a, r) > 0.9

    def test_half_the_log_ratio_of_variances(self):
        """For two values of r', against least squares with numpy on every single step."""
        s, a, r = random_series(8, 500, (3, 4, 2))
        x = [np.eye(k)[codes[:-1]] for codes, k in ((r, 2), (a, 4), (s, 3))]
        rest = [np.linalg.lstsq(np.hstack(x[:k]), r[1:].astype(float), rcond=None)[0] for k in (2, 3)]
        sums = [np.sum((r[1:] - np.hstack(x[:k]) @ w) ** 2) for k, w in zip((2, 3), rest, strict=True)]
        assert c.linear_granger(s, r, a) == pytest.approx(0.5 * np.log2(sums[0] / sums[1]), abs=1e-10)

    def test_results_of_several_values(self):
        """Half the logarithm of the ratio of the residuals' determinants."""
        s, a, r = random_series(9, 400)
        context = np.hstack([np.eye(3)[r[:-1]], np.eye(3)[a[:-1]]])
        y = np.eye(3)[r[1:]][:, 1:]
        logs = []
        for x in (context, np.hstack([context, np.eye(4)[s[:-1]]])):
            residual = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
            logs.append(np.linalg.slogdet(residual.T @ residual)[1])
        assert c.linear_granger(s, r, a) == pytest.approx((logs[0] - logs[1]) / 2 / np.log(2), abs=1e-10)

    def test_too_many_values(self):
        with pytest.raises(SeriesError, match="1000"):
            c.linear_granger(np.arange(3000), np.arange(3000) % 2)


@pytest.mark.integration
def test_imports_nothing_heavy():
    heavy = ("mujoco", "cv2", "dm_control", "torch", "matplotlib")
    program = (
        "import sys\n"
        "from jointattn_mj.contingency import discovery\n"
        "from jointattn_mj.recordings import reader\n"
        f"found = [name for name in {heavy!r} if name in sys.modules]\n"
        "assert not found, found"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.uint16, np.int32, np.uint32, np.int64, np.uint64])
def test_transitions_counted_in_pairs_are_those_counted_one_by_one(kind):
    """Long series with few codes are counted two transitions at a time, of whatever type they are."""
    source, target, condition = (np.random.default_rng(k).integers(0, k, 5001).astype(kind) for k in (4, 2, 3))
    for known, sizes in ((None, (2, 1, 4, 2)), (condition, (2, 3, 4, 2))):
        expected = np.zeros(sizes, int)
        zero = np.zeros(len(source), int) if known is None else known
        np.add.at(expected, (target[:-1], zero[:-1], source[:-1], target[1:]), 1)
        counted = table.steps(source, target, known).dense()
        assert np.array_equal(counted, expected)
        parts = [[part[:2], part[2:2000], part[2000:]] for part in (source, target)]
        cut = table.steps(*parts, None if known is None else [known[:2], known[2:2000], known[2000:]]).dense()
        crossing = [1, 1999]
        np.subtract.at(expected, (target[crossing], zero[crossing], source[crossing], target[[2, 2000]]), 1)
        assert np.array_equal(cut, expected)


LONG_SIZES = (4, 2, 3)


def long_series(kind=np.int64, steps=20_000):
    """Source, target and condition that are long enough to be checked while they are counted."""
    return [np.random.default_rng(k).integers(0, k, steps).astype(kind) for k in LONG_SIZES]


@pytest.mark.parametrize("kind", [bool, np.int8, np.uint8, np.int16, np.uint32, np.int64, np.uint64])
def test_long_arrays_are_counted_as_checked_ones_are(kind):
    source, target, condition = long_series(kind)
    for known in (None, condition):
        at_once = table.counted_at_once(source, target, known)
        np.testing.assert_array_equal(at_once, table.steps(source, target, known).dense())
    parts = [[series] for series in (source, target, condition)]
    assert table.counted_at_once(*parts) is None
    assert c.transfer_entropy(source, target) == c.transfer_entropy(*parts[:2])
    for measure in (c.transfer_entropy, c.combined_transfer_entropy, c.state_action_contingency):
        assert measure(source, condition, target) == measure(parts[0], parts[2], parts[1])


@pytest.mark.parametrize("late", range(3))
def test_a_code_that_is_high_only_late_is_counted_too(late):
    series = long_series()
    series[late][[15_000, -1]] = LONG_SIZES[late]
    assert table.counted_at_once(*series) is None
    assert c.transfer_entropy(*series) == c.transfer_entropy(*([part] for part in series))


@pytest.mark.parametrize("kind", [np.int8, np.int16, np.int32, np.int64])
@pytest.mark.parametrize("at", [3, 15_000, 19_999])
@pytest.mark.parametrize(("number", "name"), [(0, "source"), (1, "target"), (2, "condition")])
def test_a_negative_code_in_a_long_array_is_an_error(number, name, at, kind):
    series = long_series(kind)
    series[number][at] = -1
    with pytest.raises(SeriesError, match=f"codes of {name} must be 0 or more; got -1 at step {at}"):
        c.transfer_entropy(*series)


@pytest.mark.parametrize(("kind", "code"), [(np.int8, 127), (np.uint8, 255), (bool, 1)])
def test_the_highest_code_of_a_small_type_is_counted(kind, code):
    source, target = np.zeros((2, 20_000), kind)
    source[::3], target[::2] = code, 1
    assert table.counted_at_once(source, target, None) is not None
    assert c.transfer_entropy(source, target) == c.transfer_entropy([source], [target])


def test_long_arrays_of_other_kinds_are_measured_all_the_same():
    source, target, _ = long_series()
    expected = c.transfer_entropy([source], [target])
    foreign = [part.astype(">i8") for part in (source, target)]
    strided = [np.repeat(part, 2)[::2] for part in (source, target)]
    mixed = source.astype(np.int8), target
    floats = [part.astype(float) for part in (source, target)]
    for other in (foreign, strided, mixed, floats, [source.tolist(), target.tolist()]):
        assert c.transfer_entropy(*other) == expected
    with pytest.raises(SeriesError, match="equally long; got 20000 and 19999 steps"):
        c.transfer_entropy(source, target[1:])
    with pytest.raises(SeriesError, match="one dimension"):
        c.transfer_entropy(source[:, None], target)
