"""Episodes as a Minari data set: ``data/main_data.hdf5`` and ``data/metadata.json``, written by h5py alone."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from ..datasets.dataset import OWN_REWARDS
from ..datasets.minari_facts import MAIN, METADATA
from .episodes import TERMS, Exported, Nested, Source, Term

WRITTEN_AS = "0.5.4"
"""The version of Minari whose layout it is."""


def write_minari(source: Source, folder: Path) -> int:
    """Write a data set into a folder of its own; how many episodes it has.

    The rewards of an episode are what the learner was paid. What each reward pays by itself stands in its infos, as
    ``reward_0``, ``reward_1`` and so on, and what each term of it pays as ``reward_0_term_0``; the metadata has their
    names. All numbers are as they were recorded.

    Raises:
        OSError: The folder cannot be written.
        UsageError: An env cannot be made again.
    """
    (folder / MAIN).parent.mkdir(parents=True)
    count = steps = 0
    spaces: tuple[str, str] | None = None
    keys = {label: f"reward_{number}" for number, label in enumerate(source.rewards)}
    places = {label: [it for it in source.terms if it.reward == label] for label in source.rewards}
    terms = {it: f"{keys[label]}_term_{number}" for label, of in places.items() for number, it in enumerate(of)}
    with h5py.File(folder / MAIN, "w", track_order=True) as file:
        for episode in source.episodes():
            spaces = spaces or (json.dumps(_space(episode.observations)), json.dumps(_space(episode.actions)))
            group = file.create_group(f"episode_{count}")
            group.attrs.update({"id": count, "total_steps": len(episode.rewards), "operator": episode.operator})
            _write_episode(group, episode, keys, terms)
            count, steps = count + 1, steps + len(episode.rewards)
    observation, action = spaces or ("", "")
    told = {
        "total_episodes": count,
        "total_steps": steps,
        "data_format": "hdf5",
        "jpeg_encoding": False,
        "observation_space": observation,
        "action_space": action,
        "dataset_id": f"{source.name}-v0",
        "minari_version": WRITTEN_AS,
        "dataset_size": round((folder / MAIN).stat().st_size / 1e6, 1),
        "algorithm_name": "fd100-harness",
        "robot": source.robot,
        "observation_names": list(source.names.get("observation", ())),
        OWN_REWARDS: {key: label for label, key in keys.items()},
        **({TERMS: {key: term.title for term, key in terms.items()}} if terms else {}),
    }
    (folder / METADATA).write_text(json.dumps(told), encoding="utf-8")
    return count


def _write_episode(group: Any, episode: Exported, keys: Mapping[str, str], terms: Mapping[Term, str]) -> None:
    infos: dict[str, NDArray[Any]] = {
        **episode.infos,
        **{keys[label]: values for label, values in episode.paid.items()},
        **{terms[term]: values for term, values in episode.terms.items()},
    }
    if episode.success is not None:
        infos["success"] = episode.success
    # Minari's infos begin with that of the reset, of which nothing is known.
    infos = {key: np.concatenate([np.zeros(1, values.dtype), values]) for key, values in infos.items()}
    parts = {
        "observations": episode.observations,
        "actions": episode.actions,
        "rewards": episode.rewards,
        "terminations": episode.terminated,
        "truncations": episode.truncated,
        "infos": infos,
    }
    for key, value in parts.items():
        _put(group, key, value)


def _put(group: Any, key: str, value: Any) -> None:
    if isinstance(value, tuple):
        value = {f"_index_{number}": part for number, part in enumerate(value)}
    if isinstance(value, Mapping):
        inner = group.create_group(key)
        for name, part in value.items():
            _put(inner, name, part)
    else:
        group.create_dataset(key, data=value)


def _space(rows: Nested) -> dict[str, Any]:
    """A space without bounds that has such rows, as Minari writes it."""
    if isinstance(rows, Mapping):
        return {"type": "Dict", "subspaces": {key: _space(part) for key, part in rows.items()}}
    if isinstance(rows, tuple):
        return {"type": "Tuple", "subspaces": [_space(part) for part in rows]}
    if rows.ndim == 1 and rows.dtype.kind in "iub":
        return {"type": "Discrete", "dtype": "int64", "start": 0, "n": 2**31}
    shape = rows.shape[1:]
    whole = rows.dtype.kind in "iu"
    low, high = (np.iinfo(rows.dtype).min, np.iinfo(rows.dtype).max) if whole else (-np.inf, np.inf)
    ends = {name: np.full(shape, value, rows.dtype).tolist() for name, value in (("low", low), ("high", high))}
    return {"type": "Box", "dtype": str(rows.dtype), "shape": list(shape), **ends}
