"""The end of a Parquet file, which tells of its columns, read without Arrow: there a wrong byte can end the process.

An error of C++ gets through pyarrow's ``row_group(i).column(j)``, and through nothing else: it opens and reads the same
file with an exception. https://parquet.apache.org/docs/file-format/metadata, in Thrift's compact protocol.
"""

import struct
import sys
from pathlib import Path
from typing import Any, NamedTuple

from harness.files.bounded import open_regular

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


def read_chunks(path: Path) -> list[list[Chunk]]:
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
        told, _ = _struct(footer, 0, 0)
        return [[_chunk(each[3]) for each in group[1]] for group in told[4]]
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
