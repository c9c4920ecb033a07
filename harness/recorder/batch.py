"""One step of a batch of envs, and what each env said in it."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.vector import VectorEnv
from gymnasium.vector.utils import iterate
from numpy.typing import NDArray

from harness.arrays import Float
from harness.recorder.column import Untold

Mask = NDArray[np.bool_]
FINAL_OBSERVATION, FINAL_INFO = "final_obs", "final_info"


@dataclass(eq=False)
class BatchStep:
    """One step of a batch.

    Attributes:
        env: Whose step it was.
        before: Observations before it.
        actions: Those given.
        returned: Observations that the env returned; of an env that it reset at once, those of its new start.
        paid: (num_envs,).
        ended: (num_envs,), whether the step ended an episode.
        live: (num_envs,), whether the env took a step; otherwise it was only reset.
        infos: As the env returned them.
        reset_at_once: Whether envs whose episode ended are at their new start already (``SAME_STEP``).
        seal: Makes of what functions are given copies that they cannot write into; None where no function is asked.
            `before` and `actions` are such copies.
    """

    env: VectorEnv[Any, Any, Any]
    before: Any
    actions: Any
    returned: Any
    paid: Float
    ended: Mask
    live: Mask
    infos: Mapping[str, Any]
    reset_at_once: bool
    seal: Callable[[Any], Any] | None = None

    @cached_property
    def after(self) -> Any:
        """Observations after the step, before any reset; a copy."""
        batch = copy.deepcopy(self.returned)
        if self.reset_at_once:
            for env in np.flatnonzero(self.ended):
                _put(batch, int(env), _item(self.infos[FINAL_OBSERVATION], int(env)))
        return batch if self.seal is None else self.seal(batch)

    @cached_property
    def each_before(self) -> list[Any]:
        """`before`, by env."""
        return self._items(self.env.observation_space, self.before)

    @cached_property
    def each_after(self) -> list[Any]:
        """`after`, by env."""
        return self._items(self.env.observation_space, self.after)

    @cached_property
    def each_action(self) -> list[Any]:
        """`actions`, by env."""
        return self._items(self.env.action_space, self.actions)

    @cached_property
    def sealed_infos(self) -> Any:
        """`infos` for functions."""
        return self.infos if self.seal is None else self.seal(self.infos)

    def sealed_info(self, env: int) -> Any:
        """`info` for functions."""
        if env not in self._sealed:
            self._sealed[env] = self.info(env) if self.seal is None else self.seal(self.info(env))
        return self._sealed[env]

    def info(self, env: int) -> dict[str, Any]:
        """What one env told of its step."""
        return _info_of(self._infos_behind(env), env)

    def told(self, key: str, env: int) -> Any:
        """What one env told under a key.

        Raises:
            Untold: Nothing.
        """
        info = self.info(env)
        if key not in info:
            raise Untold(key, [*info])
        return info[key]

    def told_numbers(self, key: str) -> tuple[Float, Mask]:
        """What the envs told under a key, and which of them told something, as far as an array of numbers says it."""
        values, mask, count = self.infos.get(key), self.infos.get(f"_{key}"), len(self.paid)
        if not (isinstance(values, np.ndarray) and values.shape == (count,) and values.dtype.kind in "biuf"):
            return np.zeros(count), np.zeros(count, bool)
        told = np.ones(count, bool) if mask is None else np.asarray(mask, bool)
        return values.astype(float), told & ~self.ended if self._tells_apart else told

    @property
    def _tells_apart(self) -> bool:
        """Whether ended envs told of their last step apart; a batch without infos of resets does not need to."""
        return self.reset_at_once and FINAL_INFO in self.infos

    @cached_property
    def _sealed(self) -> dict[int, Any]:
        return {}

    def _items(self, space: Space[Any], batch: Any) -> list[Any]:
        if isinstance(batch, np.ndarray):
            return list(batch)
        items = iterate(space, batch)
        return list(items) if self.seal is None else [self.seal(item) for item in items]

    def _infos_behind(self, env: int) -> Mapping[str, Any]:
        if self._tells_apart and self.ended[env]:
            final: Mapping[str, Any] = self.infos[FINAL_INFO]
            return final
        return self.infos


def _item(batch: Any, env: int) -> Any:
    """One env's part of an array, or of such arrays in dicts and tuples."""
    if isinstance(batch, Mapping):
        return {key: _item(inner, env) for key, inner in batch.items()}
    if isinstance(batch, tuple):
        return tuple(_item(inner, env) for inner in batch)
    return batch[env]


def _put(batch: Any, env: int, item: Any) -> None:
    if isinstance(batch, Mapping):
        for key, inner in batch.items():
            _put(inner, env, item[key])
    elif isinstance(batch, tuple):
        for inner, one in zip(batch, item, strict=True):
            _put(inner, env, one)
    else:
        batch[env] = item


def _info_of(infos: Mapping[str, Any], env: int) -> dict[str, Any]:
    """The info of one env, as it told it itself; `infos` is that of the batch, with a mask ``_key`` for each key."""
    told: dict[str, Any] = {}
    for key, values in infos.items():
        mask = infos.get(f"_{key}")
        is_mask = key.startswith("_") and key[1:] in infos
        if not is_mask and (mask is None or mask[env]) and key not in {FINAL_OBSERVATION, FINAL_INFO}:
            told[key] = _info_of(values, env) if isinstance(values, Mapping) else values[env]
    return told
