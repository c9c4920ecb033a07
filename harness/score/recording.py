"""Recorded runs of anybody, read a piece at a time: this project's traces and CSV files with a ``reward`` column.

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
import glob
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import SchemaError, UsageError
from harness.record.cell import Cell
from harness.record.folder import MANIFEST
from harness.record.manifest import read_manifest
from harness.record.trace import FORMAT, FORMAT_KEY
from harness.score.scorer import TOUCHED, targets_touched

Columns = dict[str, Float]

ROWS = 65_536
"""Rows of a chunk: half a megabyte per column."""

EVENTS = ("reward_ground", "reward_target", "reward_step")
SPELLINGS = {
    "reward": ("reward",),
    **{name: (name,) for name in EVENTS},
    "step": ("t", "step"),
    "begin_distance": ("begindistance", "begin_distance"),
    "previous_best": ("previous_best",),
    "prev_best": ("prevbest", "prev_best"),
    "distance": ("distance",),
    "delta_distance": ("delta_distance", "deltadistance"),
    "env": ("env",),
}
"""What a column may be called, trimmed and in lower case. `previous_best`, this project's, is always the value before
the step; `prev_best`, the experimenters', is not."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_SEPARATED = re.compile(r"\d[,' ]\d")
_PARQUET = b"PAR1"


class Chunk(NamedTuple):
    """Consecutive rows of a recording; arrays of shape (rows,), or None where the file has none of it."""

    line: int
    """Where the first row stands in its file: the line of a CSV file, blank lines not counted; a trace's row from 1."""
    reward: Float
    """The shaped reward alone; 0 in the row of an episode's start."""
    event: Float | None = None
    """Sum of the event terms, paid on top."""
    start: Mask | None = None
    """Whether the row is an episode's start. None, as all that follow, if the file has no distances."""
    begin_distance: Float | None = None
    """Bd, [m]."""
    previous_best: Float | None = None
    """Pb, the smallest distance of the episode before the step, [m]."""
    distance: Float | None = None
    """d(t), end effector to target after the step, [m]."""
    delta_distance: Float | None = None
    """d(t) - Pb, [m]."""
    step: NDArray[np.int64] | None = None
    """t: 0 at an episode's start; counted from there where the file does not say."""
    env: NDArray[np.int64] | None = None
    """Which of the envs that trained together; 0 where the file does not say."""
    touched: Mask | None = None
    """Whether the target was reached and the next one set after the row; None where the file does not say."""


@dataclass(frozen=True)
class Recording:
    """One recorded run.

    Attributes:
        path: The file.
        columns: What it has of the names in `SPELLINGS`, those that are read; of a trace also `TOUCHED`.
        declared_reward: What paid it, as `harness.registry.choice.choose` takes it, if the manifest beside it says
            so.
        seed: The run's seed, if the manifest says so.
    """

    path: Path
    columns: tuple[str, ...]
    declared_reward: str | None
    seed: int | None
    _batches: Callable[[], Iterator[pa.RecordBatch]]
    _report: Callable[[str], UsageError]
    _first_line: int

    @property
    def has_distances(self) -> bool:
        """Whether the run can be scored again."""
        return "distance" in self.columns

    @property
    def has_events(self) -> bool:
        """Whether the event terms are recorded."""
        return set(EVENTS) <= set(self.columns)

    def chunks(self, rows: int = ROWS) -> Iterator[Chunk]:
        """All rows in order, `rows` at a time, fewer only in the last chunk; nothing else is held in memory.

        Raises:
            UsageError: A row cannot be read, or there is none; names file, line and column.
        """
        line, counted = self._first_line, 0
        for table in _regroup(self._batches(), rows):
            columns = {name: table.column(name).to_numpy().astype(np.float64, copy=False) for name in self.columns}
            chunk = _read_chunk(columns, line, counted)
            if chunk is None:
                raise self._report("a number is missing or not finite")
            yield chunk
            line += len(chunk.reward)
            counted = 0 if chunk.step is None else int(chunk.step[-1])
        if line == self._first_line:
            raise UsageError(f"{self.path} has no rows")


def match_recordings(patterns: str | Iterable[str]) -> list[Recording]:
    """The recordings that a pattern, or any of several, matches: sorted, each once; ``**`` stands for any folders.

    Raises:
        UsageError: A pattern matches no file, or a file is no recording.
    """
    given = [patterns] if isinstance(patterns, str) else list(patterns)
    files = {path for pattern in given for path in _match_files(pattern)}
    return [open_recording(path) for path in sorted(files)]


