"""A Minari data set: ``data/metadata.json`` and ``data/main_data.hdf5``, read by h5py alone.

The library `minari` is not needed. It makes spaces and, where the metadata has none, the env itself, to read a data
set; here all comes from the shapes in the file.
"""

import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.files.bounded import read_json, reading, require_regular
from harness.record.dataset.dataset import (
    MOST_EPISODES,
    MOST_KEYS,
    MOST_NUMBERS,
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
    any_success,
    leaves,
    require_finite,
    row_count,
)
from harness.text import shortened

METADATA, MAIN = Path("data/metadata.json"), Path("data/main_data.hdf5")
NEWEST = (0, 5)
"""The newest version of Minari whose files are known."""
MOST_BYTES = 2**40
CHUNK_BYTES = 2**28
"""The most bytes of a chunk: HDF5 unpacks it whole."""
DEEPEST = 8
_EPISODE = re.compile(r"episode_(0|[1-9]\d{0,8})")
_VERSION = re.compile(r"(\d{1,4})\.(\d{1,4})")


def dataset_folder(name: str) -> Path:
    """The folder of a data set: a path, or a name below the place where Minari keeps them.

    Raises:
        UsageError: There is none.
    """
    home = Path(os.environ.get("MINARI_DATASETS_PATH") or Path.home() / ".minari" / "datasets")
    for folder in (Path(os.path.expanduser(name)), home / name):
        if (folder / MAIN).is_file():
            return folder
    raise UsageError(
        f"No Minari data set at '{name}', nor in '{home}': name its folder, which holds {MAIN}, or fetch it with "
        f"minari download {shortened(name, 80)}"
    )


def open_minari(name: str, success: str = "", cluster: str = "") -> Dataset:
    """A data set; its steps are read later.

    Args:
        name: Its folder, or its name below Minari's folder.
        success: The key of infos that says whether a step was a success; found by its name if empty.
        cluster: The attribute of episodes that says who made them; found by its name if empty.

    Raises:
        UsageError: It is not there, or h5py is not installed.
        NewerFormat: A newer version of Minari wrote it.
        SchemaError: It is damaged, or stored in another way than HDF5.
    """
    folder = dataset_folder(name)
    path = folder / MAIN
    with reading(path, "Minari data set"):
        require_regular(path, MOST_BYTES)
        with _opened(path) as file:
            metadata = _metadata(folder, file)
            numbers = _episode_numbers(path, file)
            first = _group(path, file, f"episode_{numbers[0]}")
            keys = _info_keys(path, first)
            attributes = set(first.attrs)
    _require_known(path, metadata)
    own = _own_rewards(metadata, keys)
    pictures = _pictures(metadata)
    notes = [f"The pictures {', '.join(sorted(pictures))} are left out"] if pictures else []
    facts = DatasetFacts(
        f"minari:{name}",
        folder,
        f"Minari {metadata.get('minari_version', '')}".strip(),
        env=_text(metadata.get("env_spec")),
        rewards=(RECORDED, *own.values()),
        success=_chosen(success, keys, SUCCESS_KEYS, "--success", path),
        operator=cluster or next((key for key in OPERATOR_KEYS if key in attributes), ""),
        notes=tuple(notes),
    )
    return Dataset(facts, partial(_pieces, facts, numbers, own, pictures))


def _opened(path: Path) -> Any:
    try:
        import h5py
    except ImportError as error:
        raise UsageError(
            f"A Minari data set needs h5py, which cannot be imported ({error}): pip install 'fd100-harness[minari]'"
        ) from error
    return h5py.File(path, "r", locking=False)


def _metadata(folder: Path, file: Any) -> dict[str, Any]:
    """What the data set tells of itself; before Minari 0.5 it stood in attributes of the file."""
    path = folder / METADATA
    if not path.is_file():
        return {str(key): value for key, value in file.attrs.items()}
    told = read_json(path)
    if not isinstance(told, dict):
        raise SchemaError(f"{path} holds no table")
    return told


def _require_known(path: Path, metadata: Mapping[str, Any]) -> None:
    kind = metadata.get("data_format", "hdf5")
    if kind != "hdf5":
        raise SchemaError(f"{path} tells of the format {shortened(str(kind), 40)!r}; Minari data sets in hdf5 are read")
    found = _VERSION.match(str(metadata.get("minari_version", "")))
    if found and (int(found[1]), int(found[2])) > NEWEST:
        newest = ".".join(map(str, NEWEST))
        raise NewerFormat(f"{path} was written by Minari {found[0]}, and versions up to {newest} are read")


