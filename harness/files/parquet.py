"""Parquet files of numbers: written small, and bounded before they are read: a small one may tell of many rows."""

import struct
import sys
from collections import Counter
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq

from harness.arrays import Float
from harness.files.bounded import open_regular, require_regular

MAGIC = b"PAR1"
MOST_BYTES = 2**26
"""The most bytes of a footer."""
MOST_DEPTH = 12
"""How deep structures may lie in one another; a footer has seven levels."""
REALS = {4: "<f", 5: "<d"}
"""How numbers of float32 and float64 stand, by the number of the type."""


class Chunk(NamedTuple):
    """What a file tells of a column in one group of rows.

    Attributes:
        numbers: How many values it holds, gaps included.
        size: Its bytes once they are unpacked.
        least: The smallest value of a column of reals; None where it is not told.
        greatest: The largest one.
    """

    numbers: int
    size: int
    least: float | None
    greatest: float | None


def read_chunks(path: Path) -> tuple[tuple[Chunk, ...], ...]:
    """The columns of each group of rows, in the file's order.

    Args:
        path: The file.

    Raises:
        OSError: See `open_regular`.
        ValueError: It does not end as a Parquet file does.
    """
    with open_regular(path, sys.maxsize) as file:
        end = file.seek(0, 2)
        file.seek(max(0, end - 8))
        tail = file.read(8)
        length = int.from_bytes(tail[:4], "little")
        if tail[4:] != MAGIC or not 0 < length <= min(end - 8, MOST_BYTES):
            raise ValueError("it does not end as a Parquet file does")
        file.seek(end - 8 - length)
        footer = file.read(length)
    try:
        content, _ = _struct(footer, 0, 0)
        return tuple(tuple(_chunk(each[3]) for each in group[1]) for group in content[4])
    except (IndexError, KeyError, TypeError, AttributeError, struct.error) as wrong:
        raise ValueError("its end, which tells of its columns, is damaged") from wrong


def _chunk(told: dict[int, Any]) -> Chunk:
    form = REALS.get(told[1], "")
    found = told.get(12, {}) if form else {}
    ends = (found.get(6, found.get(2)), found.get(5, found.get(1)))
    least, greatest = (None if value is None else float(struct.unpack(form, value)[0]) for value in ends)
    return Chunk(int(told[5]), int(told[6]), least, greatest)


def _struct(footer: bytes, at: int, depth: int) -> tuple[dict[int, Any], int]:
    """A structure's values by the numbers of its fields, and where the next thing begins."""
    if depth > MOST_DEPTH:
        raise ValueError("its end is nested too deeply")
    told: dict[int, Any] = {}
    field = 0
    while head := footer[at]:
        at += 1
        if ahead := head >> 4:
            field += ahead
        else:
            field, at = _whole(footer, at)
        if (kind := head & 15) <= 2:  # a truth value stands in its kind
            told[field] = kind == 1
        elif 4 <= kind <= 6 and (byte := footer[at]) < 128:  # as most are: a whole number in one byte
            told[field], at = (byte >> 1) ^ -(byte & 1), at + 1
        else:
            told[field], at = _value(footer, at, kind, depth)
    return told, at + 1


def _value(footer: bytes, at: int, kind: int, depth: int) -> tuple[Any, int]:
    """A value of one of Thrift's kinds that a footer has."""
    if kind in (4, 5, 6):
        return _whole(footer, at)
    if kind == 8:
        length, at = _count(footer, at)
        return footer[at : at + length], at + length
    if kind in (1, 2, 3):
        return footer[at], at + 1
    if kind == 12:
        return _struct(footer, at, depth + 1)
    if kind == 7:
        return footer[at : at + 8], at + 8
    if kind != 9:
        raise ValueError(f"its end has a value of kind {kind}, which a footer has not")
    head = footer[at]
    at += 1
    length = head >> 4
    if length == 15:
        length, at = _count(footer, at)
    values = []
    for _ in range(length):
        value, at = _value(footer, at, head & 15, depth + 1)
        values.append(value)
    return values, at


