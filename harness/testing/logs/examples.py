"""The example of a log format: how the kit writes and reads it, and what it compares."""

import contextlib
import hashlib
import io
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from harness.log import Log, LogFormat, Rows
from harness.log.format import HEAD
from harness.testing.violations import require

RUNS_CODE = ("pickle.load", "pickle.loads", "pickle.Unpickler", "builtins.eval", "builtins.exec", "os.system")
"""What runs code that stands in a file."""


def write_example(reader: LogFormat, folder: Path) -> Path:
    """The example in a folder of its own, so that what appears beside it is seen."""
    place = folder / "example"
    place.mkdir()
    path = reader.write_example(place)
    require(isinstance(path, Path), f"write_example returned {path!r}, not a path")
    inside = path.is_relative_to(place) and path.exists()
    require(inside, f"write_example returned '{path}', which is not in the folder that it was given")
    return path


def read_example(reader: LogFormat, folder: Path) -> tuple[Log, ...]:
    """The logs of the example."""
    return read_logs(reader, write_example(reader, folder))


def read_logs(reader: LogFormat, path: Path) -> tuple[Log, ...]:
    """The logs of the example, whose rows can be read.

    Raises:
        AssertionError: They cannot; the check `log-example` says why.
    """
    try:
        logs = read_at_first(reader, path)
        for log in logs:
            log.rows()
    except Exception as error:  # a plugin may raise anything
        raise AssertionError("the example cannot be read: see log-example") from error
    return logs


def read_at_first(reader: LogFormat, path: Path) -> tuple[Log, ...]:
    """The logs of the example; at least one.

    Raises:
        AssertionError: There is none, or something else.
        Exception: Whatever the reader raises.
    """
    logs = reader.read(path)
    require(isinstance(logs, Sequence), f"read returned {type(logs).__name__}, not a list or a tuple of logs")
    require(len(logs) > 0, "read returned no log of the example")
    for log in logs:
        require(isinstance(log, Log), f"read returned a {type(log).__name__} among the logs, not a harness.log.Log")
    return tuple(logs)


def called(log: Log) -> str:
    """How a sentence names a log of the example."""
    return f"the log '{log.facts.run}'" if log.facts.run else "the log"


def head_of(path: Path) -> bytes:
    """What `recognises` is given of a file or a folder."""
    if not path.is_file():
        return b""
    with path.open("rb") as file:
        return file.read(HEAD)


def files_of(path: Path) -> list[Path]:
    """A file itself, or all files of a folder."""
    return [path] if path.is_file() else sorted(it for it in path.rglob("*") if it.is_file())


def state_of(folder: Path) -> dict[str, str]:
    """Everything in a folder: each file with its checksum and its times, each folder with nothing."""
    return {it.relative_to(folder).as_posix(): _state(it) for it in sorted(folder.rglob("*"))}


def _state(path: Path) -> str:
    if not path.is_file():
        return ""
    return f"{hashlib.sha256(path.read_bytes()).hexdigest()} {path.stat().st_mtime_ns}"


def equal(one: Any, other: Any) -> bool:
    """Whether two columns are the same; NaN is the same as NaN."""
    one, other = np.asarray(one), np.asarray(other)
    if one.shape != other.shape:
        return False
    can_be_nan = one.dtype.kind in "fc" and other.dtype.kind in "fc"
    return bool(np.array_equal(one, other, equal_nan=can_be_nan))


def require_equal(rows: Rows, whole: Rows, where: str) -> None:
    """See that all columns of `rows` are as they are in `whole`."""
    for name, values in rows.columns.items():
        require(
            equal(values, whole[name]), "{}: the column {} is {}, and {} in all rows", where, name, values, whole[name]
        )


@contextlib.contextmanager
def quietly() -> Iterator[io.StringIO]:
    """What is printed in this block, to either stream."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
        yield told


@contextlib.contextmanager
def without_code() -> Iterator[None]:
    """In this block nothing that a file holds can run: no pickle, and no text given to `eval`, `exec` or `os.system`.

    Raises:
        AssertionError: The block tried, whatever became of it.
    """
    tried: list[str] = []
    load = np.load

    def refusing(what: str) -> Any:
        def refuse(*_: Any, **__: Any) -> Any:
            tried.append(what)
            raise PermissionError(f"{what} is not allowed here")

        return refuse

    def load_arrays(file: Any, mmap_mode: Any = None, allow_pickle: bool = False, **named: Any) -> Any:
        if allow_pickle:
            refusing("numpy.load(allow_pickle=True)")()
        return load(file, mmap_mode, allow_pickle=False, **named)

    try:
        with contextlib.ExitStack() as stack:
            for name in RUNS_CODE:
                stack.enter_context(mock.patch(name, refusing(name.removeprefix("builtins."))))
            stack.enter_context(mock.patch.object(np, "load", load_arrays))
            yield
    finally:
        require(not tried, f"it read with {', '.join(tried)}: who wrote the file could run anything on this machine")


def random_bytes(count: int) -> bytes:
    """The same ones each time."""
    return np.random.default_rng(count).bytes(count)


def odd_places(folder: Path) -> list[Path]:
    """What a walk through folders meets: folders, links to nowhere, names in odd characters, nothing at all."""
    (folder / "empty").mkdir()
    (folder / "nowhere").symlink_to(folder / "gone")
    names = [
        "nothing.csv",
        "ü 'a' \"b\" %s\n.csv",
        "-",
        "x" * 200,
        "progress.csv",
        "data.npz",
        "data.hdf5",
        "info.json",
    ]
    files = [folder / name for name in names]
    files.append(folder / os.fsdecode(b"\xff\xfe.csv"))
    for file in files:
        file.write_bytes(b"" if file.name == "nothing.csv" else random_bytes(300))
    return [folder, folder / "empty", folder / "nowhere", folder / "gone", *files]
