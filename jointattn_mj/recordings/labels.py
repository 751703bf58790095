"""Labels of a column: which values are missing, which are the same, and in which order they get their codes."""

import re
from collections.abc import Collection
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
_DECIMAL = re.compile(r"[+-]?(\d{1,300}[.,]?\d{0,300}|[.,]\d{1,300})")
_NUMBER = re.compile(_DECIMAL.pattern + r"([eE][+-]?\d{1,2})?")


def coded(
    column: Any, name: str, identifies: bool = False, missing: Collection[str] = (), fractions: bool = False
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Codes of a column, and what they stand for.

    Args:
        column: A dictionary-encoded pyarrow column of text (rows,).
        name: What messages call it.
        identifies: Whether it holds names of recordings, which stay as they are written.
        missing: Further values that stand for none.
        fractions: Whether numbers with fractions are labels like others.

    Returns:
        Codes (rows,), -1 where missing, and their labels in order: numbers ascending, with 1.0 and 1,0 the same as 1;
        other labels in the order of the alphabet.

    Raises:
        SeriesError: Numbers with fractions, unless they are allowed.
    """
    array = column.unify_dictionaries().combine_chunks()
    if hasattr(array, "num_chunks"):  # some versions keep the wrapper
        array = array.chunk(0)
    indices = array.indices.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64)
    written = [label.strip() for label in array.dictionary.to_pylist()]
    none = missing_labels(written, missing)
    present = {label for label in written if label not in none}
    labels = {label: label for label in sorted_names(present)} if identifies else ordered(present, name, fractions)
    number = {label: i for i, label in enumerate(dict.fromkeys(labels.values()))}
    codes = np.array([-1 if label in none else number[labels[label]] for label in written] + [-1], np.int64)
    return codes[indices], tuple(number)


def missing_labels(labels: Collection[str], missing: Collection[str]) -> frozenset[str]:
    """Those of some labels that stand for none; a number such as -99 stands for -99.0 and -99,0 too."""
    codes = {code.strip() for code in missing}
    numbers = {_number(code) for code in codes} - {None}
    return frozenset(
        label for label in labels if label in MISSING or label in codes or (numbers and _number(label) in numbers)
    )


def ordered(labels: set[str], name: str, fractions: bool = False) -> dict[str, str]:
    """From labels as written to labels as they count, in order.

    Numbers with an exponent, such as 2E1, and with zeros in front, such as 01, are names and stay as they are written.

    Args:
        labels: Different labels as written.
        name: Of what they are labels of, for messages.
        fractions: Take numbers with fractions, such as 1.5, for names; they are refused otherwise.
    """
    if labels and all(_WHOLE.fullmatch(label) for label in labels):
        return {label: label for label in sorted(labels, key=int)}
    as_written = {label: label for label in sorted(labels)}
    if not all(_NUMBER.fullmatch(label) for label in labels) or any(re.match(r"[+-]?0\d", label) for label in labels):
        return as_written
    numbers = {label: Decimal(label.replace(",", ".")) for label in as_written}
    for label, value in numbers.items():
        if value != value.to_integral_value():
            if fractions:
                return as_written
            raise SeriesError(
                f"column {name!r} holds numbers with fractions, such as {label}; sort them into bins first, and give "
                "each bin a label. If they are names, say `fractions='names'`"
            )
    if not all(_DECIMAL.fullmatch(label) for label in labels):
        return as_written
    return {label: str(int(numbers[label])) for label in sorted(labels, key=numbers.__getitem__)}


def sorted_names(names: set[str]) -> list[str]:
    """Names as they are: whole numbers ascending, others in the order of the alphabet."""
    return sorted(names, key=int if names and all(_WHOLE.fullmatch(name) for name in names) else None)


def _number(text: str) -> Decimal | None:
    return Decimal(text.replace(",", ".")) if _DECIMAL.fullmatch(text) else None
