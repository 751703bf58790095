"""Arrow's arrays that are made without what computes with them."""

import numpy as np
import pytest

from jointattn_mj.io.arrow import number_array, word_array

MISSING = np.array([False, True, False])


@pytest.mark.parametrize("missing", [None, MISSING, ~MISSING, np.zeros(3, bool), np.ones(3, bool)])
def test_what_is_missing_is_null(missing):
    gaps = [False] * 3 if missing is None else missing
    for make, values in ((word_array, np.array(["red", "grün", ""])), (number_array, np.array([True, False, True]))):
        expected = [None if gap else value for value, gap in zip(values.tolist(), gaps, strict=True)]
        assert make(values, missing).to_pylist() == expected