def open_recording(path: Path) -> Recording:
    """A recorded run; its columns are looked at, its rows are read later.

    Raises:
        UsageError: The file cannot be read, is empty or has no reward column.
        SchemaError: It is a Parquet file, and no trace that this version reads.
    """
    try:
        with path.open("rb") as file:
            magic = file.read(len(_PARQUET))
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error
    if not magic:
        raise UsageError(f"{path} is empty")
    return _open_trace(path) if magic == _PARQUET else _open_csv(path)


def _match_files(pattern: str) -> list[Path]:
    path = Path(pattern).expanduser()
    if path.is_file():  # a name may hold [ or *
        return [path]
    matched = [Path(name) for name in glob.glob(str(path), recursive=True)]
    files = [name for name in matched if name.is_file()]
    if not files:
        only = "; it matches folders only" if matched else ""
        raise UsageError(f"No file matches '{pattern}'{only}. Quote a pattern, as in 'runs/*.csv'")
    return files


# Rows


def _regroup(batches: Iterable[pa.RecordBatch], rows: int) -> Iterator[pa.Table]:
    """The same rows in tables of `rows` rows; the last one may be shorter."""
    waiting: list[pa.RecordBatch] = []
    count = 0
    for batch in batches:
        waiting.append(batch)
        count += batch.num_rows
        if count >= rows:
            table = pa.Table.from_batches(waiting)
            whole = count - count % rows
            yield from (table.slice(start, rows) for start in range(0, whole, rows))
            waiting, count = table.slice(whole).to_batches(), count - whole
    if count:
        yield pa.Table.from_batches(waiting)


def _read_chunk(columns: Columns, line: int, counted: int) -> Chunk | None:
    """What rows say; None if one lacks a number that it needs. `counted` is the step of the row before."""
    reward = columns["reward"]
    event = np.sum([columns[name] for name in EVENTS], axis=0) if set(EVENTS) <= set(columns) else None
    needed = [reward] if event is None else [reward, event]
    if "distance" not in columns:
        return Chunk(line, reward, event) if _is_finite(needed) else None
    begin, distance = columns["begin_distance"], columns["distance"]
    best, delta = _before_step(columns)
    env = columns.get("env", np.zeros(len(reward)))
    told = columns.get("step", np.full(len(reward), np.nan))
    if not _is_finite([*needed, begin, distance, best, delta, env]) or np.isinf(told).any():
        return None
    filled = np.isfinite(columns["delta_distance"]) if "delta_distance" in columns else np.ones(len(reward), bool)
    alike = filled & (reward == 0.0) & (distance == begin) & (best == begin)
    start = np.where(np.isnan(told), alike, told == 0.0)
    step = np.where(np.isnan(told), _count_steps(start, counted), told).astype(np.int64)
    flags = [columns[name] > 0.0 for name in TOUCHED if name in columns]
    touched = targets_touched(*flags) if flags else None
    return Chunk(line, reward, event, start, begin, best, distance, delta, step, env.astype(np.int64), touched)


def _before_step(columns: Columns) -> tuple[Float, Float]:
    """Pb before the step and d - Pb, by the rule at the top of this file."""
    distance, delta = columns["distance"], columns.get("delta_distance")
    best = columns.get("previous_best", columns.get("prev_best"))
    if delta is None:
        assert best is not None  # one of the two is there, or the distances are not read
        return best, distance - best
    if best is None:
        return distance - delta, delta
    empty = np.isnan(delta)
    before = best if "previous_best" in columns else np.where(empty, best, distance - delta)
    return before, np.where(empty, distance - before, delta)


def _count_steps(start: Mask, counted: int) -> NDArray[np.int64]:
    """Rows since the last start row, which is 0; `counted` rows before the first one."""
    row = np.arange(len(start))
    since: NDArray[np.int64] = row - np.maximum.accumulate(np.where(start, row, -1 - counted))
    return since


def _is_finite(columns: list[Float]) -> bool:
    return all(bool(np.isfinite(column).all()) for column in columns)


def _choose_columns(there: Iterable[str]) -> tuple[str, ...]:
    """Those that are read: the distances only where a run can be scored again with them, or what are they for?"""
    names = set(there)
    best = names & {"previous_best", "prev_best", "delta_distance"}
    scorable = bool(best) and {"begin_distance", "distance"} <= names
    wanted = {"reward": True, **dict.fromkeys(EVENTS, set(EVENTS) <= names)}
    return tuple(name for name in SPELLINGS if name in names and wanted.get(name, scorable))


# Traces


