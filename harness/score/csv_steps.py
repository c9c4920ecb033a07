"""A CSV file with a ``reward`` column and a row for each environment step, as a log.

The experimenters' two programs wrote the same columns with different meanings:

* base line: t is empty; delta_distance is filled in the rows of episode starts only; prevBest is the value before
  the step;
* K2: t counts from 0, the row of the episode's start; delta_distance is filled everywhere; prevBest is the value
  after the step.

A row is read by what is filled in, not by a guess about its file, so that files of both joined together are read too:

* the best distance before the step is ``distance - delta_distance`` where delta_distance is filled, which is true of
  both programs, and prevBest where it is empty;
* the row of an episode's start has t = 0 where t is filled; where t is empty it has delta_distance filled, a reward
  of 0, and distance, prevBest and beginDistance all equal.

beginDistance can change inside an episode (a target that was touched is drawn again) and is read row by row.
"""

import csv
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TextIO

import numpy as np
import pyarrow as pa
import pyarrow.csv

from harness.errors import UsageError
from harness.files.bounded import require_regular
from harness.log import Log, LogFacts
from harness.log.format import HEAD
from harness.log.log import RECORDED, REWARD, Array, Columns, is_countable
from harness.log.text_table import first_rows, head_of
from harness.reward.row_steps import TOUCHED
from harness.score.row_meaning import NEEDED, RECORD, RowWatch, roles_in, why_no_steps
from harness.text import shortened

MOST_COLUMNS = 1_000
"""The most columns of a file; ours have 30."""
LONGEST_LINE = 2**18
"""The most characters of a line: 250 for each of so many columns."""
SHOWN = 60
"""The most characters of a name or a cell in a message."""

_SEPARATED = re.compile(r"\d[,' ]\d")


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


def fault_of(path: Path, header: list[str], places: Mapping[str, int], problem: str) -> UsageError:
    """The first fault of a file that could not be read, found by reading it again, slowly.

    Args:
        path: The file.
        header: Names of all columns, as they are.
        places: Of the columns that are read, by what this project calls them.
        problem: What is said where no line is at fault.
    """
    told = f"{path} has no rows"
    try:
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            lines = csv.reader(_lines(file))
            next(lines)
            for cells in filter(None, lines):
                if fault := _find_fault(cells, header, places):
                    return UsageError(f"{path}, line {lines.line_num}, {fault}")
                told = f"{path} cannot be read: {problem}"
    except (csv.Error, OSError) as error:
        told = f"{path} cannot be read: {error}"
    return UsageError(told)


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
    paid = next((name.strip() for name in names if name.strip().lower().startswith("reward_")), None)
    rename = "" if paid is None else f". Call the one that taught 'reward', such as '{shortened(paid, SHOWN)}'"
    return f"no column 'reward'; there is: {shown_names(names) or 'nothing'}{rename}"


def shown_names(names: Sequence[str]) -> str:
    """The first names of columns, for a message."""
    return ", ".join(shortened(name.strip(), SHOWN) for name in names[:12]) + (", ..." if len(names) > 12 else "")


def _find_fault(cells: list[str], header: list[str], places: Mapping[str, int]) -> str | None:
    """What is wrong with a line; None if nothing is."""
    count, expected = len(cells), len(header)
    if count != expected:
        column = f"column {expected + 1}" if count > expected else f"column '{header[count].strip()}'"
        hint = "; a comma inside a number?" if count > expected else ""
        return f"{column}: cells in the line: {count}, in the header: {expected}{hint}"
    texts = {name: cells[place].strip() for name, place in places.items()}
    *best, delta = BEST
    told = best if texts.get(delta) else BEST[0:0] if texts.keys().isdisjoint(best) else [delta]
    for name, text in texts.items():
        column = header[places[name]].strip()
        with suppress(ValueError):
            if "_" not in text and is_countable(float(text)):
                continue
        if not text and name in ("step", *told):
            continue
        if name == "reward" and text.lower() == "nan":  # a training that diverged: an outcome, and no fault of the file
            continue
        problem = f"'{shortened(text, SHOWN)}' is no finite number" if text else "the cell is empty"
        if _SEPARATED.search(text):
            problem += ": write decimal points and no thousands separators"
        if text and text == column:
            problem = "the header stands here once more: two files joined into one? Give each run a file"
        return f"column '{column}': {problem}"
    return None


