"""Tables of results: access by column, conversion, equality, files."""

import doctest
import sys
import types

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

import jointattn_mj.io.table
from jointattn_mj.errors import ExtraError, OutputError
from jointattn_mj.io.table import WIDTH, Table
from jointattn_mj.options import RenamedWarning

NAMES = pa.DictionaryArray.from_arrays(pa.array([0, 1, None], pa.int8()), pa.array(["red", "face"]))
COLUMNS = {"time_s": [0.0, None, float("nan")], "name": NAMES, "success": [True, None, False], "n": [1, 2, 3]}


def table() -> Table:
    return Table(pa.table(COLUMNS))


def test_columns_are_numpy_arrays():
    first = table()
    assert np.isnan(first["time_s"]).tolist() == [False, True, True]
    assert first["name"].tolist() == ["red", "face", None]
    assert first["success"].tolist() == [True, None, False]
    assert first["n"].dtype == np.int64
    assert first.columns == tuple(first) == tuple(COLUMNS)
    assert len(first) == 3
    assert "n" in first and "m" not in first


def test_an_unknown_column_is_named_with_the_nearest_known_one():
    with pytest.raises(KeyError, match="perhaps you meant 'success'"):
        table()["sucess"]
    with pytest.raises(KeyError, match="there are time_s, name"):
        table().describe("sucess")


def test_a_table_is_the_same_after_writing_and_reading(tmp_path):
    table().write(tmp_path / "table.parquet")
    assert Table.read(tmp_path / "table.parquet") == table()
    for new_names in ({"n": "count"}, lambda name: "count" if name == "n" else name):
        with pytest.warns(RenamedWarning, match="by their new ones: count .n."):
            assert Table.read(tmp_path / "table.parquet", new_names).columns[-1] == "count"


def test_equality_looks_at_names_values_and_what_is_missing():
    other = {**COLUMNS, "time_s": [0.0, float("nan"), float("nan")]}
    assert table() != Table(pa.table(other))
    assert table() != Table(pa.table({**COLUMNS, "n": [1, 2, 4]}))
    assert table() != Table(pa.table(COLUMNS).drop_columns(["n"]))
    assert table() != "table"


def test_pandas_by_one_call():
    frame = table().to_pandas()
    assert isinstance(frame, pd.DataFrame)
    assert list(frame.columns) == list(COLUMNS)


def test_polars_by_one_call(monkeypatch):
    monkeypatch.setitem(sys.modules, "polars", types.SimpleNamespace(from_arrow=lambda arrow: arrow.num_rows))
    assert table().to_polars() == 3
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(ExtraError, match=r"jointattn-mj\[tables\]"):
        table().to_polars()


def test_a_file_that_is_missing_or_no_table_is_named(tmp_path):
    with pytest.raises(OutputError, match="there is no table at"):
        Table.read(tmp_path / "no.parquet")
    (tmp_path / "no.parquet").write_text("no table")
    with pytest.raises(OutputError, match="cannot read the table"):
        Table.read(tmp_path / "no.parquet")


def test_a_repr_fits_a_line():
    wide = Table(pa.table({f"column_{number}": [1] for number in range(100)}))
    assert len(repr(wide)) <= WIDTH
    assert repr(table()) == "Table(3 rows, 4 columns: time_s, name, success, n)"


def test_meanings_come_with_the_columns():
    field = pa.field("n", pa.int64(), metadata={"description": "how many"})
    described = Table(pa.table({"n": [1]}, schema=pa.schema([field])))
    assert (described.describe("n"), table().describe("n")) == ("how many", "")


def test_the_examples_in_docstrings(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert doctest.testmod(jointattn_mj.io.table).failed == 0
