"""A CSV file with a ``reward`` column as a recording; see `harness.score.recording` for what its rows mean."""

import csv
import re
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple, TextIO

import pyarrow as pa
import pyarrow.csv

from harness.errors import UsageError
from harness.score.recording import COLUMNS, LARGEST, Recording, choose_columns
from harness.score.row_meaning import MONITOR, RowWatch, Watched, watched_columns, why_no_steps
from harness.text import shortened

SPELLINGS = {
    **{name: (name,) for name in COLUMNS},
    "step": ("t", "step"),
    "begin_distance": ("begindistance", "begin_distance"),
    "prev_best": ("prevbest", "prev_best"),
    "delta_distance": ("delta_distance", "deltadistance"),
}
"""The names that a column of `COLUMNS` may have, trimmed and in lower case."""

MOST_COLUMNS = 1_000
"""The most columns of a file; ours have 30."""
LONGEST_LINE = 2**18
"""The most characters of a line: 250 for each of so many columns."""
SHOWN = 60
"""The most characters of a name or a cell in a message."""

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_SEPARATED = re.compile(r"\d[,' ]\d")


class _Header(NamedTuple):
    """The first line of a CSV file."""

    names: list[str]
    """All names, as they are."""
    positions: dict[str, int]
    """The places of the columns that are read."""
    watched: list[Watched]
    """The columns that say whether rows are steps."""


def open_csv(path: Path) -> Recording:
    """A recorded run in a CSV file; its rows are read later.

    Raises:
        UsageError: It cannot be read, has too many columns or no reward column, or its rows are known to be no steps.
    """
    header = _read_header(path)
    columns = tuple(header.positions)
    return Recording(
        path, columns, None, None, lambda fields: _csv_batches(path, header), partial(_report_csv, path, header), 2
    )


def _read_header(path: Path) -> _Header:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            names = next(csv.reader(_lines(file)), [])
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path}, line 1: no CSV file in UTF-8, and no trace: {error}") from error
    if len(names) > MOST_COLUMNS:
        raise UsageError(f"{path}, line 1: {len(names):,} columns, {MOST_COLUMNS:,} are allowed")
    spelled = [name.strip().lower() for name in names]
    foreign = MONITOR if names and names[0].startswith("#{") else None
    if foreign is None and "reward" not in spelled:
        foreign = why_no_steps(spelled)
    if foreign is not None:
        raise UsageError(f"{path} is {foreign}")
    found = {name: next((text for text in SPELLINGS[name] if text in spelled), None) for name in COLUMNS}
    chosen = choose_columns(name for name, text in found.items() if text is not None)
    if "reward" not in chosen:
        raise UsageError(f"{path}, line 1: {_no_reward(names)}")
    for name in chosen:
        if spelled.count(str(found[name])) > 1:
            raise UsageError(f"{path}, line 1: two columns are called '{found[name]}'")
    return _Header(names, {name: spelled.index(str(found[name])) for name in chosen}, watched_columns(spelled))


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


def _csv_batches(path: Path, header: _Header) -> Iterator[pa.RecordBatch]:
    """The wanted columns, empty cells as nulls.

    Raises:
        UsageError: A row cannot be read, or rows are no steps.
    """
    keys = {str(position): name for name, position in header.positions.items()}
    looked = {it.role: str(it.position) for it in header.watched}
    texts = dict.fromkeys([place for place in looked.values() if place not in keys], pa.string())
    watch = RowWatch(header.watched, 2)
    read = pa.csv.ReadOptions(column_names=[str(position) for position in range(len(header.names))], skip_rows=1)
    convert = pa.csv.ConvertOptions(
        column_types={**dict.fromkeys(keys, pa.float64()), **texts},
        include_columns=[*keys, *texts],
        null_values=["", " "],
    )
    try:
        with pa.csv.open_csv(path, read_options=read, convert_options=convert) as file:
            for batch in file:
                watch.look({role: batch.column(place) for role, place in looked.items()})
                yield batch.select(list(keys)).rename_columns(list(keys.values()))
            watch.require_steps()
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from error
    except (pa.ArrowException, OSError) as error:
        raise _report_csv(path, header, str(error)) from error


def _report_csv(path: Path, header: _Header, problem: str) -> UsageError:
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


def _find_fault(cells: list[str], header: _Header) -> str | None:
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
