"""Folders of event files, ``events.out.tfevents.*``, as TensorBoard shows them: curves by tag."""

import struct
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from harness.errors import SchemaError
from harness.eta.laws import NEARLY_ALL
from harness.files.bounded import reading, require_regular
from harness.log import LARGEST, Log, LogFacts

from ..curves import CLEANRL_RUN, Roles, curve

MARK = "tfevents"
MOST_BYTES = 2**31
MOST_POINTS = 20_000_000
FRAME = 16
"""Bytes around each event: its length, and two checksums."""
SOON = 0.05
"""The share of a training before which a file that begins again is of another one: no checkpoint is so early."""
HYPERPARAMETERS = "hyperparameters/text_summary"


@dataclass(frozen=True)
class _Series:
    """What the files hold of one tag, as numbers of 8 bytes."""

    steps: "array[float]" = field(default_factory=lambda: array("d"))
    values: "array[float]" = field(default_factory=lambda: array("d"))


@dataclass(frozen=True)
class _File:
    """What one event file holds."""

    path: Path
    series: dict[str, _Series] = field(default_factory=dict)
    told: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class TensorBoard(Roles):
    """Curves of a folder of event files, with all of their points: TensorBoard's own page shows a sample of them."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """A folder in which an event file lies, or such a file, by its name."""
        try:
            return bool(_event_files(path))
        except OSError:
            return False

    def read(self, path: Path) -> tuple[Log, ...]:
        """The training of a folder, or of one event file; several if files of the folder begin anew.

        A training that was continued from a checkpoint has a file for each of its parts. What was logged again after
        the checkpoint counts, and what stood there before does not.

        Raises:
            UsageError: A tag that was named is not there, or none is known.
            SchemaError: A file is damaged before its end.
        """
        files = [_read_file(file) for file in _event_files(path)]
        names = sorted({tag for file in files for tag in file.series})
        if not names:
            raise SchemaError(f"{path} holds no event file with numbers")
        main = self.chosen(path, names).main
        for file in files:  # steps only rise in one: a training that is continued begins another
            steps = np.array(file.series.get(main, _Series()).steps)
            back = np.flatnonzero(np.diff(steps) < 0.0)
            if len(back):
                way = f"{steps[back[0]]:,.0f} to {steps[back[0] + 1]:,.0f}"
                raise SchemaError(
                    f"{file.path}: the steps of '{main}' go from {way}: several trainings log into one file"
                )
        trainings = _trainings(files, main)
        ends = [_span(parts, main)[1] for parts in trainings]
        is_begun_again = len(ends) > 1 and max(ends[:-1]) < NEARLY_ALL * ends[-1]
        note = f"the folder holds {len(trainings)} trainings, each in event files of its own"
        if is_begun_again:
            note = f"it was begun {len(trainings)} times, and went on to the end the last time, which counts"
        told = [note] if len(trainings) > 1 else []
        if is_begun_again or len(trainings) == 1:
            return (self._log(path, trainings[-1], "", told),)
        return tuple(self._log(path, parts, str(run), told) for run, parts in enumerate(trainings))

    def write_example(self, folder: Path) -> Path:
        """Four points under the names of stable-baselines3."""
        from tensorboard.summary import Writer  # it takes a second

        writer = Writer(str(folder))
        for point in range(4):
            for tag, value in (("ep_rew_mean", -10.0 + point), ("ep_len_mean", 50.0), ("success_rate", point / 4)):
                writer.add_scalar(f"rollout/{tag}", value, 2048 * (point + 1))
        writer.close()
        return folder

    def _log(self, path: Path, files: Sequence[_File], run: str, notes: Sequence[str]) -> Log:
        joined: dict[str, _Series] = {}
        for file in files:
            for tag, series in file.series.items():
                whole = joined.setdefault(tag, _Series())
                whole.steps.extend(series.steps)
                whole.values.extend(series.values)
        told = {key: value for file in files for key, value in file.told.items()}
        named = CLEANRL_RUN.fullmatch(path.name)
        env, algorithm, seed = named.group("env", "algorithm", "seed") if named else ("", "", "")
        seed = told.get("seed", seed)
        facts = LogFacts(
            path=path,
            format="TensorBoard",
            run=run,
            env=told.get("env_id", env),
            algorithm=told.get("exp_name", algorithm).partition("_")[0],
            seed=int(seed) if seed.isdecimal() else None,
            asked=int(told["total_timesteps"]) if told.get("total_timesteps", "").isdecimal() else 0,
            notes=(*notes, *(note for file in files for note in file.notes)),
        )
        tags = {tag: (it.steps, it.values) for tag, it in joined.items()}
        return curve(facts, tags, self)


def _event_files(path: Path) -> list[Path]:
    """By name, which begins with the time at which each was begun."""
    files = path.iterdir() if path.is_dir() else [path]
    return sorted(file for file in files if MARK in file.name and file.is_file())


def _read_file(path: Path) -> _File:
    """All numbers of an event file, up to an event that is not yet written to its end."""
    from tensorboard.backend.event_processing.event_file_loader import RawEventFileLoader
    from tensorboard.compat.proto.event_pb2 import Event

    found = _File(path)
    with reading(path, "event file of TensorBoard"):
        require_regular(path, MOST_BYTES)
        end = path.stat().st_size  # what is written while we read is for the next time
        size, points = 0, 0
        for record in RawEventFileLoader(str(path)).Load():
            size += len(record) + FRAME
            event = Event.FromString(record)
            for value in event.summary.value:
                number = _number(value)
                if number is not None:
                    series = found.series.setdefault(value.tag, _Series())
                    series.steps.append(float(event.step))
                    series.values.append(number)
                    points += 1
                elif value.tag == HYPERPARAMETERS:
                    found.told.update(_hyperparameters(value))
            if points > MOST_POINTS:
                raise SchemaError(f"{path} has more than the {MOST_POINTS:,} points that are allowed")
        left = _left_over(path, size, end)
        if left:
            found.notes.append(f"the last {left:,} bytes of {path.name} are no whole event yet: they are left out")
    return found


def _left_over(path: Path, size: int, end: int) -> int:
    """Bytes behind the last event that was read, of an event that was not written to its end.

    Args:
        path: The file.
        size: Bytes of the events that were read.
        end: Bytes that it had before.

    Raises:
        SchemaError: More stands there than the beginning of an event: the file is damaged.
    """
    left = max(end - size, 0)
    with path.open("rb") as file:
        file.seek(size)
        head = file.read(min(8, left))
    is_begun = len(head) < 8 or not any(head) or struct.unpack("<Q", head)[0] + FRAME > left
    if left and (not is_begun or (size == 0 and left > FRAME)):
        raise SchemaError(f"{path} is damaged from byte {size:,} of {end:,} on")
    return left


def _number(value: Any) -> float | None:
    """A scalar, as writers of version 1 and 2 keep it; None of anything else."""
    if value.HasField("simple_value"):
        return float(value.simple_value)
    if not value.HasField("tensor") or value.metadata.plugin_data.plugin_name not in ("scalars", ""):
        return None
    from tensorboard.util import tensor_util

    numbers: Any = tensor_util.make_ndarray(value.tensor)
    return float(numbers.item()) if numbers.size == 1 and numbers.dtype.kind in "biuf" else None


def _hyperparameters(value: Any) -> dict[str, str]:
    """What CleanRL writes of a training: a table of two columns, as text."""
    text = b"".join(value.tensor.string_val).decode("utf-8", "replace")
    rows = [line.strip("|").split("|") for line in text.splitlines()]
    return {row[0].strip(): row[1].strip() for row in rows if len(row) == 2}


def _trainings(files: Sequence[_File], tag: str) -> list[list[_File]]:
    """Files by training: one that begins where the training before it had just begun is the first of another."""
    trainings: list[list[_File]] = []
    for file in files:
        first, _ = _span([file], tag)
        begin, end = _span(trainings[-1], tag) if trainings else (0.0, 0.0)
        if not trainings or first <= begin + SOON * (end - begin) < LARGEST:
            trainings.append([file])
        else:
            trainings[-1].append(file)
    return trainings


def _span(files: Sequence[_File], tag: str) -> tuple[float, float]:
    """The first and the last step of a tag; beyond all steps where files have none."""
    steps = [step for file in files if tag in file.series for step in file.series[tag].steps]
    return (min(steps), max(steps)) if steps else (LARGEST, LARGEST)