PAY = f"{REWARD}{RECORDED}"
"""The column of the shaped reward alone; 0 in the row of an episode's start."""
EVENTS = ("reward_ground", "reward_target", "reward_step")
"""The columns of what events paid, on top of it."""
STEPS = ("start", "begin_distance", "previous_best", "distance", "delta_distance", "step", "env", "episode")
"""The columns of an arm's steps, which can be paid again; Bd, Pb before the step, d after it and d - Pb are in [m]."""
BEST = ("previous_best", "prev_best", "delta_distance")
"""One of these tells the best distance before the step."""
COLUMNS = ("reward", *EVENTS, "step", "begin_distance", *BEST, "distance", "env", *TOUCHED)
"""What is read of a file. `previous_best`, this project's, is always the value before the step; `prev_best`, the
experimenters', is not. Flags are read where the first rows have numbers for them."""
SPELLINGS = {
    "step": ("t", "step"),
    "begin_distance": ("begindistance", "begin_distance"),
    "prev_best": ("prevbest", "prev_best"),
    "delta_distance": ("delta_distance", "deltadistance"),
}
"""The names that a column of `COLUMNS` may have, trimmed and in lower case, if not its own alone."""
MOST_BYTES = 8 * 2**30
"""The most bytes of a file, some 50 million rows of 160 bytes; they are read a piece at a time."""
LARGEST_STEP = 2**53
"""The largest count, up to which floating-point numbers are exact."""


@dataclass(frozen=True)
class StepsCsv:
    """A table of anybody whose column ``reward`` has what each environment step was paid; see this module."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """A CSV file with a column 'reward' of numbers, whose first rows may be steps, and are no episodes."""
        table = first_rows(path, head_of(path, head))
        if "reward" not in (names := _spelled(table.names)) or why_no_steps(table):
            return False
        told = [cell.strip().lower() for cell in table.cells[table.names[names.index("reward")]]]
        return not told or any(not text[:1].isalpha() or text[:3] in ("nan", "inf") for text in told)

    def read(self, path: Path) -> tuple[Log, ...]:
        """The one training of the file; see `open_csv`."""
        require_regular(path, MOST_BYTES)
        return (open_csv(path),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes of two steps, as the second program writes them; and how they ended."""
        path = folder / "steps.csv"
        rows = ("0,1,1,1,0,0,0,0,0.5", "1,1,0.5,0.5,-0.5,0.75,0,0,0.25", "2,1,0.5,0.75,0.25,-0.25,0,1,0.5")
        header = "t,beginDistance,prevBest,distance,delta_distance,reward,terminated,truncated,endEff z"
        path.write_text("\n".join([header, *rows, *rows, ""]))
        return path


def open_csv(path: Path) -> Log:
    """A recorded run in a CSV file; its rows are read later.

    Raises:
        UsageError: It cannot be read, has too many columns or no reward column; later, that a row cannot be read, or
            that rows are no steps.
    """
    header = read_header(path)
    with path.open("rb") as file:
        table = first_rows(path, head_of(path, file.read(HEAD)))
        file.seek(-1, os.SEEK_END)
        is_cut = file.read() not in (b"\n", b"\r")
    if column := why_no_steps(table):
        raise UsageError(
            f"{path}: its rows are episodes, or means over some (column '{column}'), and {NEEDED}; {RECORD}. "
            f"If each row is a step, delete the column '{column}'"
        )
    spelled = _spelled(header)
    found = {
        name: it for name in COLUMNS for it in reversed(SPELLINGS.get(name, (name,))) if it in spelled
    }  # the first spelling that is there
    unread = {*COLUMNS} - {*found}
    if not unread.isdisjoint(EVENTS):
        unread |= {*EVENTS}
    if not unread.isdisjoint(("begin_distance", "distance")) or unread >= {*BEST}:
        unread |= {*COLUMNS} - {"reward", *EVENTS}  # the run cannot be paid again with its distances
    for name in {*TOUCHED} - unread:  # other programs write words there
        told = table.cells.get(header[spelled.index(name)].strip()) or ["none"]
        if {cell.strip() for cell in told} - {"0", "1"}:
            unread.add(name)
    chosen = {name: it for name, it in found.items() if name not in unread}
    for it in chosen.values():
        if spelled.count(it) > 1:
            raise UsageError(f"{path}, line 1: two columns are called '{it}'")
    there = (PAY, *(it for it in (*EVENTS, *TOUCHED) if it in chosen), *(STEPS if "distance" in chosen else ()))
    notes = ("the last line does not end: it may be cut off",) * is_cut
    read = partial(_read, path, header, {name: spelled.index(it) for name, it in chosen.items()})
    return Log(LogFacts(path=path, format="CSV of steps", first_line=2, notes=notes), there, read)