def _episode_numbers(path: Path, file: Any) -> list[int]:
    if len(file) > MOST_EPISODES:
        raise SchemaError(f"{path} has {len(file):,} episodes, {MOST_EPISODES:,} are allowed")
    numbers = sorted(int(found[1]) for key in file if (found := _EPISODE.fullmatch(key)))
    if not numbers:
        raise SchemaError(f"{path} has no episode")
    return numbers


def _group(path: Path, parent: Any, key: str) -> Any:
    found = _member(path, parent, key)
    if hasattr(found, "dtype"):
        raise SchemaError(f"{path}: {found.name} is no group")
    return found


def _member(path: Path, parent: Any, key: str) -> Any:
    """A part of a group; one that lies in another file is refused.

    Raises:
        SchemaError: It is missing, leads to another file, or is too large to be unpacked.
    """
    import h5py

    link = parent.get(key, getlink=True)
    if link is None:
        raise SchemaError(f"{path}: {parent.name} has no {key}")
    if not isinstance(link, h5py.HardLink):
        raise SchemaError(f"{path}: {parent.name}/{key} is a link to somewhere else, which is not followed")
    found = parent[key]
    if isinstance(found, h5py.Datatype):
        raise SchemaError(f"{path}: {found.name} is a type, no data")
    if isinstance(found, h5py.Dataset):
        if found.external or found.is_virtual:
            raise SchemaError(f"{path}: {found.name} takes its numbers from other files, which is not followed")
        if found.chunks and math.prod(found.chunks) * found.dtype.itemsize > CHUNK_BYTES:
            raise SchemaError(f"{path}: {found.name} has chunks of more than {CHUNK_BYTES:,} bytes")
    elif len(found) > MOST_KEYS:
        raise SchemaError(f"{path}: {found.name} has {len(found):,} parts, {MOST_KEYS:,} are allowed")
    return found


def _info_keys(path: Path, episode: Any) -> dict[str, None]:
    """Keys of the infos that hold a number for each step, at any depth, ``a/b``."""
    if "infos" not in episode:
        return {}
    return {key: None for key, _ in _walk(path, _group(path, episode, "infos"))}


