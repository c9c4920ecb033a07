"""What a log format must satisfy. Each check takes the format and an empty folder to work in.

All of them look at the log that the format writes itself, `harness.log.LogFormat.write_example`.
"""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.errors import SchemaError, UsageError, one_line
from harness.log import Log, LogFacts, LogFormat, Rows
from harness.log.log import BEHAVIOUR, LARGEST, REWARD, SINCE, is_countable

from ..contract import check, require, settings_are_frozen, settings_survive_json
from .examples import (
    NEEDED,
    broken_types,
    called,
    counts_of,
    equal,
    faults_of,
    files_of,
    head_of,
    odd_places,
    quietly,
    random_bytes,
    read_at_first,
    read_example,
    read_logs,
    require_equal,
    require_order_of_steps,
    state_of,
    without_code,
    write_example,
)

CUTS = 8
"""A file is cut to nothing, to one eighth of its bytes, and so on."""
AT_ENDS = 2
"""Neighbouring lengths at which a row has just ended: before and after the second byte of a line's end."""
LAST = 64
"""Bytes of the end of a file, where it is cut at each."""
CHANGES = 16
"""Places of a file at which its bytes are changed."""
WRONG = b"\xff" * 8
"""What takes the place of some bytes: no UTF-8, and no number where 8 bytes are one."""


@dataclass(frozen=True)
class Whole:
    """The example as it was written, read.

    Attributes:
        facts: Of each log, by its run.
        rows: All rows of each.
    """

    facts: dict[str, LogFacts]
    rows: dict[str, Rows]


@dataclass(frozen=True)
class Damaged:
    """What was read of a damaged copy.

    Attributes:
        logs: Of each run the log and all of its rows; None where the copy was refused.
        what: What was done to it, for a sentence.
    """

    logs: dict[str, tuple[Log, Rows]] | None
    what: str


def whole_of(logs: tuple[Log, ...]) -> Whole:
    """What has to be read of a copy at most."""
    return Whole({log.facts.run: log.facts for log in logs}, {log.facts.run: log.rows() for log in logs})


def cut_copies(example: Path, folder: Path) -> Iterator[tuple[Path, Path, int]]:
    """One copy of the example, in which each file is cut in turn: its path, the file, the bytes that are left."""
    copy, files = _copied(example, folder / "cut")
    for file in files:
        content = file.read_bytes()
        for length in _cuts(len(content)):
            file.write_bytes(content[:length])
            yield copy, file, length
        file.write_bytes(content)