def _read_rows(columns: Columns, last_step: int, episodes: dict[int, int]) -> dict[str, Array] | None:
    """The standard columns of some rows, (rows,) each; None if a row lacks a number that it needs.

    Args:
        columns: By name those of `COLUMNS` that were chosen, NaN where a cell is empty.
        last_step: That of the row before.
        episodes: The number of the last episode of each env in the rows before; it is gone on with.
    """
    if not all((is_countable(column) | np.isnan(column)).all() for column in columns.values()):
        return None
    reward, events = columns["reward"], {name: columns[name] for name in EVENTS if name in columns}
    if "distance" not in columns:
        return {PAY: reward, **events} if np.isfinite([*events.values()]).all() else None
    begin, distance, nothing = columns["begin_distance"], columns["distance"], np.full(len(reward), np.nan)
    told, filled, best = (columns.get(name, nothing) for name in ("step", "delta_distance", "prev_best"))
    # see the rule at the top of this file
    best = columns.get("previous_best", np.where(np.isnan(filled), best, distance - filled))
    delta = np.where(np.isnan(filled), distance - best, filled)
    env = columns.get("env", np.zeros(len(reward)))
    flags = {name: columns[name] for name in TOUCHED if name in columns}
    needed = [*events.values(), *flags.values(), begin, distance, best, delta, env]
    if not np.isfinite(needed).all() or max(np.abs(env).max(), np.nanmax(np.abs(told), initial=0.0)) > LARGEST_STEP:
        return None
    alike = (reward == 0.0) & (distance == begin) & (best == begin)
    if "delta_distance" in columns:
        alike &= np.isfinite(filled)
    start, row = np.where(np.isnan(told), alike, told == 0.0), np.arange(len(reward))
    since = row - np.maximum.accumulate(np.where(start, row, -1 - last_step))
    step, env = np.where(np.isnan(told), since, told).astype(np.int64), env.astype(np.int64)
    episode = np.zeros_like(env)
    for number in np.unique(env).tolist():
        mine = env == number
        first = -int(start[mine][0])  # the first episode of an env may have no start row
        episode[mine] = episodes.get(number, first) + np.cumsum(start[mine])
        episodes[number] = int(episode[mine][-1])
    values = (start, begin, best, distance, delta, step, env, episode)
    made = {name: values > 0.0 for name, values in flags.items()}
    return {PAY: reward, **events, **made, **dict(zip(STEPS, values, strict=True))}


def _spelled(header: Iterable[str]) -> list[str]:
    return [name.strip().lower() for name in header]


def _read(path: Path, header: list[str], places: Mapping[str, int], names: tuple[str, ...]) -> Iterator[Columns]:
    """See `harness.log.Log.read`. Empty cells are NaN.

    Raises:
        UsageError: A row cannot be read, or rows are no steps.
    """
    labels, roles = [*map(str, range(len(header)))], roles_in(header)
    looked = {role: labels[header.index(name)] for role, name in roles.items()}
    kinds = dict.fromkeys(looked.values(), pa.string()) | {labels[place]: pa.float64() for place in places.values()}
    convert = pa.csv.ConvertOptions(
        column_types=kinds, include_columns=list(kinds), null_values=["", " "], strings_can_be_null=True
    )
    line, step, episodes, watch, problem = 2, 0, dict[int, int](), RowWatch(path, roles), ""
    try:
        with pa.csv.open_csv(path, pa.csv.ReadOptions(column_names=labels, skip_rows=1), None, convert) as file:
            for batch in filter(len, file):
                watch.look({role: batch.column(label) for role, label in looked.items()}, line)
                columns = {name: batch.column(labels[it]).to_numpy(zero_copy_only=False) for name, it in places.items()}
                is_whole = not batch.column(labels[places["reward"]]).null_count
                made = is_whole and _read_rows(columns, step, episodes)
                if not made:
                    problem = "a number is missing, not finite or too large"
                    break
                line, step = line + len(batch), int(made.get("step", [0])[-1])
                yield {name: made[name] for name in names}
    except (pa.ArrowException, OSError) as error:
        problem = str(error)
    if problem or line == 2:
        raise fault_of(path, header, places, problem)
