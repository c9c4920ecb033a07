"""Tables of text that other programs write, such as ``progress.csv``: cells by column, with the line of each row."""

import csv
import io
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.arrays import Float, Mask
from harness.errors import SchemaError, UsageError
from harness.files.bounded import open_regular, read_bytes, reading
from harness.log.format import HEAD
from harness.log.log import LARGEST
from harness.reward.steps import nearest
from harness.text import shortened

MOST_BYTES = 2**28
LONGEST_LINE = 2**20
TRUTH = {"true": 1.0, "false": 0.0}


@dataclass(frozen=True, eq=False)
class TextTable:
    """Rows of a table, still text.

    Attributes:
        path: Its file.
        names: Of all columns, in the order of the header.
        cells: By name, of the columns that were asked for.
        lines: Of each row, its line in the file, counted from 1.
        comments: Lines that were no rows, and their numbers.
        headers: Lines at which the header stands once more: somebody has gone on with the file.
        cut: The line of a last row that is left out because it does not end: it is being written, or was cut; else 0.
    """

    path: Path
    names: tuple[str, ...]
    cells: dict[str, list[str]]
    lines: list[int]
    comments: tuple[tuple[int, str], ...] = ()
    headers: tuple[int, ...] = ()
    cut: int = 0

    def __len__(self) -> int:
        return len(self.lines)

    @property
    def notes(self) -> tuple[str, ...]:
        """What to tell of it."""
        return (f"line {self.cut} is cut off, or is being written: it is left out",) if self.cut else ()

    def numbers(self, name: str, may_lack: bool = False) -> Float:
        """A column as numbers, (rows,); True is 1 and False is 0.

        Args:
            name: Of the column.
            may_lack: Whether cells may be empty or NaN; they are NaN then.

        Raises:
            SchemaError: A cell is no finite number; names the line.
        """
        values = np.array([_number(cell) for cell in self.cells[name]], np.float64)
        wrong = ~(np.abs(values) <= LARGEST)
        if may_lack:
            wrong &= np.array([cell.strip().lower() not in ("", "nan", "none") for cell in self.cells[name]], bool)
        if wrong.any():
            row = int(np.argmax(wrong))
            shown = shortened(self.cells[name][row], 40) or "nothing"
            raise self.refused(row, f"column '{name}' holds {shown}, which is no number that can be read")
        return values

    def counts(self, name: str, least: int = 0, may_lack: bool = False) -> Float:
        """A column of whole numbers, (rows,); see `numbers`.

        Raises:
            SchemaError: A cell is less than `least`, or no whole number: perhaps it stands under another's name.
        """
        values = self.numbers(name, may_lack)
        self._require(name, (values >= least) & (values == np.floor(values)) | np.isnan(values), f"counts from {least}")
        return values

    def truths(self, name: str) -> Float:
        """A column of 0 and 1, (rows,), such as the success of episodes; see `numbers`.

        Raises:
            SchemaError: A cell is something else, such as a probability.
        """
        values = self.numbers(name)
        self._require(name, np.isin(values, (0.0, 1.0)), "is 0 or 1")
        return values

    def _require(self, name: str, is_right: Mask, what: str) -> None:
        if not is_right.all():
            row = int(np.argmin(is_right))
            raise self.refused(row, f"column '{name}' {what}, and holds {shortened(self.cells[name][row], 40)}")

    def refused(self, row: int, why: str) -> SchemaError:
        """The error that names a row's line."""
        return SchemaError(f"{self.path}, line {self.lines[row]}: {why}")


def read_table(
    path: Path,
    wanted: Callable[[tuple[str, ...]], Iterable[str]] | None = None,
    separator: str = ",",
    comment: str = "",
    names: Sequence[str] = (),
    ends_open: bool = False,
) -> TextTable:
    """Read a table of text in UTF-8 whose first row names the columns.

    Blank lines are left out. A last line without an end is left out too, and told: its last number may be cut.

    Args:
        path: The file.
        wanted: Which columns to keep, given the names of all; all if None.
        separator: Between cells.
        comment: What a line begins with that is no row; none if empty.
        names: Of the columns of a file that has no header.
        ends_open: Whether the program that wrote it puts every cell in quotes, and ends the last line with nothing.

    Raises:
        SchemaError: It is empty, or a row has another number of cells than the header; names the line.
    """
    with reading(path, "table"):
        text = read_bytes(path, MOST_BYTES).decode("utf-8-sig")
        return parse_table(path, text, wanted, separator, comment, names, ends_open)


