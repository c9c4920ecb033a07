"""An HDF5 file of robomimic: ``data/demo_0`` with ``obs``, ``next_obs``, ``actions``, ``rewards`` and ``dones``."""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness.errors import SchemaError, one_line
from harness.files import names_in_hdf5
from harness.log import DatasetFacts, Log, require_columns
from harness.record.dataset.open_dataset import HDF5_SIGNATURE, MOST_EPISODES

from ..datasets.dataset import (
    NOTHING_SEEN,
    take_census,
    whole,
)
from ..datasets.hdf5_parts import Run, Stretch, array_of, find_array, group_of, opened, tables_of
from ..datasets.steps import source_of, text_of

DATA, MASK = "data", "mask"
ARRAYS = {"reward/recorded": "rewards", "terminated": "dones"}
"""Arrays with a number for each step, by column."""
_DEMO = re.compile(r"demo_(\d{1,9})")


@dataclass(frozen=True)
class Robomimic:
    """Demonstrations of a robot, each in a group of its own.

    Attributes:
        success: What says whether a step, or an episode, was a success: ``dones``, ``rewards`` or an attribute of
            demonstrations, also ``KEY>0.5``; an attribute is found by its name if empty.
        cluster: The attribute of demonstrations that says who made them; found by its name if empty.
        partial: Whether less than the file declares may be there.
        mask: Only the demonstrations that this filter key lists; all if empty.
    """

    success: str = ""
    cluster: str = ""
    partial: bool = False
    mask: str = ""

    def recognises(self, path: Path, head: bytes) -> bool:
        """An HDF5 file with a demonstration."""
        return head.startswith(HDF5_SIGNATURE) and any(name.startswith("data/demo_") for name in names_in_hdf5(path))

    def read(self, path: Path) -> tuple[Log, ...]:
        """The data set; its steps are read later."""
        with opened(path, "robomimic data set") as file:
            data = group_of(file, DATA, MOST_EPISODES)
            seen = _overview(data)
            total = whole(data.attrs.get("total"))
            belonging, notes = take_census(path, seen.steps, partial=self.partial, steps=total, lengths=seen.told)
            masks = _masks(file)
            listed = masks.get(self.mask, frozenset(seen.groups.values()))
            require_columns(f"{path}, among its filter keys,", masks, self.mask)
            if gone := sorted(listed - {*seen.groups.values()}):
                raise SchemaError(f"{path}: the filter key {self.mask} lists {gone[0]}, which is not there")
            groups = {it: seen.groups[it] for it in sorted(belonging) if seen.steps[it] and seen.groups[it] in listed}
            if not groups:
                raise SchemaError(f"{path} has no demonstration with a step")
            demo = group_of(data, next(iter(groups.values())))
            keys, pictures = _keys_seen(demo)
            places = {name: key for name, key in ARRAYS.items() if find_array(demo, key) is not None}
            env = data.attrs.get("env_args")
            after = "next_obs" if "next_obs" in demo else "obs"
        told = (*places.values(), *seen.attributes)
        facts = DatasetFacts(
            path=path,
            format="robomimic",
            name=f"robomimic:{f'mask={self.mask}:' if self.mask else ''}{path}",
            env=text_of(env),
            pictures_left_out=bool(pictures),
            notes=(*_notes(keys, pictures, masks, self.mask), *notes),
        )
        sees_last = not keys or after == "next_obs"
        source = source_of(facts, self.success, self.cluster, told, reward="rewards", sees_last=sees_last)
        single = {name: key for name, key in source.keys.items() if key in places.values()}
        places |= {
            f"{begin}observation/{key}": f"{of}/{key}"
            for key in keys
            for begin, of in (("before/", "obs"), ("", after))
        }
        columns = ("episode", "step", "action", *places)
        places |= {"action": "actions", **single}
        return (source.log(columns, partial(tables_of, path, source, partial(_runs, groups, places))),)

    def write_example(self, folder: Path) -> Path:
        """Two demonstrations."""
        import h5py

        path = folder / "low_dim.hdf5"
        with h5py.File(path, "w") as file:
            data = file.create_group(DATA)
            data.attrs.update({"total": 7, "env_args": json.dumps({"env_name": "Lift", "env_type": 1})})
            for number, steps in enumerate((3, 4)):
                demo = data.create_group(f"demo_{number}")
                demo.attrs.update({"num_samples": steps, "success": number})
                way = np.arange(2.0 * steps + 2).reshape(steps + 1, 2)
                demo["obs/eef_pos"], demo["next_obs/eef_pos"] = way[:-1], way[1:]
                demo["actions"] = np.linspace(-1.0, 1.0, steps)[:, None]
                demo["rewards"], demo["dones"] = (np.arange(1.0, steps + 1) == steps * it for it in (number, 1))
        return path


