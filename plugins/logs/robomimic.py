"""An HDF5 file of robomimic: ``data/demo_0`` with ``obs``, ``next_obs``, ``actions``, ``rewards`` and ``dones``."""

import json
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.errors import SchemaError, UsageError
from harness.files.bounded import names_in_hdf5, reading, require_regular
from harness.log import Log
from harness.log.log import ACTION, BEFORE, BEHAVIOUR, OBSERVATION, OPERATOR, RECORDED, REWARD, SEEN, SUCCESS
from harness.record.dataset.labels import UNKNOWN, SuccessRule
from harness.record.dataset.open_dataset import HDF5_SIGNATURE, MOST_EPISODES, DatasetFacts, open_hdf5
from harness.registry.names import did_you_mean
from harness.text import one_line_of, shortened

from ..datasets.dataset import (
    NOTHING_SEEN,
    SUCCESS_KEYS,
    Declared,
    as_measure,
    filled_up,
    operator_key,
    success_rule,
    take_census,
    texts,
    where_seen,
    whole,
)
from ..datasets.hdf5_parts import (
    MOST_BYTES,
    Budget,
    Stretch,
    array_of,
    find_array,
    group_of,
    one_number,
    read_stretches,
    text_of,
)

LABEL, PAY = f"{BEHAVIOUR}{SUCCESS}", f"{REWARD}{RECORDED}"
DATA, MASK = "data", "mask"
ENDED = "terminated"
ARRAY_COLUMNS = {PAY: "rewards", ENDED: "dones"}
ARRAYS = tuple(ARRAY_COLUMNS.values())
"""Arrays with a number for each step."""
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
        with reading(path, "robomimic data set"):
            require_regular(path, MOST_BYTES)
            with open_hdf5(path) as file:
                data = group_of(path, file, DATA, MOST_EPISODES)
                seen = _overview(path, data)
                total = whole(data.attrs.get("total"))
                census = take_census(path, Declared(None, total, lengths=seen.told), seen.steps, self.partial)
                masks = _masks(path, file)
                listed = _listed(path, masks, self.mask, seen.steps) if self.mask else census.episodes
                numbers = tuple(sorted(it for it in census.episodes & listed if seen.steps[it]))
                if not numbers:
                    raise SchemaError(f"{path} has no demonstration with a step")
                demo = group_of(path, data, seen.groups[numbers[0]])
                keys, pictures = _keys_seen(path, demo)
                arrays = tuple(key for key in ARRAYS if find_array(path, demo, key) is not None)
                env = data.attrs.get("env_args")
                sees_last = "next_obs" in demo
        rule = success_rule(self.success, (*arrays, *seen.attributes), path, SUCCESS_KEYS)
        facts = DatasetFacts(
            path=path,
            format="robomimic",
            name=f"robomimic:{f'mask={self.mask}:' if self.mask else ''}{path}",
            env="" if env is None else text_of(env),
            success="" if rule is None else rule.text,
            told_by=RECORDED if rule is not None and ARRAY_COLUMNS.get(PAY) == rule.key else "",
            operator=operator_key(self.cluster, seen.attributes, path),
            pictures_left_out=bool(pictures),
            notes=(*_notes(keys, pictures, masks, self.mask), *census.notes),
        )
        layout = _Layout(
            path, {number: seen.groups[number] for number in numbers}, keys, sees_last, arrays, rule, facts.operator
        )
        return (Log(facts, tuple(layout.columns()), partial(_tables, layout)),)

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


def _overview(path: Path, data: Any) -> _Overview:
    """Look at all demonstrations.

    Raises:
        SchemaError: One is called otherwise than ``demo_`` and a number, or two have one number.
    """
    seen = _Overview({}, {}, {}, {})
    for key in data:
        found = _DEMO.fullmatch(key)
        if found is None:
            name = one_line_of(shortened(key, 80))
            raise SchemaError(f"{path}: {DATA} holds '{name}': a demonstration is called demo_ and a number, as demo_0")
        if seen.groups.setdefault(int(found[1]), key) != key:
            raise SchemaError(f"{path}: {DATA} holds {seen.groups[int(found[1])]} and {key}, which have one number")
    for number, key in sorted(seen.groups.items()):
        demo = group_of(path, data, key)
        seen.steps[number] = len(array_of(path, demo, "actions"))
        if (told := whole(demo.attrs.get("num_samples"))) is not None:
            seen.told[number] = told
        seen.attributes.update(dict.fromkeys(key for key in demo.attrs if key not in ("num_samples", "model_file")))
    return seen