def changed_copies(example: Path, folder: Path) -> Iterator[tuple[Path, Path, int]]:
    """One copy of the example, in which some bytes of a file are `WRONG`: its path, the file, where they begin."""
    copy, files = _copied(example, folder / "changed")
    for file in files:
        content = file.read_bytes()
        for begin in sorted({len(content) * (2 * part + 1) // (2 * CHANGES) for part in range(CHANGES)}):
            wrong = WRONG[: len(content) - begin]
            file.write_bytes(content[:begin] + wrong + content[begin + len(wrong) :])
            yield copy, file, begin
        file.write_bytes(content)


def read_damaged(reader: LogFormat, path: Path, what: str) -> Damaged:
    """What a reader gives of a damaged copy.

    Raises:
        AssertionError: It raised something else than the errors that refuse a file.
    """
    try:
        logs = {log.facts.run: (log, log.rows()) for log in reader.read(path)}
    except (SchemaError, UsageError):
        logs = {}
    except Exception as error:  # a plugin may raise anything
        remedy = "refuse it by a SchemaError, as harness.files.bounded.reading does"
        raise AssertionError(f"{what} it raised {one_line(error)}: {remedy}") from error
    return Damaged(logs or None, what)


def require_beginnings(damaged: Damaged, whole: Whole) -> None:
    """See that what was read of a damaged copy are rows of the example, from the first on, and no other numbers."""
    for run, (log, rows) in (damaged.logs or {}).items():
        require(run in whole.rows, f"{damaged.what} there is {called(log)}, which the example does not have")
        for name, values in rows.columns.items():
            require(name in whole.rows[run].columns, f"{damaged.what} there is a column {name}, which there was not")
            there = whole.rows[run][name]
            require(
                len(values) == 0 or equal(values, there[: len(values)]),
                "{} the column {} begins with {}, and not with {}: other numbers, and no word",
                damaged.what, name, values[:5], there[:5],
            )  # fmt: skip


def is_silent(damaged: Damaged, whole: Whole) -> bool:
    """Whether rows are missing and nobody says so."""
    if damaged.logs is None:
        return False
    missing = damaged.logs.keys() != whole.rows.keys()
    for run, (log, rows) in damaged.logs.items():
        there = whole.rows[run]
        if len(rows) < len(there) or rows.columns.keys() != there.columns.keys():
            before = whole.facts[run]
            missing |= (log.facts.notes, log.facts.thinned) == (before.notes, before.thinned)
    return missing


def is_text(file: Path) -> bool:
    """Whether a file of the example is text in UTF-8."""
    try:
        return "\0" not in file.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return False


def _cuts(size: int) -> list[int]:
    """Lengths to cut a file of `size` bytes to: neighbours, `AT_ENDS` + 1 of them, and all of its last rows."""
    neighbours = {size * part // CUTS + more for part in range(CUTS) for more in range(AT_ENDS + 1)}
    return sorted(length for length in neighbours | {*range(size - LAST, size)} if 0 <= length < size)


def _copied(example: Path, place: Path) -> tuple[Path, list[Path]]:
    """A copy of the example in a new folder, and the files in it; folders may name a run, and keep their names."""
    copy = place / example.parent.name / example.name
    if example.is_dir():
        shutil.copytree(example, copy)
    else:
        copy.parent.mkdir(parents=True)
        shutil.copy(example, copy)
    return copy, files_of(copy)


LEAST_ROWS = {"step": 2, "episode": 2, "point": 3}
PIECES = (1, 2, 7)
"""Rows of a piece."""
HEADS = (*range(64), 100, 200, 500, 1000, 2000, 4000)
"""Bytes to which the head of the example is cut."""
NO_COLUMN = "reward/there-is-no-such"
ROUNDING = 1e-6
KNOWN = (REWARD, "time", "length")
"""Begins the names of columns that have a number in every row."""


@check("log-example")
def the_example_is_a_log(reader: LogFormat, folder: Path) -> None:
    """`write_example` returns a path in the folder that it is given. `read` gives at least one log of it.

    A log of the example has at least two steps or episodes, or three points.
    """
    for log in read_at_first(reader, write_example(reader, folder)):
        rows, least = len(log.rows()), LEAST_ROWS.get(log.facts.unit, 1)
        require(rows >= least, f"{called(log)} of the example has {rows} rows: write at least {least}")


@check("log-recognises")
def the_example_is_recognised(reader: LogFormat, folder: Path) -> None:
    """The format recognises its own example, and no empty file, no random bytes and no empty folder."""
    path = write_example(reader, folder)
    require(_recognised(reader, path), "it does not recognise the example that it wrote itself")
    for name, content in {"empty": b"", "random.bin": random_bytes(5000)}.items():
        (folder / name).write_bytes(content)
        require(not _recognised(reader, folder / name), f"it takes a file of {len(content)} random bytes for its own")
    (folder / "none").mkdir()
    require(not _recognised(reader, folder / "none"), "it takes an empty folder for its own")


@check("log-harmless")
def recognising_raises_nothing(reader: LogFormat, folder: Path) -> None:
    """`recognises` returns True or False, and raises nothing, whatever it is shown.

    Random bytes, a head that is cut anywhere, a folder, a link to nowhere, names in odd characters.
    """
    path = write_example(reader, folder)
    head = head_of(path)
    (folder / "odd").mkdir()
    for place in [*odd_places(folder / "odd"), *files_of(path), path.parent]:
        _recognised(reader, place)
    for length in HEADS:
        _recognised(reader, path, head[:length])
        _recognised(reader, path, random_bytes(length))
        _recognised(reader, path, head[: length // 2] + random_bytes(length // 2))


@check("log-facts")
def facts_are_sensible(reader: LogFormat, folder: Path) -> None:
    """The facts are what their docstring says: the path that was read, one line of text where one is asked for.

    `unit` is one of three, `seed` an int or None. Several logs of one file have names of their own in `run`.
    """
    path = write_example(reader, folder)
    logs = read_logs(reader, path)
    runs = [log.facts.run for log in logs]
    require(len(set(runs)) == len(runs), f"the logs of one file are called {runs}: give each a name of its own")
    for log in logs:
        require(isinstance(log.facts, LogFacts), f"facts are a {type(log.facts).__name__}, not harness.log.LogFacts")
        for fault in faults_of(log, path):
            raise AssertionError(fault)


@check("log-declared")
def declared_totals_hold(reader: LogFormat, folder: Path) -> None:
    """What the file declares of its own length, in `declared`, is so in the example."""
    for log in read_example(reader, folder):
        for name, count in counts_of(log).items():
            told = log.facts.declared.get(name, count)
            require(told == count, f"{called(log)} declares {told} {name}, and its rows have {count}")


@check("log-standard-columns")
def standard_columns_are_there(reader: LogFormat, folder: Path) -> None:
    """A log has the columns that its unit asks for, and at least one reward or measure.

    Steps: ``episode`` and ``step``. Episodes: ``length`` or ``time``. Points: ``time`` or ``iteration``. Every log:
    ``reward/NAME`` or ``behaviour/NAME``.
    """
    for log in read_example(reader, folder):
        names = log.columns
        require(len(set(names)) == len(names), f"{called(log)} names a column twice: {', '.join(names)}")
        for some in NEEDED[log.facts.unit]:
            told = f"{called(log)} has no column {' or '.join(some)}, which a log of {log.facts.unit}s needs"
            require(set(some) & set(names), f"{told}. It has: {', '.join(names)}")
        paid = [name for name in (*log.rewards, *log.measures) if name]
        require(paid, f"{called(log)} has neither a reward/NAME nor a behaviour/NAME. It has: {', '.join(names)}")


@check("log-types")
def columns_hold_what_their_names_say(reader: LogFormat, folder: Path) -> None:
    """Columns are arrays of equal length. Counts are whole numbers, ends truth values, rewards one number a row."""
    for log in read_example(reader, folder):
        for table in log.read(log.columns):
            lengths = {name: len(table[name]) for name in log.columns}
            require(len(set(lengths.values())) == 1, f"columns have different lengths: {lengths}")
            require(all(isinstance(it, np.ndarray) for it in table.values()), "a column is no numpy array")
        for fault in broken_types(log.rows()):
            raise AssertionError(fault)


@check("log-pieces")
def pieces_make_the_whole(reader: LogFormat, folder: Path) -> None:
    """Pieces of 1, 2 and 7 rows have the same rows as the whole log."""
    for log in read_example(reader, folder):
        whole = log.rows()
        for count in PIECES:
            end = 0
            for piece in log.pieces(log.columns, count):
                begin, end = end, end + len(piece)
                require_equal(piece, whole.part(slice(begin, end)), f"rows {begin} to {end}, in pieces of {count}")
            require(end == len(whole), f"in pieces of {count} there are {end} rows, and {len(whole)} in all")


@check("log-columns")
def columns_can_be_chosen(reader: LogFormat, folder: Path) -> None:
    """Each column alone, and all in another order, have the values that they have in all rows."""
    for log in read_example(reader, folder):
        whole = log.rows()
        for names in [*((name,) for name in log.columns), log.columns[::-1]]:
            require_equal(log.rows(names), whole, f"{' and '.join(names)} alone" if len(names) == 1 else "reversed")


@check("log-again")
def it_can_be_read_again(reader: LogFormat, folder: Path) -> None:
    """A second pass over a log, and a second `read` of the file, give the same rows."""
    path = write_example(reader, folder)
    for log, other in zip(read_at_first(reader, path), read_at_first(reader, path), strict=True):
        whole = log.rows()
        for again, what in ((log.rows(), "in a second pass"), (other.rows(), "in a second read")):
            require(len(again) == len(whole), f"{what} there are {len(again)} rows, and {len(whole)} before")
            require_equal(again, whole, what)


@check("log-order")
def rows_are_in_order(reader: LogFormat, folder: Path) -> None:
    """Time does not fall. In each env episodes count up from 0, and steps within an episode from 0 or 1.

    ``terminated`` and ``truncated`` are true where an episode ends, and nowhere else. Where a log has both columns, one
    of them is true at the end of every episode but the last, which may be unfinished.
    """
    for log in read_example(reader, folder):
        rows = log.rows()
        for name in {"time", "length"} & {*rows.columns}:
            require((rows[name] >= 0).all(), f"the column {name} is negative: {rows[name].min()}")
        if "time" in rows.columns:
            require((np.diff(rows["time"]) >= 0).all(), f"the time falls: {rows['time'][:20]}")
        if log.facts.unit == "step" and {"episode", "step"} <= {*rows.columns}:  # another check says so
            require_order_of_steps(rows)


@check("log-finite")
def values_are_finite(reader: LogFormat, folder: Path) -> None:
    """Nothing is infinite, and pay and times are never NaN, but for what the facts say has failed.

    Any other column may be NaN in rows of which it is not known, and ``since`` in all. A measure is known in some row,
    and within its bounds.
    """
    for log in read_example(reader, folder):
        failed, rows = {it.column for it in log.facts.failed}, log.rows()
        for name, values in rows.columns.items():
            if values.dtype.kind == "f":
                unknown = np.isnan(values)
                require(is_countable(values[~unknown]).all(), f"{name} is beyond {LARGEST:g}")
                may_lack = name in (*failed, SINCE) or not (name.startswith(KNOWN) or unknown.all())
                require(may_lack or not unknown.any(), f"the column {name} is NaN, and facts.failed has no word of it")
        for measure, (least, greatest) in log.facts.bounds.items():
            values = rows[f"{BEHAVIOUR}{measure}"]
            outside = ((values < least) | (values > greatest)).any()
            require(not outside, f"{measure} leaves its bounds, {least:g} to {greatest:g}")


@check("log-terms")
def terms_make_their_reward(reader: LogFormat, folder: Path) -> None:
    """The terms of a reward, ``reward/NAME/TERM``, sum to ``reward/NAME`` in every row."""
    for log in read_example(reader, folder):
        rows = log.rows()
        for name in log.rewards:
            terms = [rows[f"{REWARD}{name}/{term}"].astype(float) for term in log.terms_of(name)]
            paid = rows[f"{REWARD}{name}"]
            close = not terms or np.allclose(sum(terms), paid, rtol=ROUNDING, atol=ROUNDING, equal_nan=True)
            require(close, f"the terms of {name}, {', '.join(log.terms_of(name))}, do not sum to it")


@check("log-unknown")
def unknown_columns_are_refused(reader: LogFormat, folder: Path) -> None:
    """Who asks for a column that there is not gets a `UsageError` that names it, and no numbers."""
    for log in read_example(reader, folder):
        try:
            log.rows([NO_COLUMN])
        except UsageError as error:
            require(NO_COLUMN in str(error), f"a column that there is not is refused without its name: {error}")
        else:
            raise AssertionError(f"it has numbers for the column {NO_COLUMN}, which it does not list")


@check("log-left-alone")
def the_file_is_left_alone(reader: LogFormat, folder: Path) -> None:
    """Recognising and reading change no byte of the log, and write nothing beside it."""
    path = write_example(reader, folder)
    before = state_of(folder)
    _recognised(reader, path)
    for log in read_logs(reader, path):
        log.rows()
    after = state_of(folder)
    new, changed = sorted(after.keys() - before.keys()), [it for it in before if after.get(it) != before[it]]
    require(not new, f"reading wrote {', '.join(new)}")
    require(not changed, f"reading changed {', '.join(changed)}")


@check("log-silent")
def nothing_is_printed(reader: LogFormat, folder: Path) -> None:
    """Reading prints nothing, to neither stream: what is to be said stands in the facts."""
    path = write_example(reader, folder)
    with quietly() as told:
        _recognised(reader, path)
        for log in read_logs(reader, path):
            log.rows()
    require(not told.getvalue(), f"it printed {told.getvalue()[:100]!r}")


@check("log-no-code")
def reading_runs_no_code(reader: LogFormat, folder: Path) -> None:
    """Reading runs nothing that stands in the file: no pickle, no `eval`, no `numpy.load(allow_pickle=True)`."""
    path = write_example(reader, folder)
    whole = [log.rows() for log in read_logs(reader, path)]  # libraries are imported, which may run code of theirs
    with without_code():
        again = [log.rows() for log in read_logs(reader, path)]
    for rows, before in zip(again, whole, strict=True):
        require_equal(rows, before, "without code")


@check("log-cut")
def a_cut_file_gives_no_other_numbers(reader: LogFormat, folder: Path) -> None:
    """A file that is cut anywhere is refused by a `SchemaError` or a `UsageError`, or its first rows are read.

    A log that is being written looks so. Where a row is cut in the middle, the notes or `thinned` say what is missing.
    Where the cut falls between two rows nobody can know.
    """
    example = write_example(reader, folder)
    whole = whole_of(read_logs(reader, example))
    silent: dict[tuple[Path, int], bool] = {}
    for copy, file, length in cut_copies(example, folder):
        what = f"of {file.name}, cut to {length:,} bytes,"
        damaged = read_damaged(reader, copy, what)
        require_beginnings(damaged, whole)
        silent[file, length] = is_silent(damaged, whole)
        neighbours = (silent.get((file, length - less)) for less in range(AT_ENDS + 1))
        require(not all(neighbours), f"{what} rows are missing, and neither notes nor thinned say so")


@check("log-changed")
def a_changed_file_gives_no_other_numbers(reader: LogFormat, folder: Path) -> None:
    """A file in which 8 bytes are 0xFF is refused by a `SchemaError` or a `UsageError`, or its rows are as before.

    Only a binary file may hold other numbers then: not every format has checksums.
    """
    example = write_example(reader, folder)
    whole = whole_of(read_logs(reader, example))
    texts = {file.relative_to(example) for file in files_of(example) if is_text(file)}
    for copy, file, begin in changed_copies(example, folder):
        damaged = read_damaged(reader, copy, f"of {file.name}, with other bytes from {begin:,} on,")
        if file.relative_to(copy) in texts:
            require_beginnings(damaged, whole)
            require(not is_silent(damaged, whole), f"{damaged.what} rows are missing, and no note says so")


LOG_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    the_example_is_a_log,
    the_example_is_recognised,
    recognising_raises_nothing,
    facts_are_sensible,
    declared_totals_hold,
    standard_columns_are_there,
    columns_hold_what_their_names_say,
    pieces_make_the_whole,
    columns_can_be_chosen,
    it_can_be_read_again,
    rows_are_in_order,
    values_are_finite,
    terms_make_their_reward,
    unknown_columns_are_refused,
    the_file_is_left_alone,
    nothing_is_printed,
    reading_runs_no_code,
    a_cut_file_gives_no_other_numbers,
    a_changed_file_gives_no_other_numbers,
)


def _recognised(reader: LogFormat, path: Path, head: bytes | None = None) -> bool:
    """What `recognises` says of a path, or of another head."""
    found = reader.recognises(path, head_of(path) if head is None else head)
    require(isinstance(found, bool), f"recognises returned {found!r}, neither True nor False")
    return found
