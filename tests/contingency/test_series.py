"""Series: what is taken, what is refused by name, several variables as one, codes of any size."""

import numpy as np
import pytest

import jointattn_mj.contingency as c
from jointattn_mj.contingency import Stacked, joint, recode, transfer_entropy
from jointattn_mj.contingency.series import aligned, check_base, code, combined
from jointattn_mj.errors import JointAttnError, SeriesError

GOOD = np.array([0, 1, 1, 0, 1])


@pytest.mark.parametrize(
    "series",
    [
        [0, 1, 1, 0, 1],
        (0, 1, 1, 0, 1),
        GOOD.astype(np.int8),
        GOOD.astype(np.uint64),
        GOOD.astype(bool),
        GOOD.astype(float),
        [GOOD],
        np.array([9, 0, 9, 1, 9, 1, 9, 0, 9, 1])[1::2],
    ],
)
def test_what_is_one_series(series):
    coded = code(series)
    assert coded.codes.tolist() == GOOD.tolist()
    assert coded.bounds.tolist() == [0, 5]
    assert coded.size == 2


def test_recordings():
    coded = code([[0, 1], np.array([2, 0, 1])])
    assert coded.bounds.tolist() == [0, 2, 5]
    assert [part.tolist() for part in coded.split()] == [[0, 1], [2, 0, 1]]


ARRAYS = {
    "int32": [GOOD.astype(np.int32), np.array([3, 0], np.int32)],
    "int8": [GOOD.astype(np.int8), np.array([3, 0], np.int8)],
    "uint32": [GOOD.astype(np.uint32), np.array([3, 0], np.uint32)],
    "of several types": [GOOD.astype(np.int16), np.array([3, 0], np.uint32)],
    "with truth values": [GOOD, np.array([True, False])],
    "of the other byte order": [GOOD.astype(">i4"), np.array([3, 0], ">i4")],
    "with gaps": [np.repeat(GOOD, 2)[::2], np.array([3, 9, 0])[::2]],
    "read only": [np.frombuffer(GOOD.tobytes(), GOOD.dtype), GOOD],
    "of large codes": [GOOD * 10**12, GOOD],
}


@pytest.mark.parametrize("kind", ARRAYS)
@pytest.mark.parametrize("other", ARRAYS)
def test_arrays_joined_at_once_are_what_lists_of_numbers_are(kind, other):
    """All series of a call, whatever their types."""
    lengths = [min(map(len, both)) for both in zip(ARRAYS[kind], ARRAYS[other], strict=True)]
    arrays = [[array[:n] for array, n in zip(ARRAYS[name], lengths, strict=True)] for name in (kind, other, kind)]
    numbers = [[array.tolist() for array in series] for series in arrays]
    joined, looked_at = aligned(s=arrays[0], a=None, r=arrays[1]), aligned(s=numbers[0], a=None, r=numbers[1])
    assert joined[1] is looked_at[1] is None
    for left, right in ((joined[0], looked_at[0]), (joined[2], looked_at[2]), (code(arrays[0]), code(numbers[0]))):
        assert left.codes.dtype in (np.int32, np.int64)
        for field in ("codes", "bounds", "size", "values"):
            np.testing.assert_array_equal(getattr(left, field), getattr(right, field))
    assert transfer_entropy(*arrays) == transfer_entropy(*numbers)
    assert [codes.tolist() for codes in joint(*arrays)] == [codes.tolist() for codes in joint(*numbers)]


