"""Parquet files of numbers: written small, and bounded before they are read: a small one may tell of many rows."""

from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from harness.arrays import Float
from harness.files.bounded import require_regular
from harness.files.footer import read_chunks

MOST_NUMBERS = 2**31
"""The most numbers that are read at once, rows times columns: 16 GiB of float64."""
TEXT_BYTES = 2**28
"""The most bytes of texts that are read at once."""
ENCODINGS = {pa.float64(): "BYTE_STREAM_SPLIT", **dict.fromkeys((pa.int32(), pa.int64()), "DELTA_BINARY_PACKED")}


def table_of(rows: Float, schema: pa.Schema) -> pa.Table:
    """A table of the columns of a schema, which stand one after the other in each row, (rows, numbers)."""
    columns, end = list[pa.Array](), 0
    for kind in schema.types:
        is_list = pa.types.is_fixed_size_list(kind)
        begin, end = end, end + (kind.list_size if is_list else 1)
        numbers = rows[:, begin:end].ravel()
        if is_list:
            columns.append(pa.FixedSizeListArray.from_arrays(numbers, kind.list_size))
        else:
            columns.append(pa.array(numbers.astype(kind.to_pandas_dtype(), copy=False)))
    return pa.Table.from_arrays(columns, schema=schema)


def write_packed(table: pa.Table, path: Path) -> None:
    """Write numbers of which hardly one is told twice. A reader can see that no bit of a page is another."""
    encodings = {field.name: ENCODINGS[field.type] for field in table.schema if field.type in ENCODINGS}
    pq.write_table(
        table, path, compression="zstd", use_dictionary=False, column_encoding=encodings, write_page_checksum=True
    )


def open_parquet(path: Path, most: int) -> pq.ParquetFile:
    """A regular file of at most `most` bytes; a page with a wrong bit is refused when it is read."""
    require_regular(path, most)
    return pq.ParquetFile(path, page_checksum_verification=True)


def require_room(
    path: Path, file: pq.ParquetFile, columns: Collection[str] | None = None, most: int = MOST_NUMBERS
) -> None:
    """See that columns of a file take a bounded memory when they are read.

    Rows times columns count, not each alone, and what the parts of the file hold, not only what the whole tells: both
    may lie. Texts have no width, so they are read as `open_texts` reads them.

    Args:
        path: Where the file lies.
        file: It is open, and nothing of it was read.
        columns: Those that will be read; None for all of them.
        most: The numbers that they may have together.

    Raises:
        OSError: The file cannot be read.
        ValueError: They take more, or the file does not tell what they take.
    """
    schema, told, owners = file.schema_arrow, file.metadata, list(_owners(file.schema_arrow))
    groups = read_chunks(path)
    if any(len(owners) != len(group) for group in groups):
        raise ValueError("it tells of other columns than it has")
    wanted = set(schema.names if columns is None else columns)
    numbers = Counter({name: told.num_rows * _width(schema.field(name).type) for name in wanted & {*schema.names}})
    held: Counter[str] = Counter()
    texts = 0
    for group in groups:
        for name, chunk in zip(owners, group, strict=True):
            if name in wanted:
                held[name] += chunk.numbers
                texts += chunk.size * pa.types.is_dictionary(schema.field(name).type)
    total = sum((numbers | held).values())
    if total > most:
        raise ValueError(f"it has {told.num_rows:,} rows of {total:,} numbers, {most:,} are allowed")
    if texts > TEXT_BYTES:
        raise ValueError(f"its texts have {texts:,} bytes, {TEXT_BYTES:,} are allowed")


def _owners(schema: pa.Schema) -> Iterator[str]:
    """The column of each of the file's own columns, which hold the values of nested ones."""
    for field in schema:
        yield from [field.name] * _leaves(field.type)


def _leaves(kind: pa.DataType) -> int:
    return sum(_leaves(kind.field(place).type) for place in range(kind.num_fields)) or 1


def _width(kind: pa.DataType) -> int:
    """The numbers of a row, gaps included."""
    if pa.types.is_fixed_size_list(kind):
        return int(kind.list_size) * _width(kind.value_type)
    if pa.types.is_string(kind) or pa.types.is_large_string(kind) or _is_bytes(kind):
        raise ValueError(f"it has a column of {kind}, where numbers are read")
    return sum(_width(kind.field(place).type) for place in range(kind.num_fields)) or 1


def _is_bytes(kind: pa.DataType) -> bool:
    return bool(pa.types.is_binary(kind) or pa.types.is_large_binary(kind) or pa.types.is_fixed_size_binary(kind))