def _count(footer: bytes, at: int) -> tuple[int, int]:
    """How many bytes or values follow, each of which takes a byte at least."""
    count, at = _varint(footer, at)
    if count > len(footer) - at:
        raise ValueError("its end tells of more than it holds")
    return count, at


def _whole(footer: bytes, at: int) -> tuple[int, int]:
    """A whole number with its sign, in zigzag form."""
    number, at = _varint(footer, at)
    return (number >> 1) ^ -(number & 1), at


def _varint(footer: bytes, at: int) -> tuple[int, int]:
    """Seven bits a byte, the lowest first."""
    byte = footer[at]
    number, shift = byte & 127, 7
    while byte > 127:
        at += 1
        byte = footer[at]
        number |= (byte & 127) << shift
        shift += 7
        if shift > 70:
            raise ValueError("its end has a number of more than 64 bits")
    return number, at + 1


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
    lists = {f"{it.name}.list.element": it.type.value_type for it in table.schema if hasattr(it.type, "value_type")}
    kinds = {**{it.name: it.type for it in table.schema}, **lists}
    encodings = {name: ENCODINGS[kind] for name, kind in kinds.items() if kind in ENCODINGS}
    pq.write_table(
        table, path, compression="zstd", use_dictionary=False, column_encoding=encodings, write_page_checksum=True
    )


def open_parquet(path: Path, most: int) -> pq.ParquetFile:
    """A regular file of at most `most` bytes; a page with a wrong bit is refused when it is read."""
    require_regular(path, most)
    return pq.ParquetFile(path, page_checksum_verification=True)


def require_room(
    path: Path, file: pq.ParquetFile, columns: Collection[str] | None = None, most: int = MOST_NUMBERS
) -> list[tuple[str, Chunk]]:
    """See that columns of a file take a bounded memory when they are read; gives what the file tells of their chunks.

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
    schema, rows, groups = file.schema_arrow, file.metadata.num_rows, read_chunks(path)
    kinds = dict(zip(schema.names, schema.types, strict=True))
    owners = [name for name, kind in zip(schema.names, schema.types, strict=True) for _ in range(_leaves(kind))]
    if any(len(owners) != len(group) for group in groups):
        raise ValueError("it tells of other columns than it has")
    wanted = kinds.keys() if columns is None else kinds.keys() & columns
    chunks = [(name, chunk) for group in groups for name, chunk in zip(owners, group, strict=True) if name in wanted]
    numbers = Counter({name: rows * _width(kinds[name]) for name in wanted})
    held: Counter[str] = Counter()
    texts = 0
    for name, chunk in chunks:
        held[name] += chunk.numbers
        texts += chunk.size * pa.types.is_dictionary(kinds[name])
    total = sum((numbers | held).values())
    if total > most:
        raise ValueError(f"it has {rows:,} rows of {total:,} numbers, {most:,} are allowed")
    if texts > TEXT_BYTES:
        raise ValueError(f"its texts have {texts:,} bytes, {TEXT_BYTES:,} are allowed")
    return chunks


def _leaves(kind: pa.DataType) -> int:
    """How many of the file's own columns hold the values of a column of this kind."""
    return sum(_leaves(kind.field(place).type) for place in range(kind.num_fields)) or 1


def _width(kind: pa.DataType) -> int:
    """The numbers of a row, gaps included."""
    if pa.types.is_fixed_size_list(kind):
        return int(kind.list_size) * _width(kind.value_type)
    types = pa.types
    texts = types.is_string, types.is_large_string, types.is_binary, types.is_large_binary, types.is_fixed_size_binary
    if any(it(kind) for it in texts):
        raise ValueError(f"it has a column of {kind}, where numbers are read")
    return sum(_width(kind.field(place).type) for place in range(kind.num_fields)) or 1
