"""What a batch of envs gave, by env: a batch is taken apart along its space, and infos by their masks."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Dict, Tuple
from numpy.typing import NDArray

from harness.recorder.sealed import ReadOnlyDict

Mask = NDArray[np.bool_]
FINAL_OBSERVATION, FINAL_INFO = "final_obs", "final_info"


def items_of(space: Space[Any], batch: Any) -> list[Any]:
    """The part of each env, (num_envs,).

    Args:
        space: Of one env. What is no dict and no tuple there is an array of the batch, or a tuple of what envs gave.
        batch: Of all envs.
    """
    if isinstance(batch, np.ndarray):
        return list(batch)
    if isinstance(space, Dict):
        parts = zip(*(items_of(one, batch[key]) for key, one in space.spaces.items()), strict=True)
        return [ReadOnlyDict(zip(space.spaces, part, strict=True)) for part in parts]
    if isinstance(space, Tuple):
        return list(zip(*map(items_of, space.spaces, batch), strict=True))
    return list(batch)


def with_items(space: Space[Any], batch: Any, items: Mapping[int, Any]) -> Any:
    """A batch in which the parts of some envs are others; `batch` itself stays as it is."""
    if isinstance(space, Dict):
        each = space.spaces.items()
        return {key: with_items(one, batch[key], {env: it[key] for env, it in items.items()}) for key, one in each}
    if isinstance(space, Tuple):
        parts = enumerate(space.spaces)
        return tuple(with_items(one, batch[k], {env: it[k] for env, it in items.items()}) for k, one in parts)
    if not isinstance(batch, np.ndarray):
        return tuple(items.get(env, item) for env, item in enumerate(batch))
    found = batch.copy()
    for env, item in items.items():
        found[env] = item
    return found


def item_of(values: Any, env: int) -> Any:
    """One env's part of what infos hold."""
    return {key: item_of(it, env) for key, it in values.items()} if isinstance(values, Mapping) else values[env]


def info_of(infos: Mapping[str, Any], env: int) -> ReadOnlyDict:
    """The info of one env, as it told it itself; `infos` is that of the batch, with a mask ``_key`` for each key."""
    told: dict[str, Any] = {}
    for key, values in infos.items():
        mask = infos.get(f"_{key}")
        if not _is_mask(key, infos) and (mask is None or mask[env]):
            told[key] = info_of(values, env) if isinstance(values, Mapping) else values[env]
    return ReadOnlyDict(told)


def infos_last(infos: Mapping[str, Any]) -> Mapping[str, Any]:
    """What the envs told last: those that are at a new start already, of their reset."""
    if FINAL_OBSERVATION not in infos and FINAL_INFO not in infos:
        return infos
    return {key: it for key, it in infos.items() if key.removeprefix("_") not in (FINAL_OBSERVATION, FINAL_INFO)}


def infos_of_step(infos: Mapping[str, Any], ended: Mask) -> Mapping[str, Any]:
    """What the envs told of the step itself, those too that are at a new start already."""
    last = infos_last(infos)
    return joined(last, infos[FINAL_INFO], ended) if FINAL_INFO in infos and ended.any() else last


def joined(infos: Mapping[str, Any], others: Mapping[str, Any], mask: Mask) -> Mapping[str, Any]:
    """Infos of a batch: `others` for the envs of `mask`, (num_envs,), and `infos` for the rest."""
    found: dict[str, Any] = {}
    for key in dict.fromkeys((*infos, *others)):
        if _is_mask(key, infos) or _is_mask(key, others):
            continue
        here, there = _told(infos, key, ~mask), _told(others, key, mask)
        if not (here | there).any():
            continue
        one, other = infos.get(key), others.get(key)
        if isinstance(one, Mapping) and isinstance(other, Mapping):
            values: Any = joined(one, other, mask)
        else:
            values = one if not there.any() else other if not here.any() else _chosen(one, here, other, there)
        found |= {key: values, f"_{key}": here | there}
    return found


def _chosen(one: Any, here: Mask, other: Any, there: Mask) -> NDArray[Any]:
    """An array with the values of two, each where its mask says so; of objects where no array can hold both."""
    found = np.full(len(here), None, object)
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray) and one.shape == other.shape:
        is_number = {one.dtype.kind, other.dtype.kind} <= set("biuf")
        found = np.zeros(one.shape, np.result_type(one, other) if is_number else object)
    for values, of in ((one, here), (other, there)):
        for env in np.flatnonzero(of).tolist():
            found[env] = item_of(values, env)
    return found


def _told(infos: Mapping[str, Any], key: str, mask: Mask) -> Mask:
    """Which envs of a mask told something under a key."""
    return mask & infos.get(f"_{key}", np.True_) if key in infos else np.zeros_like(mask)


def _is_mask(key: str, infos: Mapping[str, Any]) -> bool:
    return key.startswith("_") and key[1:] in infos
