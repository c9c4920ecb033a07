"""Copies of a log's example that are cut or changed, and what may be read of them."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from harness.errors import SchemaError, UsageError, one_line
from harness.log import Log, LogFacts, LogFormat, Rows

from ..contract import require
from .examples import called, equal, files_of

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
