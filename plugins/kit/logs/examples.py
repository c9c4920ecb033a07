"""The example of a log format: how the kit writes and reads it, and what it compares."""

import contextlib
import hashlib
import io
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args
from unittest import mock

import numpy as np

from harness.log import Log, LogFacts, LogFormat, Rows
from harness.log.facts import Unit
from harness.log.format import HEAD
from harness.log.log import BEHAVIOUR
from harness.reward.steps import ENDS

from ..contract import require

NEEDED: Mapping[Unit, tuple[tuple[str, ...], ...]] = MappingProxyType(
    {
        "step": (("episode",), ("step",)),
        "episode": (("length", "time"),),
        "point": (("time", "iteration"),),
    }
)
"""By unit, the columns that a log must have; of several in one tuple, one."""
NUMBERS = {"env": "iu", "episode": "iu", "step": "iu", "start": "b", "terminated": "b", "truncated": "b"}
"""Kinds of numpy types that standard columns have: whole numbers and truth values are no floats."""


def require_order_of_steps(rows: Rows) -> None:
    """See that in each env episodes count up from 0, steps within them from 0 or 1, and ends stand at their ends."""
    envs = rows.columns.get("env", np.zeros(len(rows), int))
    for env in np.unique(envs):
        of_env = rows.part(envs == env)
        require_counts(of_env, f"env {env}")
        require_ends(of_env, f"env {env}")


def require_counts(rows: Rows, env: str) -> None:
    """See that episodes and steps of one env count up."""
    episode, step = rows["episode"].astype(int), rows["step"].astype(int)
    begins = np.concatenate([[True], np.diff(episode) != 0])
    require(episode[0] == 0, f"{env}: its episodes begin with {episode[0]}, not 0")
    require(np.isin(np.diff(episode), (0, 1)).all(), f"{env}: its episodes do not count up by one: {episode[:20]}")
    require(np.isin(step[begins], (0, 1)).all(), f"{env}: the steps of an episode begin with {step[begins][:9]}")
    require((np.diff(step)[~begins[1:]] == 1).all(), f"{env}: its steps do not count up by one: {step[:20]}")
    if "start" in rows.columns:
        require(not (rows["start"] & (step != 0)).any(), f"{env}: a row is a start and has a step that is not 0")


def require_ends(rows: Rows, env: str) -> None:
    """See that episodes of one env end where it is said; of a log with both ends, that it is said where they end."""
    told = [rows[name].astype(bool) for name in ENDS if name in rows.columns]
    if not told:
        return
    ended, goes_on = np.any(told, axis=0)[:-1], np.diff(rows["episode"].astype(int)) == 0
    require(not (ended & goes_on).any(), f"{env}: an episode goes on after a row that ended it")
    without = rows["episode"][:-1][~ended & ~goes_on]
    if len(told) == 2:
        why = "is ended by neither terminated nor truncated, and another begins"
        require(not len(without), "{}: episode {} {}", env, without[:1], why)


def broken_types(rows: Rows) -> Iterator[str]:
    """A sentence for each column whose values are not what its name says."""
    for name, values in rows.columns.items():
        wanted = NUMBERS.get(name, "")
        if wanted and values.dtype.kind not in wanted:
            yield f"the column {name} holds {values.dtype}, not {'truth values' if wanted == 'b' else 'whole numbers'}"
        if values.dtype.kind == "O" and not all(isinstance(value, str) for value in values.flat):
            yield f"the column {name} holds Python objects, neither numbers nor texts"
        if name.startswith(("reward/", "behaviour/")) and (values.ndim != 1 or values.dtype.kind not in "biuf"):
            yield f"the column {name} holds {values.dtype} of shape {values.shape}, not one number a row"


def faults_of(log: Log, path: Path) -> Iterator[str]:
    """A sentence for each fact that is not as it has to be.

    Args:
        log: One of the logs of the example.
        path: What was read.
    """
    if not log.facts.path.is_relative_to(path):
        yield f"facts.path is '{log.facts.path}', and '{path}' was read"
    if log.facts.unit not in get_args(Unit):
        yield f"facts.unit is {log.facts.unit!r}, none of {', '.join(get_args(Unit))}"
    yield from _faults_of_texts(log.facts)
    yield from _faults_of_numbers(log.facts)
    yield from _faults_of_columns(log)


def counts_of(log: Log) -> dict[str, int]:
    """The totals that a log's own rows have, by the names that `harness.log.LogFacts.declared` gives them."""
    if log.facts.unit == "episode":
        steps = {"steps": int(log["length"].sum())} if "length" in log else {}
        return {"episodes": len(log), **steps}
    if log.facts.unit == "step" and "episode" in log:
        starts = int(log["start"].sum()) if "start" in log else 0
        pairs = np.stack([log["env"] if "env" in log else 0 * log["episode"], log["episode"]])
        return {"episodes": np.unique(pairs, axis=1).shape[1], "steps": len(log) - starts}
    return {}


def _faults_of_texts(facts: LogFacts) -> Iterator[str]:
    if not facts.format:
        yield "facts.format is empty: say which program writes this"
    for text in (facts.format, facts.run, facts.trained_with, facts.env, facts.algorithm, facts.thinned, *facts.notes):
        if not isinstance(text, str) or "\n" in text:
            yield f"facts hold {text!r}, where one line of text is wanted"


def _faults_of_numbers(facts: LogFacts) -> Iterator[str]:
    if facts.seed is not None and type(facts.seed) is not int:  # a truth value is an int too
        yield f"facts.seed is {facts.seed!r}, neither an int nor None"
    for name, count in {"asked": facts.asked, **facts.declared}.items():
        if type(count) is not int or count < 0:
            yield f"facts tell {count!r} {name}, not a whole number of at least 0"
    for least, greatest in facts.bounds.values():
        if math.isnan(least) or not least < greatest:
            yield f"facts.bounds hold {least} to {greatest}"


def _faults_of_columns(log: Log) -> Iterator[str]:
    for name in (*log.facts.lower_is_better, *log.facts.higher_is_better, *log.facts.bounds):
        if name not in log.measures:
            yield f"facts tell of the measure {name}, which has no column {BEHAVIOUR}{name}"
    for failed in log.facts.failed:
        if failed.column not in log or not failed.reason:
            yield f"facts.failed has {failed}: a column that there is, and the reason, are wanted"


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