def _open_trace(path: Path) -> Recording:
    try:
        with pq.ParquetFile(path) as file:
            schema = file.schema_arrow
        version = int((schema.metadata or {}).get(FORMAT_KEY, b"0"))
    except (OSError, pa.ArrowInvalid) as error:
        raise SchemaError(f"{path} is no readable trace: {error}") from error
    if not 0 < version <= FORMAT:
        raise SchemaError(f"{path} is a trace of format {version}, this version reads 1 to {FORMAT}")
    columns = _choose_columns(schema.names)
    if "distance" in columns and set(TOUCHED) <= set(schema.names):
        columns = (*columns, *TOUCHED)
    cell = _read_cell(path.with_name(MANIFEST))
    declared, seed = (cell.reward.label, cell.seed) if cell else (None, None)
    report = partial(_report_trace, path)
    return Recording(path, columns, declared, seed, partial(_trace_batches, path, columns), report, 1)


def _read_cell(manifest: Path) -> Cell | None:
    return read_manifest(manifest.parent).cell if manifest.is_file() else None


def _trace_batches(path: Path, columns: tuple[str, ...]) -> Iterator[pa.RecordBatch]:
    try:
        with pq.ParquetFile(path) as file:
            yield from file.iter_batches(batch_size=ROWS, columns=list(columns))
    except (OSError, pa.ArrowInvalid) as error:
        raise SchemaError(f"{path} is no readable trace: {error}") from error


def _report_trace(path: Path, problem: str) -> UsageError:
    return UsageError(f"{path}: {problem}")


# CSV files


class _Header(NamedTuple):
    """The first line of a CSV file: all names as they are, and where the columns stand that are read."""

    names: list[str]
    positions: dict[str, int]


def _open_csv(path: Path) -> Recording:
    header = _read_header(path)
    columns = tuple(header.positions)
    return Recording(
        path, columns, None, None, partial(_csv_batches, path, header), partial(_report_csv, path, header), 2
    )


def _read_header(path: Path) -> _Header:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            names = next(csv.reader(file), [])
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path}, line 1: no CSV file in UTF-8, and no trace: {error}") from error
    spelled = [name.strip().lower() for name in names]
    found = {name: next((text for text in SPELLINGS[name] if text in spelled), None) for name in SPELLINGS}
    chosen = _choose_columns(name for name, text in found.items() if text is not None)
    if "reward" not in chosen:
        raise UsageError(f"{path}, line 1: {_no_reward(names)}")
    for name in chosen:
        if spelled.count(str(found[name])) > 1:
            raise UsageError(f"{path}, line 1: two columns are called '{found[name]}'")
    return _Header(names, {name: spelled.index(str(found[name])) for name in chosen})


def _no_reward(names: list[str]) -> str:
    """Why there is no reward column."""
    line = ",".join(names)
    for separator, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "|")):
        if separator in line:
            return f"no column 'reward': the columns are separated by {word}; only commas are read, and decimal points"
    there = ", ".join(name.strip() for name in names[:12]) + (", ..." if len(names) > 12 else "")
    return f"no column 'reward'; there is: {there or 'nothing'}"


def _csv_batches(path: Path, header: _Header) -> Iterator[pa.RecordBatch]:
    """The wanted columns, empty cells as nulls."""
    keys = {str(position): name for name, position in header.positions.items()}
    read = pa.csv.ReadOptions(column_names=[str(position) for position in range(len(header.names))], skip_rows=1)
    convert = pa.csv.ConvertOptions(
        column_types=dict.fromkeys(keys, pa.float64()), include_columns=list(keys), null_values=["", " "]
    )
    try:
        with pa.csv.open_csv(path, read_options=read, convert_options=convert) as file:
            for batch in file:
                yield batch.rename_columns(list(keys.values()))
    except (pa.ArrowException, OSError) as error:
        raise _report_csv(path, header, str(error)) from error


def _report_csv(path: Path, header: _Header, problem: str) -> UsageError:
    """The first fault of a file that could not be read, found by reading it again, slowly."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            lines = csv.reader(file)
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
        if problem:
            return f"column '{header.names[header.positions[name]].strip()}': {problem}"
    return None


def _needed_cells(texts: dict[str, Any]) -> set[str]:
    """Columns that may not be empty in a line with these cells."""
    needed = set(texts) - {"step", "delta_distance", "prev_best", "previous_best"}
    if not texts.get("delta_distance"):
        needed |= {"prev_best", "previous_best"} & set(texts) or {"delta_distance"}
    return needed


def _problem_of(text: str, needed: bool) -> str:
    """What is wrong with a cell; empty if nothing is."""
    if not text:
        return "the cell is empty" if needed else ""
    if not _NUMBER.fullmatch(text):
        hint = ": write decimal points and no thousands separators" if _SEPARATED.search(text) else ""
        return f"'{text}' is no finite number{hint}"
    return "" if np.isfinite(float(text)) else f"'{text}' is no finite number"
