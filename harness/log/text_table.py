"""Tables that other programs write, as text or JSON: cells by column, with the line of each row."""

import csv
import io
import json
import math
import re
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.errors import SchemaError
from harness.files.bounded import open_regular, reading
from harness.log.log import is_countable
from harness.text import shortened

MOST_BYTES = 2**27
"""The most bytes that a table may have, unpacked: some four million episodes."""
LONGEST_LINE = 2**20
GZIP, WIDE = b"\x1f\x8b", (b"\xff\xfe", b"\xfe\xff")
"""How a file begins that gzip packed, and text in UTF-16."""
TRUTH = {"true": 1.0, "false": 0.0, "yes": 1.0, "no": 0.0}
NOTHING = ("", "nan", "none", "null")
COMMENT = re.compile(r"#(?<![^\r\n]#)[ \t]*\{[^\r\n]*")
"""A line of JSON behind ``#``."""


@dataclass(frozen=True, eq=False)
class TextTable:
    """Rows of a table, still text.

    Attributes:
        path: Its file.
        names: Of all columns, in the order of the header.
        cells: By name, of the columns that were asked for.
        lines: Of each row, its line in the file, counted from 1.
        comments: Lines of JSON behind ``#``.
        cut: The line of a last row that is left out because it does not end: it is being written, or was cut; else 0.
        has_commas: Whether semicolons part its cells, and a comma is the decimal point of its numbers.
    """

    path: Path
    names: tuple[str, ...]
    cells: dict[str, list[str]]
    lines: Sequence[int]
    comments: Sequence[str] = ()
    cut: int = 0
    has_commas: bool = False

    def __len__(self) -> int:
        return len(self.lines)

    @property
    def notes(self) -> tuple[str, ...]:
        """What to tell of it."""
        told = {
            f"line {self.cut} is cut off, or is being written: it is left out": self.cut,
            "a comma is read as the decimal point of its numbers": self.has_commas,
        }
        return tuple(note for note, is_so in told.items() if is_so)

    def numbers(self, name: str, lacks: Sequence[str] = ()) -> Float:
        """A column as numbers, (rows,); True is 1 and False is 0.

        Args:
            name: Of the column.
            lacks: What may stand in a cell that has no number, in lower case, such as `NOTHING`; it is NaN then.

        Raises:
            SchemaError: A cell is no finite number; names the line.
        """
        cells = self.cells[name]
        if self.has_commas:
            cells = [cell.replace(",", ".") for cell in cells]
        try:
            values = np.fromiter(map(float, cells), np.float64, len(cells))
            if "_" in "".join(cells):
                raise ValueError
        except ValueError:
            known = {cell: _number(cell) for cell in {*cells}}  # a column of True and False has two
            values = np.fromiter(map(known.__getitem__, cells), np.float64, len(cells))
        wrong = ~is_countable(values)
        for row in np.flatnonzero(wrong):
            if cells[row].strip().lower() not in lacks or not math.isnan(values[row]):
                shown = shortened(cells[row], 40) or "nothing"
                raise self.refused(int(row), f"column '{name}' holds {shown}, which is no number that can be read")
        return values

    def counts(self, name: str, least: int = 0, lacks: Sequence[str] = ()) -> Float:
        """A column of whole numbers, (rows,); see `numbers`.

        Raises:
            SchemaError: A cell is less than `least`, or no whole number: perhaps it stands under another's name.
        """
        values = self.numbers(name, lacks)
        is_right = (values >= least) & (values == np.floor(values)) | np.isnan(values)
        if self.has_commas:
            is_right &= np.array(["," not in cell for cell in self.cells[name]], bool)
        return self._all_right(name, values, is_right, f"counts from {least}")

    def truths(self, name: str) -> Float:
        """A column of 0 and 1, (rows,), such as the success of episodes; see `numbers`.

        Raises:
            SchemaError: A cell is something else, such as a probability.
        """
        values = self.numbers(name)
        what = f"is 0 or 1{', and not in percent' * bool((values > 1.0).any())}"
        return self._all_right(name, values, np.isin(values, (0.0, 1.0)), what)

    def part(self, rows: Iterable[int]) -> "TextTable":
        """Some of its rows."""
        rows = list(rows)
        cells = {name: [of[row] for row in rows] for name, of in self.cells.items()}
        return replace(self, cells=cells, lines=[self.lines[row] for row in rows])

    def _all_right(self, name: str, values: Float, is_right: Mask, what: str) -> Float:
        for row in np.flatnonzero(~is_right):
            raise self.refused(int(row), f"column '{name}' {what}, and holds {shortened(self.cells[name][row], 40)}")
        return values

    def refused(self, row: int, why: str) -> SchemaError:
        """The error that names a row's line."""
        return SchemaError(f"{self.path}, line {self.lines[row]}: {why}")


def text_of(data: bytes, *, is_whole: bool) -> str:
    """The text of a file, or of its beginning: in UTF-8 or UTF-16, as it is or packed by gzip.

    Raises:
        SchemaError: It unpacks to more than is allowed, or is damaged.
        UnicodeDecodeError: It is no such text.
    """
    if data.startswith(GZIP):
        packed = zlib.decompressobj(31)
        try:
            data = packed.decompress(data, MOST_BYTES + 1)
        except zlib.error as error:
            raise SchemaError(f"what gzip packed is damaged: {error}") from error
        if len(data) > MOST_BYTES or packed.unused_data:
            raise SchemaError(f"it unpacks to more than {MOST_BYTES:,} bytes, or to several files")
        if not packed.eof:  # the last row is not known to be whole
            is_whole, data = False, data.rstrip(b"\r\n")
    return data.decode("utf-16" if data.startswith(WIDE) else "utf-8-sig", "strict" if is_whole else "ignore")


