"""Folders of event files, ``events.out.tfevents.*``, as TensorBoard shows them: curves by tag."""

import re
import struct
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness.errors import SchemaError
from harness.files import open_regular, reading
from harness.log import Log, LogFacts

from ..curves import NEARLY_ALL, SOON, Roles, cleanrl_run, curve
from ..zoo_settings import whole

MARK = "tfevents"
MOST_BYTES = 2**31
FRAME = 16
"""Bytes around each event: its length, and two checksums."""
HYPERPARAMETERS = "hyperparameters/text_summary"
ROW = re.compile(r"^\| *(.*?) *\| *(.*?) *\|$", re.MULTILINE)
"""A row of the table of hyperparameters that CleanRL writes of a training, as text."""


class _File(NamedTuple):
    """What one event file holds."""

    series: Mapping[str, "tuple[array[float], array[float]]"]
    """By tag the steps and the values of its points, as numbers of 8 bytes."""
    told: Mapping[str, str]
    note: str


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
        places = _event_files(path)
        files = [_read_file(it) for it in places]
        names = sorted({tag for file in files for tag in file.series})
        if not names:
            raise SchemaError(f"{path} holds no event file with numbers")
        main = self.chosen(path, names).main
        trainings, begin, ends = [list[_File]()], 0.0, list[float]()
        for place, file in zip(places, files, strict=True):
            steps = np.array(file.series[main][0] if main in file.series else [])
            for at in np.flatnonzero(np.diff(steps) < 0.0):  # a training that is continued begins another file
                raise SchemaError(
                    f"{place}: the steps of '{main}' go from {steps[at]:,.0f} to {steps[at + 1]:,.0f}: several "
                    "trainings log into one file"
                )
            if len(steps) and (not ends or steps[0] <= begin + SOON * (ends[-1] - begin)):
                if ends:
                    trainings.append([])
                begin = steps[0]
                ends.append(begin)
            if len(steps):
                ends[-1] = max(ends[-1], steps[-1])
            trainings[-1].append(file)
        told = [f"the folder holds {len(trainings)} trainings, each in event files of its own"]
        if len(ends) == 1:
            told = []
        elif max(ends[:-1]) < NEARLY_ALL * ends[-1]:
            told = [f"it was begun {len(ends)} times, and went on to the end the last time, which counts"]
            trainings = trainings[-1:]
        several = len(trainings) > 1
        return tuple(self._log(path, of, str(run) * several, told) for run, of in enumerate(trainings))

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
        told = {key: value for file in files for key, value in file.told.items()}
        of_run = {"env": "", "algorithm": "", "seed": "", **cleanrl_run(path.name)}
        facts = LogFacts(
            path=path,
            format="TensorBoard",
            run=run,
            env=told.get("env_id", of_run["env"]),
            algorithm=told.get("exp_name", of_run["algorithm"]).partition("_")[0],
            seed=whole(told.get("seed", f"{of_run['seed']}")),
            asked=whole(told.get("total_timesteps", "")) or 0,
            notes=(*notes, *(file.note for file in files if file.note)),
        )
        series = {}
        for tag in dict.fromkeys(tag for file in files for tag in file.series):
            parts = zip(*(it.series[tag] for it in files if tag in it.series), strict=True)
            series[tag] = [np.concatenate(of) for of in parts]
        return curve(facts, series, self)


def _event_files(path: Path) -> list[Path]:
    """By name, which begins with the time at which each was begun."""
    files = path.iterdir() if path.is_dir() else [path]
    return sorted(file for file in files if MARK in file.name and file.is_file())


def _read_file(path: Path) -> _File:
    """All numbers of an event file, up to an event that is not yet written to its end.

    Raises:
        SchemaError: It is damaged: more stands behind its events than the beginning of one.
    """
    from tensorboard.backend.event_processing.event_file_loader import RawEventFileLoader
    from tensorboard.compat.proto.event_pb2 import Event

    series = dict[str, "tuple[array[float], array[float]]"]()
    told = dict[str, str]()
    with reading(path, "event file of TensorBoard"), open_regular(path, MOST_BYTES) as file:
        end = path.stat().st_size  # what is written while we read is for the next time
        size = 0
        for record in RawEventFileLoader(str(path)).Load():
            size += len(record) + FRAME
            event = Event.FromString(record)
            for value in event.summary.value:
                number = _number(value)
                if number is not None:
                    steps, values = series.setdefault(value.tag, (array("d"), array("d")))
                    steps.append(event.step)
                    values.append(number)
                elif value.tag == HYPERPARAMETERS:
                    told.update(ROW.findall(b"".join(value.tensor.string_val).decode("utf-8", "replace")))
        left = max(end - size, 0)
        file.seek(size)
        head = file.read(min(8, left))
        is_begun = len(head) < 8 or not any(head) or struct.unpack("<Q", head)[0] + FRAME > left
        if left and (not is_begun or (size == 0 and left > FRAME)):
            raise SchemaError(f"{path} is damaged from byte {size:,} of {end:,} on")
    cut = f"the last {left:,} bytes of {path.name} are no whole event yet: they are left out" if left else ""
    return _File(series, told, cut)


def _number(value: Any) -> float | None:
    """A scalar, as writers of version 1 and 2 keep it; None of anything else."""
    if value.HasField("simple_value"):
        return float(value.simple_value)
    if not value.HasField("tensor") or value.metadata.plugin_data.plugin_name not in ("scalars", ""):
        return None
    from tensorboard.util import tensor_util

    numbers: Any = tensor_util.make_ndarray(value.tensor)
    return float(numbers.item()) if numbers.size == 1 and numbers.dtype.kind in "biuf" else None