def parse_table(
    path: Path,
    text: str,
    wanted: Callable[[tuple[str, ...]], Iterable[str]] | None = None,
    separator: str = ",",
    comment: str = "",
    names: Sequence[str] = (),
    ends_open: bool = False,
) -> TextTable:
    """A table as `read_table` gives it, of the text of a file or of its beginning."""
    comments: list[tuple[int, str]] = []
    rows = _rows(path, _lines(text, comment, comments), separator, strict=ends_open)
    open_end = 0 if ends_open else _open_end(text)
    line = 0
    if not names:
        line, head = next(rows, (0, []))
        names = [name.strip() for name in head]
    known = tuple(names)
    if not known or line == open_end > 0 or len(set(known)) < len(known):
        raise SchemaError(f"{path} has no header, a header that is cut off, or names a column twice in it")
    keep = tuple(dict.fromkeys(known if wanted is None else wanted(known)))
    at = [known.index(name) for name in keep]
    columns: list[list[str]] = [[] for _ in at]
    lines: list[int] = []
    headers: list[int] = []
    cut = 0
    for line, row in rows:
        if line == open_end:
            cut = line
            break
        if len(row) != len(known):
            raise SchemaError(f"{path}, line {line}: it has {len(row)} cells, and there are {len(known)} columns")
        if row[0].strip() == known[0] and tuple(cell.strip() for cell in row) == known:
            headers.append(line)
            continue
        lines.append(line)
        for column, place in zip(columns, at, strict=True):
            column.append(row[place])
    cells = dict(zip(keep, columns, strict=True))
    return TextTable(path, known, cells, lines, tuple(comments), tuple(headers), cut)


def header_of(path: Path, head: bytes, separator: str = ",") -> tuple[str, ...]:
    """Names of the columns of a file's first line; empty of a folder, and of what is no text in UTF-8.

    Args:
        path: The file. It is read only where its first line is longer than `head`.
        head: Its first bytes.
        separator: Between names.
    """
    try:
        if b"\n" not in head and len(head) >= HEAD:
            with open_regular(path, sys.maxsize) as file:
                head = file.readline(LONGEST_LINE)
        first = head.decode("utf-8-sig", "ignore").splitlines()[:1]
        [names] = csv.reader(first, delimiter=separator)
    except (OSError, csv.Error, ValueError):
        return ()
    return tuple(name.strip() for name in names)


def require_columns(path: Path, names: Sequence[str], *wanted: str) -> None:
    """See that a table has columns that a user named; empty texts are not looked for.

    Raises:
        UsageError: It lacks one; says what it has.
    """
    for name in wanted:
        if name and name not in names:
            there = shortened(", ".join(names), 160)
            raise UsageError(f"{path} has no '{name}'. It has: {there}{nearest(name, list(names))}")


def _rows(path: Path, lines: Iterator[str], separator: str, strict: bool) -> Iterator[tuple[int, list[str]]]:
    """Rows and the lines on which they end; a blank one is none."""
    reader = csv.reader(lines, delimiter=separator, strict=strict)
    try:
        for row in reader:
            if len(row) > 1 or any(cell.strip() for cell in row):
                yield reader.line_num, row
    except csv.Error as error:
        raise SchemaError(f"{path}, line {reader.line_num}: {error}") from error


def _lines(text: str, comment: str, comments: list[tuple[int, str]]) -> Iterator[str]:
    """All lines; a comment is put among the comments, and is blank here, so that the others keep their numbers."""
    for number, line in enumerate(io.StringIO(text, newline=""), 1):
        is_comment = bool(comment) and line.startswith(comment)
        if is_comment:
            comments.append((number, line.strip()))
        yield "\n" if is_comment else line


def _open_end(text: str) -> int:
    """The number of the last line if nothing ends it, else 0."""
    if not text or text.endswith(("\n", "\r")):
        return 0
    return sum(1 for _ in io.StringIO(text, newline=""))


def _number(cell: str) -> float:
    text = cell.strip()
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        return TRUTH.get(text.lower(), math.nan)
