"""An HDF5 file of D4RL: ``observations``, ``actions``, ``rewards``, ``terminals``, ``timeouts``, a row for each step.

Episodes lie one behind the other. One ends where ``terminals`` or ``timeouts`` is true; the row behind it begins
another, so that it does not tell what was seen after the last step. Only ``next_observations`` does, in files that have
it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness import Ints, Mask
from harness.errors import SchemaError, UsageError
from harness.files import names_in_hdf5
from harness.log import DatasetFacts, Log
from harness.record.dataset.open_dataset import HDF5_SIGNATURE

from ..datasets.dataset import (
    MOST_NUMBERS,
    require_readable,
)
from ..datasets.hdf5_parts import (
    Array,
    Run,
    Stretch,
    array_of,
    find_array,
    infos_of,
    opened,
    read_stretches,
    tables_of,
)
from ..datasets.steps import Source, one_number, source_of

NEXT = "next_observations"
MOST_ROWS = 20_000_000
"""The most steps: the flags of all of them are held at once, 0.7 GB."""
OF_D3RLPY = "episode_terminals"
PLACES = {"reward/recorded": "rewards", "before/observation": "observations", "action": "actions"}
"""By column the array that has it."""


@dataclass(frozen=True)
class D4RL:
    """Steps of many episodes, one behind the other.

    Attributes:
        success: The key of infos that says whether a step was a success, also ``KEY>0.5``; found by its name if empty.
        cluster: The key of infos that says who made an episode; found by its name if empty.
        horizon: After so many steps an episode was cut, in a file that has no ``timeouts``; 0 if nobody says it.
    """

    success: str = ""
    cluster: str = ""
    horizon: int = 0

    def recognises(self, path: Path, head: bytes) -> bool:
        """An HDF5 file with the flag at its top that no other format has there."""
        return head.startswith(HDF5_SIGNATURE) and {"observations", "actions", "terminals"} <= {*names_in_hdf5(path)}

    def read(self, path: Path) -> tuple[Log, ...]:
        """The data set; its steps are read later."""
        if self.horizon < 0:
            raise UsageError(f"horizon={self.horizon}: after at least 1 step an episode is cut, or 0 where nobody says")
        with opened(path, "D4RL data set") as file:
            arrays, infos = _arrays(file), _infos(file)
            total = len(arrays["rewards"])
            if total > MOST_ROWS:
                raise SchemaError(f"{path} has {total:,} steps, {MOST_ROWS:,} are allowed")
            require_readable(path, total, sum(it.width for it in (*arrays.values(), *infos.values())))
            layout, notes = _episodes_of(path, arrays, self.horizon)
        facts = DatasetFacts(path=path, format="D4RL", name=f"d4rl:{path}", notes=notes)
        source = source_of(facts, self.success, self.cluster, infos, sees_last=NEXT in arrays)
        columns = ("episode", "step", *layout.flags, *PLACES, "observation", *(f"info/{key}" for key in infos))
        return (source.log(columns, partial(tables_of, path, source, partial(_runs, source, layout))),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes: one ends, one is cut."""
        import h5py

        path = folder / "walk-v2.hdf5"
        with h5py.File(path, "w") as file:
            file["observations"] = np.arange(14.0, dtype=np.float32).reshape(7, 2)
            file["actions"] = np.linspace(-1.0, 1.0, 7, dtype=np.float32)[:, None]
            file["rewards"] = -np.arange(1.0, 8.0, dtype=np.float32)
            file["terminals"] = np.arange(7) == 2
            file["timeouts"] = np.arange(7) == 6
            file["infos/success"] = np.arange(7) == 2
        return path


class _Layout(NamedTuple):
    """Which rows are read; those of an episode that does not end are not.

    Attributes:
        episode: Number of each row's episode, (rows,).
        flags: By column of ends, whether each row's episode ended there so, (rows,).
    """

    episode: Ints
    flags: Mapping[str, Mask]


def _arrays(file: Any) -> dict[str, Array]:
    """What has a row for each step.

    Raises:
        SchemaError: Something is missing, or they have different numbers of rows.
    """
    if find_array(file, OF_D3RLPY) is not None:
        raise SchemaError(
            f"{file.filename} was written by d3rlpy: it has {OF_D3RLPY}, and whether a row's reward is that of its "
            "action or of the one before depends on the version. Write the episodes as a Minari data set"
        )
    arrays = {key: array_of(file, key) for key in ("observations", "actions", "rewards", "terminals")}
    arrays |= {key: found for key in ("timeouts", NEXT) if (found := find_array(file, key)) is not None}
    for key, array in arrays.items():
        if not array.shape or not array.holds_numbers:
            kind = f"{list(array.shape)} of {array.dtype}"
            raise SchemaError(f"{file.filename}: {key} holds no rows of at most {MOST_NUMBERS:,} numbers, but {kind}")
    rows = {key: len(array) for key, array in arrays.items()}
    if len({*rows.values()}) > 1:
        told = ", ".join(f"{key} {count:,}" for key, count in rows.items())
        raise SchemaError(f"{file.filename}: a row of each array is a step. It has: {told}")
    if NEXT in arrays and arrays[NEXT].shape != arrays["observations"].shape:
        told = f"{list(arrays[NEXT].shape)}, and observations {list(arrays['observations'].shape)}"
        raise SchemaError(f"{file.filename}: {NEXT} are {told}")
    return arrays