def read_text(path: Path) -> str:
    """The text of a file with a table; see `text_of`.

    Raises:
        SchemaError: It cannot be read, or is no text.
    """
    with reading(path, "table"), open_regular(path, MOST_BYTES) as file:
        return text_of(file.read(), is_whole=True)


def head_of(path: Path, head: bytes) -> str:
    """The first whole rows of a file; empty of a folder, and of what is no text.

    Args:
        path: The file. It is read only where not even its first line ends in `head`.
        head: Its first bytes.
    """
    try:
        text = text_of(head, is_whole=False)
        if head and "\n" not in text[:-1] and path.is_file():
            with open_regular(path, 2**62) as file:
                text = text_of(file.read(LONGEST_LINE), is_whole=False)
    except (SchemaError, OSError, ValueError):
        return ""
    return "" if "\0" in text else text if text.lstrip()[:1] == "[" else text[: text.rfind("\n") + 1]


def first_rows(path: Path, text: str, names: Sequence[str] = ()) -> TextTable:
    """The table in the beginning of a file; its header alone if a row is damaged, nothing of anything else."""
    lines = text.splitlines(keepends=True)
    for count in (len(lines), 2 if text.startswith("#") else 1):  # the reader names the damaged line
        with suppress(SchemaError):
            return parse_table(path, "".join(lines[:count]), names)
    return TextTable(path, (), {}, ())


def parse_table(path: Path, text: str, names: Sequence[str] = ()) -> TextTable:
    """A table of a text whose first row names the columns, or of objects of JSON, one a line or all in a list.

    Cells are parted by what stands in the header most often: a comma, a semicolon or a tab. Names in objects are joined
    to those of what holds them, ``a/b``. Blank lines are left out. A last line without an end is left out too, and
    told: its last number may be cut.

    Args:
        path: Its file.
        text: Of the file, or of its beginning.
        names: Of the columns of a text that has no header.
    """
    if text.lstrip()[:1] in ("{", "["):
        return _of_objects(path, text)
    comments, text = COMMENT.findall(text), COMMENT.sub("", text)  # a blank line stays: the others keep their numbers
    is_quoted = text.startswith('"')  # the program puts every cell in quotes, and ends the last line with nothing
    begin = re.search(r"\S.*", text)
    separator = max(",;\t", key=begin[0].count) if begin else ","
    is_open = not is_quoted and text and not text.endswith(("\n", "\r"))
    open_end = sum(1 for _ in io.StringIO(text, newline="")) if is_open else 0
    known, numbers, cut = tuple(names), list[int](), 0
    columns: list[list[str]] = [[] for _ in known]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=is_quoted, skipinitialspace=True)
    try:
        for row in reader:
            line = reader.line_num
            if len(row) < 2 and not any(cell.strip() for cell in row):
                continue
            if line == open_end:
                cut = line
            elif not known:
                known = tuple(name.strip() for name in row)
                columns = [[] for _ in known]
            elif len(row) != len(known):
                raise SchemaError(f"{path}, line {line}: it has {len(row)} cells, and there are {len(known)} columns")
            elif row[0].strip() != known[0] or tuple(cell.strip() for cell in row) != known:  # else it was gone on with
                numbers.append(line)
                for column, cell in zip(columns, row, strict=True):
                    column.append(cell)
    except csv.Error as error:
        raise SchemaError(f"{path}, line {reader.line_num}: {error}") from error
    if len({*known}) < max(len(known), 1):
        raise SchemaError(f"{path} has no header, a header that is cut off, or names a column twice in it")
    has_commas = separator == ";" and any(re.fullmatch(r"\s*-?\d+,\d+\s*", cell) for of in columns for cell in of)
    return TextTable(path, known, dict(zip(known, columns, strict=True)), numbers, comments, cut, has_commas)


def _of_objects(path: Path, text: str) -> TextTable:
    rows, lines, cut = list[dict[str, str]](), list[int](), 0
    parts = [text] if text.lstrip().startswith("[") else text.splitlines(keepends=True)
    for line, part in enumerate(parts, 1):
        try:
            found = json.loads(part) if part.strip() else []
        except (ValueError, RecursionError) as error:
            if line == len(parts) > 1 and not part.endswith("\n"):
                cut = line
                break
            raise SchemaError(f"{path}, line {line}: it is no JSON: {error}") from error
        for it in found if isinstance(found, list) else [found]:
            if not isinstance(it, dict):
                raise SchemaError(f"{path}, line {line}: it is no object of JSON")
            rows.append(dict(_flat(it)))
            lines.append(line)
    names = tuple(dict.fromkeys(chain(*rows)))
    return TextTable(path, names, {name: [row.get(name, "") for row in rows] for name in names}, lines, cut=cut)


def _flat(of: Any, before: str = "") -> Iterator[tuple[str, str]]:
    for name, value in of.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{name}/")
        elif value is None or isinstance(value, str | int | float):
            yield f"{before}{name}", "" if value is None else str(value)


def _number(cell: str) -> float:
    with suppress(ValueError):
        return math.nan if "_" in cell else float(cell)
    return TRUTH.get(cell.strip().lower(), math.nan)