BAD = {
    "empty": ([], "empty"),
    "empty array": (np.array([], int), "at least 2 steps"),
    "one step": ([1], "at least 2 steps"),
    "short recording": ([[0, 1], [1]], "recording 1 of s"),
    "negative": ([0, -3], "-3"),
    "negative in a recording": ([GOOD, [0, -3]], "recording 1 of s must be 0 or more; got -3 at step 1"),
    "negative in an array": ([GOOD, -GOOD], "recording 1 of s must be 0 or more; got -1 at step 1"),
    "a column": ([GOOD[:, None], GOOD[:, None]], "recording 0 of s must have one dimension"),
    "a column among arrays": ([GOOD, GOOD[:, None]], "recording 1 of s must have one dimension"),
    "a short array": ([GOOD, GOOD[:1]], "recording 1 of s needs at least 2 steps"),
    "a masked array": ([GOOD, np.ma.array(GOOD, mask=GOOD > 0)], "recording 1 of s has 3 masked"),
    "an array of text": ([GOOD, GOOD.astype(str)], "recording 1 of s must hold whole numbers"),
    "a fraction in an array": ([GOOD, GOOD / 2], "recording 1 of s must hold whole numbers; got 0.5 at step 1"),
    "a text": ([GOOD, "left"], "recording 1 of s"),
    "fraction": ([0.0, 1.5], "1.5"),
    "missing": ([0.0, np.nan, np.nan], "2 missing"),
    "infinite": ([0.0, np.inf], "inf"),
    "masked": (np.ma.array([1, 2, 3], mask=[0, 1, 0]), "1 masked"),
    "text": (["left", "right"], "whole numbers"),
    "none": ([None, 1], "whole numbers"),
    "two dimensions": (np.zeros((5, 2), int), "joint"),
    "no dimension": (3, "one dimension"),
    "ragged": ([[0, [1]], [0, 1]], "s"),
    "huge": (np.array([0, 2**63], np.uint64), "2\\*\\*62"),
    "complex": ([1j, 2j], "whole numbers"),
    "a recording of dates": ([GOOD, GOOD.astype("datetime64[s]")], "recording 1 of s must hold whole numbers"),
    "a recording without dimension": ([GOOD, np.array(3)], "recording 1 of s must have one dimension"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_none(case):
    series, words = BAD[case]
    with pytest.raises(SeriesError, match=words) as caught:
        code(series, "s")
    with pytest.raises(SeriesError) as beside_another:
        aligned(r=[GOOD, GOOD], s=series)
    assert str(beside_another.value) == str(caught.value)
    assert isinstance(caught.value, JointAttnError)
    assert isinstance(caught.value, ValueError)


def test_lengths_must_agree():
    with pytest.raises(SeriesError, match=r"source and target .* 5 and 4"):
        transfer_entropy(GOOD, GOOD[:4])
    with pytest.raises(SeriesError, match=r"\[2, 3\] and \[3, 2\]"):
        aligned(s=[GOOD[:2], GOOD[2:]], r=[GOOD[:3], GOOD[3:]])


def test_a_source_and_a_target_are_needed():
    with pytest.raises(SeriesError, match="a source and a target are needed"):
        transfer_entropy(None, None)


@pytest.mark.parametrize("base", [1, 0.5, 0, -2, np.nan, np.inf, "2", None, np.array([2.0])])
def test_bad_base(base):
    with pytest.raises(SeriesError, match="base"):
        check_base(base)


@pytest.mark.parametrize("base", [np.int8(2), np.float32(2)])
def test_a_base_of_a_small_type_has_the_whole_logarithm(base):
    assert check_base(base) == np.log(2)


def test_joint():
    assert joint([0, 0, 1, 1, 0], [5, 7, 5, 7, 7]).tolist() == [0, 1, 2, 3, 1]
    two = joint([[0, 1], [1, 0]], [[0, 1], [1, 1]])
    assert [part.tolist() for part in two] == [[0, 2], [2, 1]]
    with pytest.raises(SeriesError, match="series 2"):
        joint([0, 1], [0, 1, 2])
    with pytest.raises(SeriesError):
        joint()


def test_recode():
    codes, values = recode([10**12, 7, 10**12])
    assert (codes.tolist(), values.tolist()) == ([1, 0, 1], [7, 10**12])
    codes, values = recode([[3, 1], [1, 0]])
    assert ([part.tolist() for part in codes], values.tolist()) == ([[2, 1], [1, 0]], [0, 1, 3])


def test_combined_never_overflows():
    rng = np.random.default_rng(0)
    columns = [rng.integers(0, 2**40, 1000) for _ in range(4)]
    columns = [np.concatenate([column, column]) for column in columns]
    keys, bound = combined(columns, [2**40] * 4)
    assert bound < 2**62
    assert keys.min() >= 0
    assert (keys[:1000] == keys[1000:]).all()
    assert len(np.unique(keys)) == 1000


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int16, np.int32, np.int64, np.uint64, float])
def test_rows_are_recordings(kind):
    arrays = [np.random.default_rng(k).integers(0, k, (30, 12)).astype(kind) for k in (4, 2, 3)]
    rows, lists = [Stacked(array) for array in arrays], [list(array) for array in arrays]
    assert c.transfer_entropy(*rows) == c.transfer_entropy(*lists)
    for ours, listed in zip(c.pointwise_transfer_entropy(*rows), c.pointwise_transfer_entropy(*lists), strict=True):
        np.testing.assert_array_equal(ours, listed)
    assert c.transfer_entropy(rows[0], lists[1], arrays[2].tolist()) == c.transfer_entropy(*lists)
    turned = [Stacked(np.asfortranarray(array)) for array in arrays]
    assert c.transfer_entropy(*turned) == c.transfer_entropy(*lists)


def test_no_series_is_an_error():
    with pytest.raises(SeriesError, match="series must"):
        code(None)


def test_some_rows():
    rows = Stacked(np.arange(12).reshape(3, 4))
    assert repr(rows) == "Stacked(3 recordings of 4 steps)"
    assert len(rows) == 3
    np.testing.assert_array_equal(rows[1], [4, 5, 6, 7])
    assert isinstance(rows[1:], Stacked)
    assert [len(row) for row in rows[1:]] == [4, 4]
    codes, values = c.recode(rows[:2])
    np.testing.assert_array_equal(codes, rows.array[:2])
    np.testing.assert_array_equal(values, np.arange(8))


@pytest.mark.parametrize(
    ("array", "message"),
    [
        ([0, 1, 1], r"Stacked takes an array \(k, T\), a recording a row; got shape \(3,\)"),
        ([[0, 1], [1]], "Stacked takes an array"),
        (np.zeros((0, 5), int), "series is empty"),
        (np.zeros((4, 1), int), "recording 0 of series needs at least 2 steps"),
        ([[0, 1], [0, -2]], "codes of recording 1 of series must be 0 or more; got -2 at step 1"),
        ([[0, 1], [0, np.nan]], "recording 1 of series has 1 missing values"),
        ([["a", "b"]], "series must hold whole numbers"),
        (np.ma.masked_less([[0, 1], [0, -2]], 0), "got 1 masked values"),
        ([np.arange(2), np.ma.masked_less([0, -2], 0)], "got 1 masked values"),
    ],
    ids=str,
)
def test_rows_that_cannot_be_measured(array, message):
    with pytest.raises(SeriesError, match=message):
        code(Stacked(array))


def test_a_bare_array_of_two_dimensions_is_ambiguous():
    with pytest.raises(SeriesError, match=r"list of arrays or as Stacked\(array\), and take several variables"):
        code(np.zeros((3, 4), int))
