"""A Minari data set: ``data/metadata.json`` and ``data/main_data.hdf5``, read by h5py alone.

The library `minari` is not needed. It makes spaces and, where the metadata has none, the env itself, to read a data
set; here all comes from the shapes in the file.
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from harness.errors import SchemaError, one_line
from harness.log import DatasetFacts, Log
from harness.record.dataset.open_dataset import MOST_EPISODES

from ..datasets.dataset import (
    MOST_NUMBERS,
    take_census,
    whole,
)
from ..datasets.hdf5_parts import (
    Array,
    Run,
    Stretch,
    Walk,
    address,
    array_of,
    find_array,
    group_of,
    infos_of,
    member_of,
    opened,
    tables_of,
)
from ..datasets.minari_facts import MAIN, METADATA, dataset_folder, pictures_of, read_metadata, require_known
from ..datasets.steps import LABEL, source_of

TASK_KEYS = (
    *("task", "task_id", "task_index", "task_name", "env_id", "env_name", "env", "environment", "env_spec"),
    *("options/task", "options/task_id", "options/task_index", "options/task_name", "options/env_id"),
)
"""What may say which task an episode does, or in which env: an attribute of it, or a key of its infos."""
FLAGS = {"terminated": "terminations", "truncated": "truncations"}
STEP_DATA = ("observations", "actions", "rewards", *FLAGS.values(), "infos")
PLACES = {"observations": "observation", "actions": "action"}
_EPISODE = re.compile(r"episode_(0|[1-9]\d{0,8})")


@dataclass(frozen=True)
class Minari:
    """Episodes with one observation more than actions, in a folder or under the name by which Minari finds it.

    Attributes:
        success: Where success stands, in infos or in an attribute of episodes, also ``KEY>0.5``; found by its name if
            empty.
        cluster: The attribute of episodes, or the key of infos, that says who made them; found by its name if empty.
        partial: Whether less than the metadata declares may be there.
    """

    success: str = ""
    cluster: str = ""
    partial: bool = False
    takes_all: ClassVar[bool] = True
    takes_names: ClassVar[bool] = True

    def recognises(self, path: Path, head: bytes) -> bool:
        """A folder with the one file of all episodes."""
        return (path / MAIN).is_file()

    def read(self, path: Path) -> tuple[Log, ...]:
        """The data set; its steps are read later."""
        folder = dataset_folder(str(path))
        place = folder / MAIN
        with opened(place, "Minari data set") as file:
            metadata = read_metadata(folder, file)
            require_known(place, metadata)
            seen = _overview(file)
            episodes, steps = (whole(metadata.get(key)) for key in ("total_episodes", "total_steps"))
            belonging, notes = take_census(
                place, seen.steps, partial=self.partial, episodes=episodes, steps=steps, lengths=seen.told
            )
            numbers = tuple(sorted(belonging - seen.again))
            pictures = pictures_of(metadata)
            told, spec = (*seen.infos, *seen.attributes), metadata.get("env_spec")
            facts = DatasetFacts(
                path=folder,
                format=f"Minari {metadata.get('minari_version', '')}".strip(),
                name=f"minari:{path}",
                env=spec if isinstance(spec, str) else "",
                task=next((key for key in TASK_KEYS if key in told), ""),
                pictures_left_out=bool(pictures),
                notes=(*_notes(pictures, seen, metadata), *notes),
            )
            source = source_of(facts, self.success, self.cluster, told, sees_last=True)
            keys = {"reward/recorded": "rewards", **{f"info/{key}": f"infos/{key}" for key in seen.infos}}
            layout = _Layout(numbers, pictures, keys, source.rule.key)
            columns = ["episode", "step", *keys]
            if numbers:
                group = group_of(file, f"episode_{numbers[0]}")
                columns += [name for name, key in FLAGS.items() if key in group]
                columns += layout.vectors(group)
        return (source.log(columns, partial(tables_of, place, source, layout.runs)),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes."""
        import h5py

        (folder / MAIN).parent.mkdir(parents=True)
        told = {"total_episodes": 2, "total_steps": 7, "data_format": "hdf5", "minari_version": "0.5.3"}
        (folder / METADATA).write_text(json.dumps(told))
        with h5py.File(folder / MAIN, "w") as file:
            for number, steps in enumerate((3, 4)):
                group = file.create_group(f"episode_{number}")
                group.attrs.update({"id": number, "total_steps": steps})
                group["observations"] = np.arange(2.0 * steps + 2).reshape(steps + 1, 2)
                group["actions"] = np.linspace(-1.0, 1.0, steps)[:, None]
                group["rewards"] = -np.arange(1.0, steps + 1)
                group["terminations"] = np.arange(1, steps + 1) == steps * number
                group["truncations"] = np.arange(1, steps + 1) == steps * (1 - number)
                group["infos/success"] = np.arange(steps + 1) == steps * number
        return folder


class _Overview(NamedTuple):
    """What a first look at all episodes tells.

    Attributes:
        steps: Of each episode, by number.
        told: How many it says that it has, likewise.
        infos: Keys of infos, of all episodes.
        attributes: Attributes and further arrays of episodes, likewise.
        again: Numbers that are other names for an episode with a lower one, which is read once.
        strangers: Names in the file that are no episode's.
    """

    steps: dict[int, int]
    told: dict[int, int]
    infos: dict[str, None]
    attributes: dict[str, None]
    again: set[int]
    strangers: tuple[str, ...]