def _flag(path: Path, arrays: Mapping[str, Array], key: str) -> Mask:
    """In which rows a flag is true.

    Raises:
        SchemaError: It is no flag.
    """
    values = one_number(arrays[key][:], f"{path}: {key}")
    odd = np.flatnonzero((values != 0.0) & (values != 1.0))
    if len(odd):
        raise SchemaError(f"{path}: {key} holds {values[odd[0]]:g} in row {odd[0]}, and 0 and 1 are allowed")
    is_true: Mask = values == 1.0
    return is_true


def _infos(file: Any) -> dict[str, Array]:
    """What the environment told after each step, by key; other arrays say nothing of steps."""
    steps = len(array_of(file, "rewards"))
    return {key: array for key, array in infos_of(file).items() if len(array) == steps}


def _episodes_of(path: Path, arrays: Mapping[str, Array], horizon: int) -> tuple[_Layout, tuple[str, ...]]:
    """Where episodes end, and what is told of it.

    Raises:
        UsageError: There is a horizon, and ``timeouts`` too.
        SchemaError: Nothing says where those end that were cut, or what it says is wrong.
    """
    if horizon and "timeouts" in arrays:
        raise UsageError(f"{path} has timeouts, which say where episodes were cut: leave out horizon={horizon}")
    terminated = _flag(path, arrays, "terminals")
    goes_on = _go_on(arrays) if NEXT in arrays else np.ones(len(terminated), bool)
    ends = terminated.copy()
    if "timeouts" in arrays:
        ends |= _flag(path, arrays, "timeouts")
    elif horizon:
        ends |= _cut_after(horizon, terminated)
    elif NEXT in arrays:
        ends |= ~goes_on
    else:
        raise SchemaError(
            f"{path} has no timeouts, so that nothing says where an episode ends that was cut: write them into the "
            "file, or say after how many steps, as d4rl:horizon=1000:FILE"
        )
    if len(odd := np.flatnonzero(~(goes_on | ends)[:-1])):
        raise SchemaError(
            f"{path}: row {odd[0]} ends no episode by terminals and timeouts, and its {NEXT} is not the observation of "
            f"the row behind it, as in {len(odd):,} rows: the flags stand in the wrong rows"
        )
    last = np.flatnonzero(ends)
    if not len(last):
        raise SchemaError(f"{path}: no row of terminals or timeouts is true, so that no episode ends")
    steps = int(last[-1]) + 1
    lengths = np.diff(last, prepend=-1)
    episode = np.repeat(np.arange(len(last)), lengths)
    notes = []
    if rest := len(ends) - steps:
        notes.append(f"Left out, since no row ends the episode: the last {rest:,} steps")
    if single := int((lengths == 1).sum()):
        notes.append(f"Episodes of a single step, as where terminals stay true while a robot goes on: {single:,}")
    flags = {"terminated": terminated[:steps], "truncated": (ends & ~terminated)[:steps]}
    return _Layout(episode, flags), tuple(notes)


def _cut_after(horizon: int, terminated: Mask) -> Mask:
    """The last step of each episode of so many steps."""
    rows = np.arange(len(terminated))
    begins = np.maximum.accumulate(np.where(np.concatenate([[True], terminated[:-1]]), rows, 0))
    cut: Mask = (rows - begins) % horizon == horizon - 1
    return cut


def _go_on(arrays: Mapping[str, Array]) -> Mask:
    """Whether what was seen after each row is what the row behind it begins with; never of the last row."""
    found = np.zeros(len(arrays["rewards"]), bool)
    parts = {"after": Stretch(arrays[NEXT]), "behind": Stretch(arrays["observations"], 1)}
    for rows, table in read_stretches(len(found) - 1, parts):
        same = (table["after"] == table["behind"]) | (np.isnan(table["after"]) & np.isnan(table["behind"]))
        found[rows] = same.reshape(len(same), -1).all(axis=1)
    return found


def _runs(source: Source, layout: _Layout, file: Any, names: tuple[str, ...]) -> Iterator[Run]:
    """The steps of all episodes."""
    arrays, infos = _arrays(file), _infos(file)
    found = {name: arrays[key] for name, key in PLACES.items()}
    found["observation"] = arrays.get(NEXT, arrays["observations"])
    found |= {f"info/{key}": array for key, array in infos.items()}
    found |= {name: infos[key] for name, key in source.keys.items() if key}
    follows = "" if NEXT in arrays else "observation"
    parts = {name: Stretch(array, int(name == follows)) for name, array in found.items() if name in names}
    yield Run(layout.episode, parts, file.filename, known=layout.flags)
