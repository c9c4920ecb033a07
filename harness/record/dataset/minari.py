"""A Minari data set: ``data/metadata.json`` and ``data/main_data.hdf5``, read by h5py alone.

The library `minari` is not needed. It makes spaces and, where the metadata has none, the env itself, to read a data
set; here all comes from the shapes in the file.
"""

import re
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading, require_regular
from harness.record.dataset.census import Declared, take_census
from harness.record.dataset.dataset import (
    MOST_EPISODES,
    OPERATOR_KEYS,
    OWN_REWARDS,
    PIECE_BYTES,
    RECORDED,
    ROWS,
    SUCCESS_KEYS,
    Dataset,
    DatasetFacts,
    Nested,
    Piece,
    flaw_of,
    leaves,
    own_rewards,
    require_readable,
    row_count,
)
from harness.record.dataset.hdf5_parts import (
    Walk,
    address,
    group_of,
    is_array,
    member_of,
    numbers_of_row,
    open_hdf5,
)
from harness.record.dataset.labels import UNKNOWN, SuccessRule, missing_key, success_rule
from harness.record.dataset.minari_facts import (
    MAIN,
    MOST_BYTES,
    dataset_folder,
    pictures_of,
    read_metadata,
    require_known,
    text_of,
)
from harness.text import shortened

TASK_KEYS = (
    *("task", "task_id", "task_index", "task_name", "env_id", "env_name", "env", "environment", "env_spec"),
    *("options/task", "options/task_id", "options/task_index", "options/task_name", "options/env_id"),
)
"""What may say which task an episode does, or in which env: an attribute of it, or a key of its infos."""
STEP_DATA = ("observations", "actions", "rewards", "terminations", "truncations", "infos")
_EPISODE = re.compile(r"episode_(0|[1-9]\d{0,8})")


class _Layout(NamedTuple):
    """What is read of each episode.

    Attributes:
        numbers: Of the episodes.
        own: By key of infos, names of rewards that `harness export` wrote.
        pictures: Parts of the observation that are left out.
        rule: Where success stands; None where nothing says it.
    """

    numbers: tuple[int, ...]
    own: Mapping[str, str]
    pictures: frozenset[str]
    rule: SuccessRule | None


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


def open_minari(name: str, success: SuccessRule | None, cluster: str = "", partial_is_enough: bool = False) -> Dataset:
    """A data set; its steps are read later.

    Args:
        name: Its folder, or its name below Minari's folder.
        success: Where success stands, in infos or in an attribute of episodes; found by its name if it has no key. None
            where it is not looked for.
        cluster: The attribute of episodes, or the key of infos, that says who made them; found by its name if empty.
        partial_is_enough: Whether less than the metadata declares may be there.

    Raises:
        UsageError: It is not there, or h5py is not installed.
        NewerFormat: A newer version of Minari wrote it.
        SchemaError: It is damaged, stored in another way than HDF5, or is not what its metadata declares.
    """
    folder = dataset_folder(name)
    path = folder / MAIN
    with reading(path, "Minari data set"):
        require_regular(path, MOST_BYTES)
        with open_hdf5(path) as file:
            metadata = read_metadata(folder, file)
            require_known(path, metadata)
            seen = _overview(path, file)
        own = own_rewards(path, metadata.get(OWN_REWARDS), seen.infos)
        episodes, steps = (_whole(metadata.get(key)) for key in ("total_episodes", "total_steps"))
        declared = Declared(episodes, steps, lengths=seen.told)
        census = take_census(path, declared, seen.steps, partial_is_enough)
    told = (*seen.infos, *seen.attributes)
    if cluster and cluster not in told:
        raise missing_key("--cluster", cluster, path, told)
    pictures = pictures_of(metadata)
    rule = success_rule(success, told, path, SUCCESS_KEYS)
    facts = DatasetFacts(
        f"minari:{name}",
        folder,
        f"Minari {metadata.get('minari_version', '')}".strip(),
        env=text_of(metadata.get("env_spec")),
        rewards=(RECORDED, *own.values()),
        success="" if rule is None else rule.text,
        operator=cluster or next((key for key in OPERATOR_KEYS if key in told), ""),
        task=next((key for key in TASK_KEYS if key in told), ""),
        pictures_left_out=bool(pictures),
        notes=tuple(_notes(pictures, seen, metadata, census.notes)),
    )
    return Dataset(
        facts, partial(_pieces, facts, _Layout(tuple(sorted(census.episodes - seen.again)), own, pictures, rule))
    )


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


