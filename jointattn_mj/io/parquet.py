"""Tables as Parquet files that are there whole or not at all."""

from collections.abc import Iterable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from jointattn_mj.io.files import write_whole


def write_parquet(path: Path, table: pa.Table) -> None:
    """Write a table.

    Raises:
        OutputError: The file cannot be written.
    """
    write_parts(path, [table])


def write_parts(path: Path, parts: Iterable[pa.Table]) -> None:
    """Write a table that comes in parts of one schema, at least one; each is a row group.

    Raises:
        OutputError: The file cannot be written.
    """

    def write(temporary: Path) -> None:
        rest = iter(parts)
        first = next(rest)
        with pq.ParquetWriter(temporary, first.schema, compression="zstd") as writer:
            writer.write_table(first)
            for part in rest:
                writer.write_table(part)

    write_whole(path, write)
