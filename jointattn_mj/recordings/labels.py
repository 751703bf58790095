"""Labels of a column: which values are missing, which are the same, and in which order they get their codes."""

import re
from decimal import Decimal
from typing import Any

import numpy as np

from jointattn_mj.errors import SeriesError

MISSING = frozenset(
    {"", "NA", "N/A", "n/a", "#N/A", "#N/A N/A", "#NA", "NULL", "null", "NaN", "nan", "-NaN", "-nan"}
    | {"1.#IND", "-1.#IND", "1.#QNAN", "-1.#QNAN"}
)
"""Values that stand for none, blanks around them left out: nothing, and what statistics programs write."""

_WHOLE = re.compile(r"-?(0|[1-9]\d{0,299})")
_NUMBER = re.compile(r"[+-]?(\d{1,300}[.,]?\d{0,300}|[.,]\d{1,300})([eE][+-]?\d{1,2})?")


def coded(column: Any, name: str, identifies: bool = False) -> tuple[np.ndarray, tuple[str, ...]]:
    """Codes (rows,) of a dictionary-encoded pyarrow column, -1 where missing, and their labels in order.

    Numbers come ascending, with 1.0 and 1,0 the same as 1; other labels in the order of the alphabet. A column that
    ``identifies`` recordings holds names, whatever they look like.

    Raises:
        SeriesError: Numbers with fractions, unless they identify.
    """
    array = column.unify_dictionaries().combine_chunks()
    if hasattr(array, "num_chunks"):  # some versions keep the wrapper
        array = array.chunk(0)
    indices = array.indices.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64)
    written = [label.strip() for label in array.dictionary.to_pylist()]
    labels = ordered({label for label in written if label not in MISSING}, name, identifies)
    number = {label: i for i, label in enumerate(dict.fromkeys(labels.values()))}
    codes = np.array([-1 if label in MISSING else number[labels[label]] for label in written] + [-1], np.int64)
    return codes[indices], tuple(number)


def ordered(labels: set[str], name: str, identifies: bool = False) -> dict[str, str]:
    """From labels as written to labels as they count, in order."""
    if labels and all(_WHOLE.fullmatch(label) for label in labels):
        return {label: label for label in sorted(labels, key=int)}
    alphabetical = sorted(labels)
    as_written = {label: label for label in alphabetical}
    if not all(_NUMBER.fullmatch(label) for label in labels) or any(re.match(r"[+-]?0\d", one) for one in labels):
        return as_written
    numbers = {label: Decimal(label.replace(",", ".")) for label in alphabetical}
    for label, value in numbers.items():
        if value != value.to_integral_value():
            if identifies:
                return as_written
            raise SeriesError(
                f"column {name!r} holds numbers with fractions, such as {label}; sort them into bins first, "
                "and give each bin a label"
            )
    return {label: str(int(numbers[label])) for label in sorted(labels, key=numbers.__getitem__)}


def sorted_names(names: set[str]) -> list[str]:
    """Names as they are: whole numbers ascending, others in the order of the alphabet."""
    return sorted(names, key=int if names and all(_WHOLE.fullmatch(name) for name in names) else None)