def _whole(value: Any) -> int | None:
    """A number of episodes or steps, as JSON or HDF5 has it."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    return int(value) if whole and value >= 0 else None


def _overview(path: Path, file: Any) -> _Overview:
    if len(file) > MOST_EPISODES:
        raise SchemaError(f"{path} has {len(file):,} episodes, {MOST_EPISODES:,} are allowed")
    numbers = sorted(int(found[1]) for key in file if (found := _EPISODE.fullmatch(key)))
    if not numbers:
        raise SchemaError(f"{path} has no episode")
    strangers = tuple(key for key in file if not _EPISODE.fullmatch(key))[:5]
    seen = _Overview({}, {}, {}, {}, set(), strangers)
    numbers_at: dict[int, int] = {}
    for number in numbers:
        group = group_of(path, file, f"episode_{number}")
        first = numbers_at.setdefault(address(group), number)
        if first != number:
            seen.again.add(number)
            seen.steps[number] = seen.steps[first]
            continue
        seen.steps[number] = len(member_of(path, group, "rewards"))
        if (told := _whole(group.attrs.get("total_steps"))) is not None:
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


def _pieces(facts: DatasetFacts, layout: _Layout) -> Iterator[Piece]:
    path = facts.path / MAIN
    values = 0
    with reading(path, "Minari data set"), open_hdf5(path) as file:
        for number in layout.numbers:
            episode = _Episode(path, facts, layout, group_of(path, file, f"episode_{number}"), number)
            values += episode.steps * episode.width
            require_readable(path, 1, values)
            yield from episode.pieces()


class _Episode:
    """One episode in the file."""

    def __init__(self, path: Path, facts: DatasetFacts, layout: _Layout, group: Any, number: int) -> None:
        self._path, self._facts, self._layout, self._group, self._number = path, facts, layout, group, number
        walk = Walk(path)
        self._actions = walk.nested(member_of(path, group, "actions"), frozenset(), "actions")
        self._rewards = member_of(path, group, "rewards")
        self.steps = len(self._rewards)
        found = member_of(path, group, "observations")
        seen = {} if "observations" in layout.pictures else walk.nested(found, layout.pictures, "observations")
        is_seen = any(True for _ in leaves(seen))
        self._observations = seen if is_seen else np.empty((self.steps + 1, 0), np.float32)
        self._require_rows()
        infos = dict(walk.numbers(group_of(path, group, "infos"))) if "infos" in group else {}
        self._single = {key: found for key, found in infos.items() if found.size == 1 != self.steps}
        rows = {key: found for key, found in infos.items() if found.ndim and len(found) - self.steps in (0, 1)}
        self._infos = {key: found for key, found in rows.items() if key not in self._single}
        parts = (*leaves(self._observations), *leaves(self._actions), *self._infos.values())
        self.width = sum(numbers_of_row(part) for part in parts)
        self._bytes = sum(part.dtype.itemsize * numbers_of_row(part) for part in parts)

    def _require_rows(self) -> None:
        steps, name = self.steps, f"{self._path}: episode {self._number}"
        if self._rewards.size != steps:
            raise SchemaError(f"{name} has {numbers_of_row(self._rewards):,} rewards a step, not one")
        if row_count(self._actions) != steps or row_count(self._observations) != steps + 1:
            raise SchemaError(
                f"{name} has {steps:,} rewards, {row_count(self._actions):,} actions and "
                f"{row_count(self._observations):,} observations; a Minari episode has one observation more than "
                "actions"
            )

    def pieces(self) -> Iterator[Piece]:
        """All its steps; of an episode without any, nothing."""
        rows = max(1, min(ROWS, PIECE_BYTES // max(1, self._bytes)))
        operator, task = self._of(self._facts.operator), self._of(self._facts.task)
        label = self._label()
        for first in range(0, self.steps, rows):
            end = min(first + rows, self.steps)
            infos = {key: self._info(key, first, end) for key in self._infos}
            own = self._layout.own
            paid = {RECORDED: self._rewards[first:end]}
            paid |= {name: infos[key] for key, name in own.items() if key in infos}
            gone = [name for name in own.values() if name not in paid]
            seen = _read(self._observations, slice(first, end + 1))
            done = _read(self._actions, slice(first, end))
            told = self._told(infos, end - first)
            if end == self.steps and told[-1] == UNKNOWN:
                told[-1] = label
            yield Piece(
                self._number,
                first,
                seen,
                done,
                {key: values for key, values in infos.items() if key not in own},
                {name: _numbers(values, name) for name, values in paid.items()},
                told,
                operator,
                task,
                MAIN.as_posix(),
                end == self.steps,
                f"reward {gone[0]} is not recorded"
                if gone
                else flaw_of(seen, "observations") or flaw_of(done, "actions") or flaw_of(paid, "a reward"),
            )

    def _info(self, key: str, first: int, end: int) -> NDArray[Any]:
        """What was told after these steps; infos may begin with what the reset told."""
        found = self._infos[key]
        begins = len(found) - self.steps
        return np.asarray(found[first + begins : end + begins])

    def _told(self, infos: Mapping[str, NDArray[Any]], count: int) -> NDArray[np.int8]:
        rule = self._layout.rule
        if rule is not None and rule.key in infos:
            return rule.of_steps(infos[rule.key], self._noun(rule.key))
        return np.full(count, UNKNOWN, np.int8)

    def _label(self) -> int:
        """What is said of the whole episode: by one number in infos, an attribute, or an array beside the steps."""
        rule = self._layout.rule
        if rule is None or rule.key in self._infos:
            return UNKNOWN
        if rule.key in self._single:
            return rule.of_episode(self._single[rule.key][()], self._noun(rule.key))
        if rule.key in self._group.attrs:
            return rule.of_episode(self._group.attrs[rule.key], self._noun(rule.key))
        if rule.key not in self._group:
            return UNKNOWN
        found = member_of(self._path, self._group, rule.key)
        if not is_array(found) or found.size not in (1, self.steps, self.steps + 1):
            raise UsageError(f"{self._noun(rule.key)} is no label of an episode or of its steps")
        if found.size == 1:
            return rule.of_episode(found[()], self._noun(rule.key))
        return int(rule.of_steps(np.asarray(found[found.size - self.steps :]), self._noun(rule.key)).max())

    def _of(self, key: str) -> str:
        """What an attribute says, or the first step's info."""
        if not key:
            return ""
        if key in self._group.attrs:
            told = self._group.attrs[key]
        elif key in self._infos and self._infos[key].size == len(self._infos[key]):
            told = self._info(key, 0, 1).ravel()[0]
        elif key in self._single:
            told = self._single[key][()]
        else:
            return ""
        if isinstance(told, np.ndarray) and told.size == 1:
            told = told.ravel()[0]
        return shortened(told.decode(errors="replace") if isinstance(told, bytes) else str(told), 200)

    def _noun(self, key: str) -> str:
        return f"{self._path}, episode {self._number}: {key}"


def _numbers(values: NDArray[Any], noun: str) -> NDArray[np.float64]:
    if values.size != len(values):
        raise SchemaError(f"the reward {noun} holds {values.size // max(1, len(values)):,} numbers a step, not one")
    return np.asarray(values, np.float64).reshape(len(values))


def _read(rows: Nested, which: slice) -> Nested:
    if isinstance(rows, dict):
        return {key: _read(part, which) for key, part in rows.items()}
    if isinstance(rows, tuple):
        return tuple(_read(part, which) for part in rows)
    return np.asarray(rows[which])