class _Overview(NamedTuple):
    """What a first look at all demonstrations tells: by number names, steps, and steps as declared; attributes."""

    groups: dict[int, str]
    steps: dict[int, int]
    told: dict[int, int]
    attributes: dict[str, None]


def _overview(data: Any) -> _Overview:
    """Look at all demonstrations.

    Raises:
        SchemaError: One is called otherwise than ``demo_`` and a number, or two have one number.
    """
    seen = _Overview({}, {}, {}, {})
    for key in data:
        found = _DEMO.fullmatch(key)
        if found is None:
            name = one_line(key, 80)
            raise SchemaError(
                f"{data.file.filename}: {DATA} holds '{name}': a demonstration is called demo_ and a number, as demo_0"
            )
        if seen.groups.setdefault(int(found[1]), key) != key:
            twice = f"{seen.groups[int(found[1])]} and {key}, which have one number"
            raise SchemaError(f"{data.file.filename}: {DATA} holds {twice}")
        demo, number = group_of(data, key), int(found[1])
        seen.steps[number] = len(array_of(demo, "actions"))
        if (told := whole(demo.attrs.get("num_samples"))) is not None:
            seen.told[number] = told
        seen.attributes.update(dict.fromkeys(key for key in demo.attrs if key not in ("num_samples", "model_file")))
    return seen


def _masks(file: Any) -> dict[str, frozenset[str]]:
    """By filter key, the names of the demonstrations that it lists."""
    masks = group_of(file, MASK) if MASK in file else ()
    return {key: frozenset(map(text_of, np.ravel(array_of(masks, key).value))) for key in masks}


def _keys_seen(demo: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Keys of observations that are read, and of those that are not: pictures, texts, and what is too large."""
    seen = {key: array_of(demo, f"obs/{key}") for key in group_of(demo, "obs")} if "obs" in demo else {}
    numbers = [key for key, it in seen.items() if it.shape and it.holds_numbers]
    read = tuple(key for key in numbers if seen[key].dtype != np.uint8 or len(seen[key].shape) != 4)
    return read, tuple(key for key in seen if key not in read)


def _notes(
    keys: tuple[str, ...], pictures: tuple[str, ...], masks: Mapping[str, frozenset[str]], chosen: str
) -> Iterator[str]:
    if pictures:
        yield f"Pictures and texts are left out: {one_line(', '.join(pictures), 200)}"
    if not keys:
        yield f"There are no numbers of obs: {NOTHING_SEEN}"
    if chosen:
        yield f"Read are the demonstrations of the filter key {chosen} alone"
    elif masks:
        told = ", ".join(f"{key} {len(names):,}" for key, names in masks.items())
        yield f"All demonstrations are read. Of a filter key alone: robomimic:mask=KEY:FILE ({one_line(told, 300)})"


def _runs(groups: Mapping[int, str], places: Mapping[str, str], file: Any, names: tuple[str, ...]) -> Iterator[Run]:
    """The steps of each demonstration.

    Args:
        groups: Names of the demonstrations' groups, by their numbers.
        places: By column where it stands in a demonstration.
        file: The file, open.
        names: Of the columns that are needed.

    Raises:
        SchemaError: An array has other rows than the demonstration has actions.
    """
    data = group_of(file, DATA, MOST_EPISODES)
    for number, key in groups.items():
        demo, where = group_of(data, key), f"{file.filename}: {key}"
        arrays = {name: array_of(demo, place) for name, place in places.items() if name in ("action", *names)}
        steps = len(arrays["action"])
        for name, array in arrays.items():
            if len(array) != steps or not array.holds_numbers:
                raise SchemaError(f"{where} has {steps:,} actions, and {len(array):,} rows of {name}")
            one = arrays.get(f"before/{name}", array)
            if one.shape != array.shape:
                told = f"{list(one.shape)} in obs and {list(array.shape)} in next_obs"
                raise SchemaError(f"{where}: {name} is {told}")
        follows = [name for name in places if places.get(f"before/{name}") == places[name]]
        parts = {name: Stretch(array, int(name in follows)) for name, array in arrays.items()}
        yield Run(np.full(steps, number), parts, where, partial(_attribute, demo))


def _attribute(demo: Any, number: int, key: str) -> Any:
    return demo.attrs.get(key)