def _notes(pictures: frozenset[str], seen: _Overview, metadata: Mapping[str, Any]) -> Iterator[str]:
    if pictures:
        yield f"Pictures and texts are left out: {', '.join(sorted(pictures))}"
    if seen.again:
        yield f"Names for an episode that has another name already, left out: {len(seen.again):,}"
    if seen.strangers:
        yield f"Left out, since they are no episodes: {one_line(', '.join(seen.strangers), 200)}"
    if metadata.get("combined_datasets") and not any(key in seen.attributes for key in TASK_KEYS):
        yield "It was put together from several data sets, and nothing says which episode is of which"


def _overview(file: Any) -> _Overview:
    if len(file) > MOST_EPISODES:
        raise SchemaError(f"{file.filename} has {len(file):,} episodes, {MOST_EPISODES:,} are allowed")
    names = list(file)
    numbers = sorted(int(found[1]) for key in names if (found := _EPISODE.fullmatch(key)))
    if not numbers:
        raise SchemaError(f"{file.filename} has no episode")
    strangers = tuple(key for key in names if not _EPISODE.fullmatch(key))[:5]
    seen = _Overview({}, {}, {}, {}, set(), strangers)
    numbers_at: dict[int, int] = {}
    for number in numbers:
        group = group_of(file, f"episode_{number}")
        first = numbers_at.setdefault(address(group), number)
        if first != number:
            seen.again.add(number)
            seen.steps[number] = seen.steps[first]
            continue
        seen.steps[number] = len(array_of(group, "rewards"))
        if (told := whole(group.attrs.get("total_steps"))) is not None:
            seen.told[number] = told
        infos = group_of(group, "infos") if "infos" in group else ()
        if any(key not in seen.infos for key in infos):  # else nothing is opened
            seen.infos.update(dict.fromkeys(infos_of(group)))
        seen.attributes.update(dict.fromkeys(key for key in (*group.attrs, *group) if key not in STEP_DATA))
    return seen


class _Layout(NamedTuple):
    """What is read of each episode.

    Attributes:
        numbers: Of the episodes.
        pictures: Parts of the observation that are left out.
        keys: By column what an episode calls it, ``infos/KEY``.
        success: The key that says it; empty where nothing does.
    """

    numbers: tuple[int, ...]
    pictures: frozenset[str]
    keys: Mapping[str, str]
    success: str

    def vectors(self, group: Any) -> dict[str, Stretch]:
        """Where stands what was seen and done in an episode, by column."""
        walk, found = Walk(), dict[str, Stretch]()
        for place, column in PLACES.items():
            if place in self.pictures:
                continue
            for part, array in walk.arrays(member_of(group, place), place, self.pictures):
                if not array.shape or not array.holds_numbers:
                    raise SchemaError(
                        f"{group.file.filename}: {part} holds no rows of at most {MOST_NUMBERS:,} numbers"
                    )
                name = f"{column}{part.removeprefix(place)}"
                if column == "observation":
                    found[f"before/{name}"] = Stretch(array)
                found[name] = Stretch(array, int(column == "observation"))
        return found

    def runs(self, file: Any, names: tuple[str, ...]) -> Iterator[Run]:
        """The steps of each episode.

        Raises:
            SchemaError: Its arrays have other rows than an episode of Minari has.
        """
        for number in self.numbers:
            group, where = group_of(file, f"episode_{number}"), f"{file.filename}, episode {number}"
            steps, parts, find = len(array_of(group, "rewards")), self.vectors(group), cache(partial(find_array, group))
            for name, it in parts.items():
                if len(it.array) != steps + (not name.startswith("action")):
                    told = f"{steps:,} rewards, and {len(it.array):,} rows of {name}"
                    raise SchemaError(f"{where} has {told}; a Minari episode has one observation more than actions")
            parts = {name: it for name, it in parts.items() if name in names}
            for name, key in {**FLAGS, **self.keys, LABEL: f"infos/{self.success}"}.items():
                if name in names and (part := _rows(find(key), steps)):
                    parts[name] = part
            if LABEL in {*names} - {*parts} and (part := _rows(find(self.success), steps)):
                parts[LABEL] = part
            told_of = partial(_told, group, steps)
            yield Run(np.full(steps, number), parts, where, told_of)


def _rows(found: Array | None, steps: int) -> Stretch | None:
    """Rows after each step; infos may begin with what the reset told. None of what is no such array."""
    if found is None or len(found) - steps not in (0, 1):
        return None
    return Stretch(found, len(found) - steps)


def _told(group: Any, steps: int, number: int, key: str) -> Any:
    """What an attribute of an episode says, one number in infos or beside the steps, or the info of the first step."""
    if key in group.attrs:
        return group.attrs[key]
    found = find_array(group, f"infos/{key}")
    if found is None:
        found = find_array(group, key)
    part = None if found is None else _rows(found, steps)
    if part is not None:
        return part.array[part.first : part.first + 1]
    return None if found is None else found.value
