"""What a Parquet file takes in memory."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from harness.files.parquet import read_chunks, require_room

ROWS = 1_000


def _file(folder, table, texts=None):
    pq.write_table(table, folder / "it")
    return folder / "it", pq.ParquetFile(folder / "it", read_dictionary=texts)


def test_rows_times_columns_count(tmp_path):
    """Of the columns that are read; a list counts all its numbers."""
    table = pa.table({"a": [0.0] * ROWS, "b": pa.FixedSizeListArray.from_arrays([0.0] * 3 * ROWS, 3)})
    file = _file(tmp_path, table)
    require_room(*file, most=4 * ROWS)
    require_room(*file, ["a"], ROWS)
    with pytest.raises(ValueError, match="4,000 numbers, 3,999 are allowed"):
        require_room(*file, most=4 * ROWS - 1)


def test_gaps_in_lists_count_as_numbers(tmp_path):
    """A row without a list takes the room of one."""
    gaps = pa.array([None] * ROWS, pa.list_(pa.float64(), 1_000))
    with pytest.raises(ValueError, match="1,000,000 numbers"):
        require_room(*_file(tmp_path, pa.table({"a": gaps})), most=10**5)


def test_texts_are_read_by_what_they_are_once(tmp_path):
    """Else each row may hold a megabyte."""
    table = pa.table({"a": ["x"] * ROWS})
    with pytest.raises(ValueError, match="a column of string"):
        require_room(*_file(tmp_path, table))
    require_room(*_file(tmp_path, table, ["a"]))


@pytest.mark.parametrize("how", [{}, {"use_dictionary": False}, {"version": "1.0"}, {"write_statistics": False}])
@pytest.mark.parametrize("rows", [0, 1, ROWS])
def test_the_end_of_a_file_tells_what_arrow_reads_there(tmp_path, how, rows):
    """Numbers, bytes and bounds of each column in each group of rows; a truth value or a text has no bounds here."""
    reals = np.linspace(-1e30, 7, rows)
    columns = {"a": reals, "b": reals.astype(np.float32), "c": reals > 0, "d": reals.astype(str)}
    nested = pa.array([None, *[[x] * 3 for x in range(rows)]][:rows], pa.list_(pa.int64()))
    pq.write_table(pa.table({**columns, "e": nested}), tmp_path / "it", row_group_size=300, **how)
    told = pq.read_metadata(tmp_path / "it")
    for number, group in enumerate(read_chunks(tmp_path / "it")):
        for place, chunk in enumerate(group):
            other = told.row_group(number).column(place)
            bounds = other.statistics if place < 2 and other.statistics and other.statistics.has_min_max else None
            wanted = (bounds.min, bounds.max) if bounds else (None, None)
            assert chunk == (other.num_values, other.total_uncompressed_size, *wanted)
    assert len(read_chunks(tmp_path / "it")) == told.num_row_groups


def test_a_footer_is_refused_where_it_tells_of_more_than_it_holds(tmp_path):
    """Cut anywhere, or with any byte another, it is read or refused in bounded memory."""
    pq.write_table(pa.table({"a": [0.5]}), tmp_path / "it")
    whole = (tmp_path / "it").read_bytes()
    length = int.from_bytes(whole[-8:-4], "little")
    refused = 0
    for place in range(len(whole) - 8 - length, len(whole) - 8):
        for byte in (0, 0x19, 0xF9, 0xFC, 0xFF):
            (tmp_path / "it").write_bytes(whole[:place] + bytes([byte]) + whole[place + 1 :])
            try:
                read_chunks(tmp_path / "it")
            except ValueError:
                refused += 1
    assert refused > length
