"""The header of a CSV file of steps, and the first fault of one that cannot be read, by line and column."""

import csv
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple, TextIO

from harness.errors import UsageError
from harness.log.log import LARGEST
from harness.text import shortened

MOST_COLUMNS = 1_000
"""The most columns of a file; ours have 30."""
LONGEST_LINE = 2**18
"""The most characters of a line: 250 for each of so many columns."""
SHOWN = 60
"""The most characters of a name or a cell in a message."""

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_SEPARATED = re.compile(r"\d[,' ]\d")


class Header(NamedTuple):
    """The first line of a CSV file."""

    names: list[str]
    """All names, as they are."""
    positions: dict[str, int]
    """The places of the columns that are read, by what this project calls them."""


def read_header(path: Path) -> list[str]:
    """The names of the columns, as they are.

    Raises:
        UsageError: It is no CSV file, has too many columns, or none called 'reward'.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            names = next(csv.reader(_lines(file)), [])
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path}, line 1: no CSV file in UTF-8, and no trace: {error}") from error
    if len(names) > MOST_COLUMNS:
        raise UsageError(f"{path}, line 1: {len(names):,} columns, {MOST_COLUMNS:,} are allowed")
    if "reward" not in [name.strip().lower() for name in names]:
        raise UsageError(f"{path}, line 1: {_no_reward(names)}")
    return names


def fault_of(path: Path, header: Header, problem: str) -> UsageError:
    """The first fault of a file that could not be read, found by reading it again, slowly."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            lines = csv.reader(_lines(file))
            next(lines)
            fault, rows = None, 0
            for rows, cells in enumerate(filter(None, lines), 1):  # noqa: B007 (rows is counted)
                fault = _find_fault(cells, header)
                if fault is not None:
                    return UsageError(f"{path}, line {lines.line_num}, {fault}")
    except (csv.Error, OSError) as error:
        return UsageError(f"{path} cannot be read: {error}")
    return UsageError(f"{path} cannot be read: {problem}" if rows else f"{path} has no rows")


def _lines(file: TextIO) -> Iterator[str]:
    """The lines of a file, none of which is longer than `LONGEST_LINE`: csv.reader would take a whole file for one.

    Raises:
        csv.Error: One is.
    """
    while line := file.readline(LONGEST_LINE + 1):
        if len(line) > LONGEST_LINE:
            raise csv.Error(f"a line has more than {LONGEST_LINE:,} characters")
        yield line


def _no_reward(names: list[str]) -> str:
    """Why there is no reward column."""
    line = ",".join(names)
    for separator, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "|")):
        if line.count(separator) >= max(1, len(names)):
            return f"no column 'reward': the columns are separated by {word}; only commas are read, and decimal points"
    there = ", ".join(shortened(name.strip(), SHOWN) for name in names[:12]) + (", ..." if len(names) > 12 else "")
    paid = next((name.strip() for name in names if name.strip().lower().startswith("reward_")), None)
    rename = "" if paid is None else f". Call the one that taught 'reward', such as '{shortened(paid, SHOWN)}'"
    return f"no column 'reward'; there is: {there or 'nothing'}{rename}"


def _find_fault(cells: list[str], header: Header) -> str | None:
    """What is wrong with a line; None if nothing is."""
    expected = len(header.names)
    if len(cells) != expected:
        surplus = len(cells) > expected
        column = f"column {expected + 1}" if surplus else f"column '{header.names[len(cells)].strip()}'"
        hint = "; a comma inside a number?" if surplus else ""
        return f"{column}: cells in the line: {len(cells)}, in the header: {expected}{hint}"
    texts = {name: cells[position].strip() for name, position in header.positions.items()}
    for name, text in texts.items():
        problem = _problem_of(text, name in _needed_cells(texts))
        if problem is not None and text and text == header.names[header.positions[name]].strip():
            problem = "the header stands here once more: two files joined into one? Give each run a file"
        if problem is not None:
            return f"column '{header.names[header.positions[name]].strip()}': {problem}"
    return None


def _needed_cells(texts: Mapping[str, str]) -> set[str]:
    """Columns that may not be empty in a line with these cells."""
    needed = set(texts) - {"step", "delta_distance", "prev_best", "previous_best"}
    if not texts.get("delta_distance"):
        needed |= {"prev_best", "previous_best"} & set(texts) or {"delta_distance"}
    return needed


def _problem_of(text: str, needed: bool) -> str | None:
    """What is wrong with a cell; None if nothing is."""
    if not text:
        return "the cell is empty" if needed else None
    if not _NUMBER.fullmatch(text):
        hint = ": write decimal points and no thousands separators" if _SEPARATED.search(text) else ""
        return f"'{shortened(text, SHOWN)}' is no finite number{hint}"
    return None if abs(float(text)) <= LARGEST else f"'{shortened(text, SHOWN)}' is no finite number"
