"""Finds the reader of a file or a folder among the registered formats, and all logs below a folder."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NamedTuple

from harness.errors import AskedError, HarnessError, SchemaError, UsageError, reason_of
from harness.files.bounded import kind_at, open_regular
from harness.log.format import HEAD, LogFormat
from harness.log.log import Log
from harness.registry.choice import Registry, choose
from harness.registry.spec import blamed_on, nothing_at
from harness.text import command_text

LOGS = "logs"
GONE = ("monitor", "progress-csv", "wandb-csv", "tensorboard-csv", "episode-csv")
"""Formats of earlier versions, whose files one reader of tables takes."""
MOST_FILES = 100_000
"""Files and folders that are looked at below a folder."""
MOST_BYTES = 2**35


class Found(NamedTuple):
    """What lies below a folder."""

    logs: tuple[Log, ...]
    """By path."""
    left_out: tuple[tuple[Path, str], ...]
    """What is a log and cannot be read, and why."""


def open_logs(path: Path, registry: Registry, named: str = "", **settings: Any) -> tuple[Log, ...]:
    """The logs in one file, or in one folder that is a log itself.

    Args:
        path: The file or the folder. A format with the class attribute ``takes_names = True`` also takes a name by
            which its program finds it.
        registry: Has the formats.
        named: The format with its settings, ``rosbag:topic=/pay``; found by what the file is if empty.
        settings: Further settings of the format, as flags of a command give them.

    Raises:
        UsageError: It is not there, no format recognises it, or several do; or the format has no such setting.
        SchemaError: It is damaged.
    """
    formats = formats_of(registry, named)
    takes_names = named and getattr(formats[named], "takes_names", False)
    if not takes_names and not path.exists():
        raise UsageError(nothing_at(path))
    names = [named] if named else recognised(path, formats)
    if len(names) > 1:
        told = " or ".join(command_text("harness", "audit", f"{name}:{path}") for name in names)
        raise UsageError(f"'{path}' could be a log of several formats: say which, {told}")
    if not names:
        kind = None if path.is_dir() else kind_at(path)
        told = f". It is {kind.sentence}" if kind else ""
        raise UsageError(f"'{path}' is no log that is read: harness describe logs tells which are{told}")
    return _read(path, names[0], formats[names[0]], registry, settings)


def find_logs(path: Path, registry: Registry, named: str = "") -> Found:
    """All logs in a file or below a folder, at any depth.

    A format that recognises a folder reads it as one log; formats of files still see the files in it, unless the
    format says that it is all of the folder, by the class attribute ``takes_all = True``.

    Raises:
        UsageError: It is not there, or has more files than are looked at.
    """
    if not path.exists():
        raise UsageError(nothing_at(path))
    logs = dict[tuple[Path, str, str], Log]()
    left_out: list[tuple[Path, str]] = []
    for place, read in _all_logs(path, registry, named):
        if isinstance(read, str):
            left_out.append((place, read))
            continue
        for log in read:
            logs.setdefault((log.facts.path, log.facts.run, log.facts.format), log)
    return Found(tuple(logs.values()), tuple(left_out))


def first_log(path: Path, registry: Registry) -> Log | None:
    """The first log in a file or below a folder that can be read, without a look at the others; None without one."""
    return next((read[0] for _, read in _all_logs(path, registry) if not isinstance(read, str)), None)


def _all_logs(path: Path, registry: Registry, named: str = "") -> Iterator[tuple[Path, tuple[Log, ...] | str]]:
    """Each place with its logs, or why it cannot be read."""
    formats = formats_of(registry, named)
    for place, name in _places(path, formats):
        try:
            yield place, _read(place, name, formats[name], registry)
        except AskedError:
            raise
        except HarnessError as error:
            yield place, str(error)


def formats_of(registry: Registry, named: str = "") -> dict[str, Any]:
    """Every registered format whose libraries are installed, by name; or the one that was named, with its settings."""
    old, colon, told = named.partition(":")
    if old in GONE and old not in registry.names(LOGS):
        raise UsageError(f"The format '{old}' is gone: one reader takes all tables. Type --as 'table{colon}{told}'")
    names = [named] if named else [it for it in registry.names(LOGS) if not registry.get(LOGS, it).missing]
    return {name: choose(registry, LOGS, name).build(registry, LOGS) for name in names}


def _places(path: Path, formats: Mapping[str, LogFormat]) -> Iterator[tuple[Path, str]]:
    """Each place and the format that reads it. A file that several formats recognise is offered to each of them."""
    if path.is_file():
        yield from ((path, name) for name in recognised(path, formats))
        return
    seen = 0
    for folder, inner, files in os.walk(path):
        inner.sort()
        seen += 1 + len(files)
        if seen > MOST_FILES:
            raise UsageError(f"'{path}' has more than {MOST_FILES:,} files: name a smaller folder")
        place = Path(folder)
        taken = recognised(place, formats)
        yield from ((place, name) for name in taken)
        if any(getattr(formats[name], "takes_all", False) for name in taken):
            inner.clear()
            continue
        others = {name: it for name, it in formats.items() if name not in taken}
        for file in sorted(files):
            yield from ((place / file, name) for name in recognised(place / file, others))


def recognised(path: Path, formats: Mapping[str, LogFormat]) -> list[str]:
    """The names of the formats that recognise a file or a folder."""
    head = b""
    if not path.is_dir():
        try:
            with open_regular(path, MOST_BYTES) as file:
                head = file.read(HEAD)
        except OSError:
            return []
    return [name for name, it in formats.items() if it.recognises(path, head)]


def _read(path: Path, name: str, reader: Any, registry: Registry, settings: Mapping[str, Any] = {}) -> tuple[Log, ...]:
    spec = registry.get(LOGS, choose(registry, LOGS, name).name)
    for setting in settings:
        if setting not in {field.name for field in fields(reader)}:
            raise UsageError(
                f"--{setting.replace('_', '-')} says nothing of '{path}': a log of the format {spec.name} has none"
            )
    with blamed_on(spec, "it read a log"):
        try:
            read = replace(reader, **settings).read(path)
            logs = tuple(replace(log, facts=replace(log.facts, reader=spec.name)) for log in read)
        except HarnessError:
            raise
        except (OSError, ValueError) as error:
            raise SchemaError(f"{path} cannot be read as {name}: {reason_of(error)}") from error
    if not logs:
        raise SchemaError(f"{path} holds no training")
    return logs
