"""What a Parquet file takes in memory."""

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from harness.files.parquet import require_room

ROWS = 1_000


def _file(folder, table, texts=None):
    pq.write_table(table, folder / "it")
    return pq.ParquetFile(folder / "it", read_dictionary=texts)


def test_rows_times_columns_count(tmp_path):
    """Of the columns that are read; a list counts all its numbers."""
    table = pa.table({"a": [0.0] * ROWS, "b": pa.FixedSizeListArray.from_arrays([0.0] * 3 * ROWS, 3)})
    file = _file(tmp_path, table)
    require_room(file, most=4 * ROWS)
    require_room(file, ["a"], ROWS)
    with pytest.raises(ValueError, match="4,000 numbers, 3,999 are allowed"):
        require_room(file, most=4 * ROWS - 1)


def test_gaps_in_lists_count_as_numbers(tmp_path):
    """A row without a list takes the room of one."""
    gaps = pa.array([None] * ROWS, pa.list_(pa.float64(), 1_000))
    with pytest.raises(ValueError, match="1,000,000 numbers"):
        require_room(_file(tmp_path, pa.table({"a": gaps})), most=10**5)


def test_texts_are_read_by_what_they_are_once(tmp_path):
    """Else each row may hold a megabyte."""
    table = pa.table({"a": ["x"] * ROWS})
    with pytest.raises(ValueError, match="a column of string"):
        require_room(_file(tmp_path, table))
    require_room(_file(tmp_path, table, ["a"]))