def _walk(path: Path, group: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    if depth > DEEPEST:
        raise SchemaError(f"{path}: {group.name} is nested too deeply")
    for key in group:
        found = _member(path, group, key)
        if hasattr(found, "dtype"):
            if found.dtype.kind in "biuf" and found.ndim >= 1 and _size(found) <= MOST_NUMBERS:
                yield f"{prefix}{key}", found
        else:
            yield from _walk(path, found, f"{prefix}{key}/", depth + 1)


def _size(found: Any) -> int:
    return math.prod(found.shape[1:])


def _chosen(given: str, keys: Mapping[str, None], known: tuple[str, ...], flag: str, path: Path) -> str:
    if given and given not in keys:
        raise UsageError(f"{flag} {given}: {path} has no such key; it has {', '.join(keys) or 'none'}")
    return given or next((key for key in known if key in keys), "")


def _own_rewards(metadata: Mapping[str, Any], keys: Mapping[str, None]) -> dict[str, str]:
    """By key of infos, the names of rewards that `harness export` wrote."""
    told = metadata.get(OWN_REWARDS, {})
    if not isinstance(told, dict):
        return {}
    return {key: shortened(name, 200) for key, name in told.items() if key in keys and isinstance(name, str)}


def _text(spec: Any) -> str:
    return spec if isinstance(spec, str) else ""


def _pictures(metadata: Mapping[str, Any]) -> frozenset[str]:
    """Parts of the observation that are pictures, by their place, ``observations/camera``."""
    text = metadata.get("observation_space")
    if not isinstance(text, str):
        return frozenset()
    try:
        space = json.loads(text)
    except (ValueError, RecursionError):
        return frozenset()
    return frozenset(_picture_places(space, "observations", 0))


def _picture_places(space: Any, place: str, depth: int) -> Iterator[str]:
    if not isinstance(space, dict) or depth > DEEPEST:
        return
    shape, parts = space.get("shape"), space.get("subspaces")
    if space.get("dtype") == "uint8" and isinstance(shape, list) and len(shape) == 3:
        yield place
    elif isinstance(parts, dict):
        for key, part in parts.items():
            yield from _picture_places(part, f"{place}/{key}", depth + 1)
    elif isinstance(parts, list):
        for number, part in enumerate(parts):
            yield from _picture_places(part, f"{place}/_index_{number}", depth + 1)


def _pieces(
    facts: DatasetFacts, numbers: list[int], own: Mapping[str, str], pictures: frozenset[str]
) -> Iterator[Piece]:
    path = facts.path / MAIN
    with reading(path, "Minari data set"), _opened(path) as file:
        for number in numbers:
            yield from _episode(path, facts, _group(path, file, f"episode_{number}"), number, own, pictures)


def _episode(
    path: Path, facts: DatasetFacts, group: Any, number: int, own: Mapping[str, str], pictures: frozenset[str]
) -> Iterator[Piece]:
    observations = _nested(path, group, "observations", pictures, "observations")
    actions = _nested(path, group, "actions", frozenset(), "actions")
    rewards = _member(path, group, "rewards")
    steps = len(rewards)
    if steps == 0:
        return
    if row_count(actions) != steps or row_count(observations) != steps + 1:
        raise SchemaError(
            f"{path}: episode {number} has {steps:,} rewards, {row_count(actions):,} actions and "
            f"{row_count(observations):,} observations; a Minari episode has one observation more than actions"
        )
    infos = dict(_walk(path, _group(path, group, "infos"))) if "infos" in group else {}
    begins = {key: len(found) - steps for key, found in infos.items()}
    infos = {key: found for key, found in infos.items() if begins[key] in (0, 1)}  # others are not one for each step
    width = sum(
        part.dtype.itemsize * _size(part) for part in (*leaves(observations), *leaves(actions), *infos.values())
    )
    rows = max(1, min(ROWS, PIECE_BYTES // max(1, width)))
    operator = _operator(group, facts.operator)
    for first in range(0, steps, rows):
        end = min(first + rows, steps)
        told = {
            key: np.asarray(found[first + begins[key] : end + begins[key]])
            for key, found in infos.items()
        }  # fmt: skip
        paid = {RECORDED: rewards[first:end], **{name: told[key] for key, name in own.items() if key in told}}
        yield Piece(
            number,
            first,
            _read(observations, slice(first, end + 1), f"{path}, episode {number}: observations"),
            _read(actions, slice(first, end), f"{path}, episode {number}: actions"),
            {key: values for key, values in told.items() if key not in own},
            {name: _numbers(values, f"{path}, episode {number}: reward {name}") for name, values in paid.items()},
            any_success(told.get(facts.success)),
            operator,
            MAIN.as_posix(),
            end == steps,
        )


def _operator(group: Any, key: str) -> str:
    told = group.attrs[key] if key and key in group.attrs else ""
    return shortened(told.decode(errors="replace") if isinstance(told, bytes) else str(told), 200)


def _numbers(values: NDArray[Any], noun: str) -> NDArray[np.float64]:
    return np.asarray(require_finite(values, noun), np.float64).reshape(len(values))


def _nested(path: Path, parent: Any, key: str, left_out: frozenset[str], place: str, depth: int = 0) -> Nested:
    """An observation or an action as arrays in the file."""
    found = _member(path, parent, key)
    if hasattr(found, "dtype"):
        if found.ndim < 1 or found.dtype.kind not in "biuf" or _size(found) > MOST_NUMBERS:
            raise SchemaError(f"{path}: {found.name} holds no rows of at most {MOST_NUMBERS:,} numbers")
        return found
    if depth > DEEPEST:
        raise SchemaError(f"{path}: {found.name} is nested too deeply")
    parts = {
        name: _nested(path, found, name, left_out, f"{place}/{name}", depth + 1)
        for name in found
        if f"{place}/{name}" not in left_out
    }
    if parts and all(f"_index_{number}" in parts for number in range(len(parts))):
        return tuple(parts[f"_index_{number}"] for number in range(len(parts)))
    return parts


def _read(rows: Nested, which: slice, noun: str) -> Nested:
    if isinstance(rows, dict):
        return {key: _read(part, which, noun) for key, part in rows.items()}
    if isinstance(rows, tuple):
        return tuple(_read(part, which, noun) for part in rows)
    return require_finite(np.asarray(rows[which]), noun)