def _masks(path: Path, file: Any) -> dict[str, frozenset[int]]:
    """By filter key, the numbers of the demonstrations that it lists."""
    if MASK not in file:
        return {}
    masks = group_of(path, file, MASK)
    found: dict[str, frozenset[int]] = {}
    for key in masks:
        names = [text_of(name) for name in np.ravel(array_of(path, masks, key).value)]
        matched = [_DEMO.fullmatch(name) for name in names]
        if not all(matched):
            raise SchemaError(f"{path}: the filter key {key} lists what is called other than demo_0")
        found[key] = frozenset(int(it[1]) for it in matched if it)
    return found


def _listed(path: Path, masks: Mapping[str, frozenset[int]], key: str, there: Collection[int]) -> frozenset[int]:
    """The demonstrations that a filter key lists."""
    if key not in masks:
        told = ", ".join(masks) or "none"
        raise UsageError(f"{path} has no filter key '{key}'; it has {told}.{did_you_mean(key, masks)}")
    if gone := sorted(masks[key] - {*there}):
        raise SchemaError(f"{path}: the filter key {key} lists demo_{gone[0]}, which is not there")
    return masks[key]


def _keys_seen(path: Path, demo: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Keys of observations that are read, and of those that are not: pictures, texts, and what is too large."""
    if "obs" not in demo:
        return (), ()
    seen = group_of(path, demo, "obs")
    arrays = {key: array_of(path, seen, key) for key in seen}
    read = [
        key
        for key, it in arrays.items()
        if it.shape and it.holds_numbers and not (it.dtype == np.uint8 and len(it.shape) == 4)
    ]
    return tuple(read), tuple(key for key in arrays if key not in read)


def _notes(
    keys: tuple[str, ...], pictures: tuple[str, ...], masks: Mapping[str, frozenset[int]], chosen: str
) -> Iterator[str]:
    if pictures:
        yield f"Pictures and texts are left out: {shortened(', '.join(pictures), 200)}"
    if not keys:
        yield f"There are no numbers of obs: {NOTHING_SEEN}"
    if chosen:
        yield f"Read are the demonstrations of the filter key {chosen} alone"
    elif masks:
        told = ", ".join(f"{key} {len(numbers):,}" for key, numbers in masks.items())
        yield f"All demonstrations are read. Of a filter key alone: robomimic:mask=KEY:FILE ({shortened(told, 300)})"


class _Layout(NamedTuple):
    """What is read of each demonstration.

    Attributes:
        path: The file.
        groups: Names of the demonstrations' groups, by their numbers.
        keys: Of observations.
        sees_last: Whether the file tells what was seen after each step, also the last one.
        arrays: Those of `ARRAYS` that there are.
        rule: Where success stands; None where nothing says it.
        operator: The attribute that says who made a demonstration; empty if none does.
    """

    path: Path
    groups: Mapping[int, str]
    keys: tuple[str, ...]
    sees_last: bool
    arrays: tuple[str, ...]
    rule: SuccessRule | None
    operator: str

    def columns(self) -> Iterator[str]:
        """All columns of the log."""
        yield from ("episode", "step", ACTION)
        yield from (name for name, key in ARRAY_COLUMNS.items() if key in self.arrays)
        yield from (f"{begin}{OBSERVATION}/{key}" for key in self.keys for begin in (BEFORE, ""))
        yield from [SEEN] if self.keys and not self.sees_last else []
        yield from [LABEL] if self.rule is not None else []
        yield from [OPERATOR] if self.operator else []


def _tables(layout: _Layout, names: tuple[str, ...]) -> Iterator[Mapping[str, NDArray[Any]]]:
    path, budget = layout.path, Budget(layout.path)
    with reading(path, "robomimic data set"), open_hdf5(path) as file:
        data = group_of(path, file, DATA, MOST_EPISODES)
        for number, key in layout.groups.items():
            demo = group_of(path, data, key)
            parts = _parts(layout, demo, number, names)
            steps = len(parts[ACTION].array)
            budget.take(steps, parts)
            for begin, table in read_stretches(steps, parts):
                count = len(table[ACTION])
                yield {name: _column(layout, demo, number, name, begin, steps, count, table) for name in names}


def _parts(layout: _Layout, demo: Any, number: int, names: tuple[str, ...]) -> dict[str, Stretch]:
    """Where the numbers of columns stand in the file; actions are always among them.

    Raises:
        SchemaError: An array has other rows than the demonstration has actions.
    """
    path = layout.path
    arrays = {ACTION: array_of(path, demo, "actions")}
    keys = {name: key for name, key in ARRAY_COLUMNS.items() if name in names}
    if layout.rule is not None and LABEL in names and layout.rule.key in layout.arrays:
        keys[LABEL] = layout.rule.key
    arrays |= {name: array_of(path, demo, key) for name, key in keys.items()}
    for place, begin in (("obs", BEFORE), ("next_obs", "")):
        asked = [key for key in layout.keys if f"{begin}{OBSERVATION}/{key}" in names]
        if asked and (place == "obs" or layout.sees_last):
            group = group_of(path, demo, place)
            arrays |= {f"{begin}{OBSERVATION}/{key}": array_of(path, group, key) for key in asked}
    steps = len(arrays[ACTION])
    for name, array in arrays.items():
        if len(array) != steps or not array.holds_numbers:
            raise SchemaError(
                f"{path}: {layout.groups[number]} has {steps:,} actions, and {len(array):,} rows of {name}"
            )
        one = arrays.get(f"{BEFORE}{name}", array)
        if one.shape != array.shape:
            told = f"{list(one.shape)} in obs and {list(array.shape)} in next_obs"
            raise SchemaError(f"{path}: {layout.groups[number]}: {name} is {told}")
    parts = {name: Stretch(array) for name, array in arrays.items()}
    if not layout.sees_last:
        group = group_of(path, demo, "obs") if layout.keys else None
        asked = [key for key in layout.keys if f"{OBSERVATION}/{key}" in names]
        parts |= {f"{OBSERVATION}/{key}": Stretch(array_of(path, group, key), 1) for key in asked}
    return parts


def _column(
    layout: _Layout,
    demo: Any,
    number: int,
    name: str,
    begin: int,
    steps: int,
    count: int,
    table: Mapping[str, NDArray[Any]],
) -> NDArray[Any]:
    where = f"{layout.path}, {layout.groups[number]}"
    seen = np.arange(begin, begin + count) < steps - (not layout.sees_last)
    known: dict[str, NDArray[Any]] = {
        "episode": np.full(count, number, np.int64),
        "step": np.arange(begin + 1, begin + count + 1, dtype=np.int64),
        SEEN: seen,
    }
    if name in known:
        return known[name]
    if name == OPERATOR:
        return texts(text_of(demo.attrs.get(layout.operator, "")), count)
    if name == LABEL and layout.rule is not None:
        last = begin + count == steps
        return as_measure(_labels(layout.rule, demo, table.get(name), count, last, f"{where}: {layout.rule.key}"))
    if name in ARRAY_COLUMNS:
        numbers = one_number(table[name], f"{where}: {ARRAY_COLUMNS[name]}")
        # Some files have dones in every step that is a success, and the demonstration goes on.
        is_last = np.arange(begin, begin + count) == steps - 1
        return numbers if name == PAY else np.asarray(is_last & (numbers != 0.0))
    return where_seen(filled_up(table[name], count), seen) if name.startswith(OBSERVATION) else table[name]


def _labels(
    rule: SuccessRule, demo: Any, values: NDArray[Any] | None, count: int, is_last: bool, noun: str
) -> NDArray[np.int8]:
    """Labels of each step; what an attribute says of the whole demonstration stands in its last one."""
    if values is not None:
        return rule.of_steps(values, noun)
    told = np.full(count, UNKNOWN, np.int8)
    if is_last:
        told[-1] = rule.of_episode(demo.attrs.get(rule.key), noun)
    return told
