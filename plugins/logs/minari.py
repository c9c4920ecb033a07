"""A Minari data set: ``data/metadata.json`` and ``data/main_data.hdf5``, read by h5py alone.

The library `minari` is not needed. It makes spaces and, where the metadata has none, the env itself, to read a data
set; here all comes from the shapes in the file.
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading, require_regular
from harness.log import Log
from harness.log.log import ACTION, BEFORE, BEHAVIOUR, INFO, OBSERVATION, OPERATOR, RECORDED, REWARD, SUCCESS, TASK
from harness.record.dataset.labels import UNKNOWN, SuccessRule
from harness.record.dataset.open_dataset import MOST_EPISODES, DatasetFacts, open_hdf5
from harness.text import shortened

from ..datasets.dataset import (
    OWN_REWARDS,
    SUCCESS_KEYS,
    Declared,
    as_measure,
    operator_key,
    own_rewards,
    success_rule,
    take_census,
    texts,
    whole,
)
from ..datasets.hdf5_parts import (
    MOST_BYTES,
    Array,
    Budget,
    Stretch,
    Walk,
    address,
    array_of,
    find_array,
    group_of,
    member_of,
    one_number,
    read_stretches,
    text_of,
)
from ..datasets.minari_facts import MAIN, METADATA, dataset_folder, pictures_of, read_metadata, require_known

TASK_KEYS = (
    *("task", "task_id", "task_index", "task_name", "env_id", "env_name", "env", "environment", "env_spec"),
    *("options/task", "options/task_id", "options/task_index", "options/task_name", "options/env_id"),
)
"""What may say which task an episode does, or in which env: an attribute of it, or a key of its infos."""
ENDS = {"terminated": "terminations", "truncated": "truncations"}
STEP_DATA = ("observations", "actions", "rewards", *ENDS.values(), "infos")
PLACES = {"observations": OBSERVATION, "actions": ACTION}
LABEL = f"{BEHAVIOUR}{SUCCESS}"
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
        with reading(place, "Minari data set"):
            require_regular(place, MOST_BYTES)
            with open_hdf5(place) as file:
                metadata = read_metadata(folder, file)
                require_known(place, metadata)
                seen = _overview(place, file)
                own = own_rewards(place, metadata.get(OWN_REWARDS), seen.infos)
                episodes, steps = (whole(metadata.get(key)) for key in ("total_episodes", "total_steps"))
                census = take_census(
                    place, Declared(episodes, steps, lengths=seen.told), seen.steps, self.partial
                )  # fmt: skip
                told = (*seen.infos, *seen.attributes)
                rule = success_rule(self.success, told, place, SUCCESS_KEYS)
                numbers = tuple(sorted(census.episodes - seen.again))
                layout = _Layout(place, numbers, own, pictures_of(metadata), rule, tuple(seen.infos))
                columns = tuple(layout.columns_of(group_of(place, file, f"episode_{numbers[0]}"))) if numbers else ()
        spec = metadata.get("env_spec")
        facts = DatasetFacts(
            path=folder,
            format=f"Minari {metadata.get('minari_version', '')}".strip(),
            name=f"minari:{path}",
            env=spec if isinstance(spec, str) else "",
            success="" if rule is None else rule.text,
            told_by="" if rule is None else own.get(rule.key, ""),
            operator=operator_key(self.cluster, told, place),
            task=next((key for key in TASK_KEYS if key in told), ""),
            pictures_left_out=bool(layout.pictures),
            notes=tuple(_notes(layout.pictures, seen, metadata, census.notes)),
        )
        texts_told = {OPERATOR: facts.operator, TASK: facts.task}
        columns = (*columns, *(name for name, key in texts_told.items() if key))
        return (Log(facts, columns, partial(_tables, layout, texts_told)),)

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


def _notes(
    pictures: frozenset[str], seen: _Overview, metadata: Mapping[str, Any], census: tuple[str, ...]
) -> Iterator[str]:
    if pictures:
        yield f"Pictures and texts are left out: {', '.join(sorted(pictures))}"
    if seen.again:
        yield f"Names for an episode that has another name already, left out: {len(seen.again):,}"
    if seen.strangers:
        yield f"Left out, since they are no episodes: {shortened(', '.join(seen.strangers), 200)}"
    if metadata.get("combined_datasets") and not any(key in seen.attributes for key in TASK_KEYS):
        yield "It was put together from several data sets, and nothing says which episode is of which"
    yield from census


def _overview(path: Path, file: Any) -> _Overview:
    if len(file) > MOST_EPISODES:
        raise SchemaError(f"{path} has {len(file):,} episodes, {MOST_EPISODES:,} are allowed")
    names = list(file)
    numbers = sorted(int(found[1]) for key in names if (found := _EPISODE.fullmatch(key)))
    if not numbers:
        raise SchemaError(f"{path} has no episode")
    strangers = tuple(key for key in names if not _EPISODE.fullmatch(key))[:5]
    seen = _Overview({}, {}, {}, {}, set(), strangers)
    numbers_at: dict[int, int] = {}
    for number in numbers:
        group = group_of(path, file, f"episode_{number}")
        first = numbers_at.setdefault(address(group), number)
        if first != number:
            seen.again.add(number)
            seen.steps[number] = seen.steps[first]
            continue
        seen.steps[number] = len(array_of(path, group, "rewards"))
        if (told := whole(group.attrs.get("total_steps"))) is not None:
            seen.told[number] = told
        seen.infos.update(dict.fromkeys(_info_keys(path, group, seen.infos)))
        seen.attributes.update(dict.fromkeys(key for key in (*group.attrs, *group) if key not in STEP_DATA))
    return seen


def _info_keys(path: Path, episode: Any, known: Mapping[str, None]) -> list[str]:
    """Keys of the infos that hold numbers, at any depth, ``a/b``. Nothing is opened where all are known already."""
    if "infos" not in episode:
        return []
    infos = group_of(path, episode, "infos")
    return [] if all(key in known for key in infos) else [key for key, _ in Walk(path).numbers(infos)]


class _Layout(NamedTuple):
    """What is read of each episode.

    Attributes:
        path: The file.
        numbers: Of the episodes.
        own: By key of infos, names of rewards that `harness export` wrote.
        pictures: Parts of the observation that are left out.
        rule: Where success stands; None where nothing says it.
        infos: Keys of infos, of all episodes.
    """

    path: Path
    numbers: tuple[int, ...]
    own: Mapping[str, str]
    pictures: frozenset[str]
    rule: SuccessRule | None
    infos: tuple[str, ...]

    def columns_of(self, group: Any) -> Iterator[str]:
        """The columns that such an episode has, and keys of infos that others have."""
        yield from ("episode", "step")
        yield from (name for name, key in ENDS.items() if key in group)
        yield f"{REWARD}{RECORDED}"
        yield from (f"{REWARD}{name}" for name in self.own.values())
        yield from [LABEL] if self.rule is not None else []
        for name in self.vectors(group):
            yield from (f"{BEFORE}{name}", name) if name.startswith(OBSERVATION) else (name,)
        yield from (f"{INFO}{key}" for key in self.infos if key not in self.own)

    def vectors(self, group: Any) -> dict[str, Array]:
        """Arrays of what was seen and done, by column."""
        walk = Walk(self.path)
        found: dict[str, Array] = {}
        for place, column in PLACES.items():
            if place not in self.pictures:
                arrays = walk.columns(member_of(self.path, group, place), self.pictures, place)
                found |= {f"{column}{name.removeprefix(place)}": array for name, array in arrays.items()}
        return found


def _tables(
    layout: _Layout, texts_told: Mapping[str, str], names: tuple[str, ...]
) -> Iterator[Mapping[str, NDArray[Any]]]:
    path, budget = layout.path, Budget(layout.path)
    with reading(path, "Minari data set"), open_hdf5(path) as file:
        for number in layout.numbers:
            episode = _Episode(layout, group_of(path, file, f"episode_{number}"), number)
            parts = episode.parts(names)
            budget.take(episode.steps, parts)
            told = {name: episode.text(texts_told[name]) for name in texts_told if name in names}
            for first, table in read_stretches(episode.steps, parts):
                count = min(len(values) for values in table.values())
                yield {name: episode.column(name, first, count, table, told) for name in names}


class _Episode:
    """One episode in the file."""

    def __init__(self, layout: _Layout, group: Any, number: int) -> None:
        self._layout, self._group, self._number = layout, group, number
        self._path = layout.path
        self._rewards = array_of(self._path, group, "rewards")
        self._infos = group_of(self._path, group, "infos") if "infos" in group else None
        self.steps = len(self._rewards)

    def parts(self, names: tuple[str, ...]) -> dict[str, Stretch]:
        """Where the numbers of columns stand in the file; the rewards are always among them.

        Raises:
            SchemaError: Its arrays have other rows than an episode of Minari has.
        """
        parts = {f"{REWARD}{RECORDED}": Stretch(self._rewards)}
        for name, array in self._vectors().items():
            if name in names:
                parts[name] = Stretch(array, int(name.startswith(OBSERVATION)))
            if f"{BEFORE}{name}" in names:
                parts[f"{BEFORE}{name}"] = Stretch(array)
        parts |= {
            name: Stretch(array_of(self._path, self._group, ENDS[name])) for name in ENDS if name in names
        }  # fmt: skip
        keys = {f"{REWARD}{name}": key for key, name in self._layout.own.items()}
        keys |= {f"{INFO}{key}": key for key in self._layout.infos}
        keys |= {LABEL: self._layout.rule.key} if self._layout.rule is not None else {}
        for name in names:
            if name in keys and (rows := self._info(keys[name])) is not None:
                parts[name] = rows
        return parts

    def _vectors(self) -> dict[str, Array]:
        found, steps = self._layout.vectors(self._group), self.steps
        rows = {
            place: {len(array) for name, array in found.items() if name.startswith(place)} for place in PLACES.values()
        }
        if rows[ACTION] != {steps} or not rows[OBSERVATION] <= {steps + 1}:
            told = " and ".join(f"{'/'.join(map(str, sorted(rows[it]))) or 'no'} {it}s" for it in (ACTION, OBSERVATION))
            raise SchemaError(
                f"{self._path}: episode {self._number} has {steps:,} rewards, {told}; a Minari episode has one "
                "observation more than actions"
            )
        return found

    def _info(self, key: str) -> Stretch | None:
        """What was told after each step; infos may begin with what the reset told."""
        found = self._told(key)
        if found is None or not found.shape or len(found) - self.steps not in (0, 1) or self._is_single(found):
            return None
        return Stretch(found, len(found) - self.steps)

    def _told(self, key: str) -> Array | None:
        return None if self._infos is None else find_array(self._path, self._infos, key)

    def _is_single(self, found: Array) -> bool:
        return found.size == 1 != self.steps

    def column(
        self, name: str, first: int, count: int, table: Mapping[str, NDArray[Any]], told: Mapping[str, str]
    ) -> NDArray[Any]:
        """A column of some steps."""
        if name == "episode":
            return np.full(count, self._number, np.int64)
        if name == "step":
            return np.arange(first + 1, first + 1 + count, dtype=np.int64)
        if name in told:
            return texts(told[name], count)
        if name == LABEL:
            return self._success(table.get(LABEL), first, count)
        if name not in table and name.startswith((REWARD, INFO)):
            return np.full(count, np.nan)
        if name not in table:
            raise SchemaError(f"{self._path}: episode {self._number} has no {name}, which others have")
        return one_number(table[name], f"{self._noun(name)}") if name.startswith(REWARD) else table[name]

    def _success(self, values: NDArray[Any] | None, first: int, count: int) -> Float:
        """Labels of each step; what is said of the whole episode stands in its last one."""
        rule = self._layout.rule
        assert rule is not None  # or there is no such column
        if values is not None:
            return as_measure(rule.of_steps(values, self._noun(rule.key)))
        told = np.full(count, UNKNOWN, np.int8)
        if first + count == self.steps:
            told[-1] = self._label(rule)
        return as_measure(told)

    def _label(self, rule: SuccessRule) -> int:
        """What one number in infos, an attribute, or an array beside the steps says."""
        single = self._told(rule.key)
        if single is not None and self._is_single(single):
            return rule.of_episode(single.value, self._noun(rule.key))
        if rule.key in self._group.attrs:
            return rule.of_episode(self._group.attrs[rule.key], self._noun(rule.key))
        if rule.key not in self._group:
            return UNKNOWN
        found = member_of(self._path, self._group, rule.key)
        if not isinstance(found, Array) or found.size not in (1, self.steps, self.steps + 1):
            raise UsageError(f"{self._noun(rule.key)} is no label of an episode or of its steps")
        if found.size == 1:
            return rule.of_episode(found.value, self._noun(rule.key))
        return int(rule.of_steps(found[found.size - self.steps :], self._noun(rule.key)).max())

    def text(self, key: str) -> str:
        """What an attribute says, or the first step's info; empty if neither does."""
        if key in self._group.attrs:
            return text_of(self._group.attrs[key])
        found = self._told(key)
        if found is None or (found.size != len(found) and not self._is_single(found)):
            return ""
        if self._is_single(found):
            return text_of(found.value)
        begins = len(found) - self.steps
        return text_of(found[begins : begins + 1]) if begins in (0, 1) else ""

    def _noun(self, key: str) -> str:
        return f"{self._path}, episode {self._number}: {key}"
