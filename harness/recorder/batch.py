"""One step of a batch of envs, and what each env said in it."""

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from gymnasium import Space
from gymnasium.vector import VectorEnv
from gymnasium.vector.utils import iterate
from numpy.typing import NDArray

from harness.arrays import Float
from harness.recorder.sealed import ReadOnlyDict
from harness.reward import Steps
from harness.reward.given import Before, Now, told_under, zeros_of

Mask = NDArray[np.bool_]
FINAL_OBSERVATION, FINAL_INFO = "final_obs", "final_info"


class BatchBefore(NamedTuple):
    """What there was before a step of a batch.

    Attributes:
        observations: That the envs returned last, sealed.
        infos: As they returned them, sealed or not.
        info: What one env told last, sealed or not; of an env that starts an episode what its reset told.
        actions: Those of the step before, sealed; None before the first.
    """

    observations: Any
    infos: Mapping[str, Any]
    info: Callable[[int], Mapping[str, Any]]
    actions: Any = None


NOTHING_BEFORE = BatchBefore(None, {}, lambda env: {})


@dataclass(eq=False)
class BatchStep:
    """One step of a batch.

    Attributes:
        env: Whose step it was.
        before: What there was before it.
        actions: Those given.
        returned: Observations that the env returned; of an env that it reset at once, those of its new start.
        paid: (num_envs,).
        ended: (num_envs,), whether the step ended an episode.
        live: (num_envs,), whether the env took a step; otherwise it was only reset.
        infos: As the env returned them.
        reset_at_once: Whether envs whose episode ended are at their new start already (``SAME_STEP``).
        seal: Makes of what functions are given copies that they cannot write into; None where no function is asked.
            What `before` has, and `actions`, are such copies.
        begins: (num_envs,), whether it is the first step of an episode.
    """

    env: VectorEnv[Any, Any, Any]
    before: BatchBefore
    actions: Any
    returned: Any
    paid: Float
    ended: Mask
    live: Mask
    infos: Mapping[str, Any]
    reset_at_once: bool
    seal: Callable[[Any], Any] | None = None
    begins: Mask = field(default_factory=lambda: np.zeros(0, bool))

    @cached_property
    def after(self) -> Any:
        """Observations after the step, before any reset; a copy."""
        batch = copy.deepcopy(self.returned)
        if self.reset_at_once:
            for env in np.flatnonzero(self.ended):
                _put(batch, int(env), _item(self.infos[FINAL_OBSERVATION], int(env)))
        return self._sealed(batch)

    @cached_property
    def each_after(self) -> list[Any]:
        """`after`, by env."""
        return self._items(self.env.observation_space, self.after)

    @cached_property
    def each_action(self) -> list[Any]:
        """`actions`, by env."""
        return self._items(self.env.action_space, self.actions)

    @cached_property
    def whole(self) -> Steps:
        """The step of all envs, as functions are given it."""
        before = self.before
        actions = zeros_of(self.actions) if before.actions is None else before.actions
        if before.actions is not None and self.begins.any():
            actions = copy.deepcopy(actions)
            for env in np.flatnonzero(self.begins):
                _put(actions, int(env), zeros_of(_item(actions, int(env))))
            actions = self._sealed(actions)
        then = Before._make((before.observations, actions, self._sealed(before.infos)))
        return Now._make((self.after, self.actions, self._sealed(self.infos), then))

    def of_each(self, is_of_step: bool) -> Sequence[tuple[Any, ...]]:
        """What functions are called with about the step of each env, (num_envs,)."""
        return self._nows if is_of_step else self._arguments

    def told_last(self, env: int) -> Mapping[str, Any]:
        """What one env told last: of its step, or of its reset if it is at its new start already."""
        if self.reset_at_once and self.ended[env]:
            return _info_of(self.infos, env)
        return self._arguments[env][-1] if "_arguments" in vars(self) else self.info(env)

    @property
    def infos_told(self) -> Mapping[str, Any]:
        """`infos`, sealed if functions were given them: whoever trains may write into them later."""
        infos: Mapping[str, Any] = self.whole.info if "whole" in vars(self) else self.infos
        return infos

    def info(self, env: int) -> dict[str, Any]:
        """What one env told of its step."""
        return _info_of(self._infos_behind(env), env)

    def told(self, key: str, env: int) -> Any:
        """What one env told under a key.

        Raises:
            Untold: Nothing.
        """
        return told_under(self.info(env), key)

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
    def _arguments(self) -> list[tuple[Any, ...]]:
        infos = [self._sealed(self.info(env)) for env in range(len(self.live))]
        return list(zip(self._each_before, self.each_action, self.each_after, infos, strict=True))

    @cached_property
    def _nows(self) -> list[tuple[Steps]]:
        last, begins = self._each_last_action, self.begins.tolist()
        found = []
        for env, (seen, action, observation, info) in enumerate(self._arguments):
            acted = zeros_of(action) if last is None or begins[env] else last[env]
            before = Before._make((seen, acted, self._sealed(self.before.info(env))))
            found.append((Now._make((observation, action, info, before)),))
        return found

    @cached_property
    def _each_before(self) -> list[Any]:
        return self._items(self.env.observation_space, self.before.observations)

    @cached_property
    def _each_last_action(self) -> list[Any] | None:
        return None if self.before.actions is None else self._items(self.env.action_space, self.before.actions)

    def _sealed(self, value: Any) -> Any:
        return value if self.seal is None or isinstance(value, ReadOnlyDict) else self.seal(value)

    def _items(self, space: Space[Any], batch: Any) -> list[Any]:
        if isinstance(batch, np.ndarray):
            return list(batch)
        items = iterate(space, batch)
        return list(map(self._sealed, items))

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


def infos_of(infos: Mapping[str, Any]) -> Callable[[int], dict[str, Any]]:
    """From the number of an env to what it told in a reset."""
    return lambda env: _info_of(infos, env)


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
