"""What a function is given of a step: copies that it cannot write into."""

import copy
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Never, TypeVar

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv
from numpy import ndarray

from harness.reward.given import Untold

CONSTANT = frozenset({float, int, bool, str, bytes, complex, type(None), np.float64, np.float32, np.int64, np.bool_})
"""The usual types of which a value never changes."""
MAPPINGS = (dict, OrderedDict, MappingProxyType)
AS_THEY_ARE = (np.generic, str, bytes, int, float, Enum, type, gymnasium.Env, VectorEnv)
"""Kinds of objects that are handed on: nobody can write into most of them, and a copy of an env is another env."""


class _ReadOnly:
    def _refuse(self, *_: Any, **__: Any) -> Never:
        raise TypeError("it is read-only: a function that looks on writes nothing into it")

    __setitem__ = __delitem__ = __ior__ = __iadd__ = __imul__ = pop = popitem = clear = update = setdefault = _refuse
    append = extend = insert = remove = sort = reverse = _refuse


class ReadOnlyDict(_ReadOnly, dict[Any, Any]):
    """A dict for readers; a copy of it is an ordinary one."""

    def __missing__(self, key: Any) -> Never:
        raise Untold(key, self)

    def __deepcopy__(self, memo: dict[int, Any]) -> dict[Any, Any]:
        return {key: copy.deepcopy(value, memo) for key, value in self.items()}

    def __reduce__(self) -> tuple[Any, ...]:
        return dict, (dict(self),)


class ReadOnlyList(_ReadOnly, list[Any]):
    """A list for readers; a copy of it is an ordinary one."""

    def __deepcopy__(self, memo: dict[int, Any]) -> list[Any]:
        return [copy.deepcopy(value, memo) for value in self]

    def __reduce__(self) -> tuple[Any, ...]:
        return list, ([*self],)


class Sealer:
    """Makes copies that nobody can write into, of arrays, and of dicts, lists and tuples at any depth.

    Attributes:
        is_open: Whether it has met something else, as a tensor. Of that it makes copies that can be written into, so
            each function needs copies of its own: `own`.
    """

    def __init__(self) -> None:
        self.is_open = False

    def seal(self, value: Any) -> Any:
        """A copy."""
        kind = type(value)
        if kind is ndarray and not value.dtype.hasobject:
            copied = value.copy()
            copied.setflags(False)  # by place: half of the time
            return copied.view()  # numpy makes no view of a read-only array writable again
        if kind in CONSTANT:
            return value
        if kind is dict and CONSTANT.issuperset(map(type, value.values())):  # mostly a loop less
            return ReadOnlyDict(value)
        if kind in MAPPINGS or kind is ReadOnlyDict:
            return ReadOnlyDict({key: self.seal(inner) for key, inner in value.items()})
        return self._seal_other(value)

    def own(self, step: tuple[Any, ...]) -> tuple[Any, ...]:
        """Copies of a sealed step, for one function."""
        return tuple(map(self.seal, step))

    def _seal_other(self, value: Any) -> Any:
        if isinstance(value, tuple):
            parts = map(self.seal, tuple.__iter__(value))  # an arm's step itself goes through its distances alone
            return value._make(parts) if hasattr(value, "_make") else tuple(parts)
        if type(value) is np.ndarray:  # of objects
            copied = np.empty_like(value)
            for place in np.ndindex(value.shape):
                copied[place] = self.seal(value[place])
            copied.setflags(write=False)
            return copied.view()
        if type(value) in (list, ReadOnlyList):
            return ReadOnlyList(map(self.seal, value))
        if isinstance(value, AS_THEY_ARE) and not isinstance(value, np.void):
            return value
        self.is_open = True
        return writable(value)


def writable(value: Any) -> Any:
    """A copy that can be written into, also of something sealed; what cannot be copied itself."""
    if isinstance(value, tuple) and hasattr(value, "_make"):  # a step: each of its parts for itself
        return value._make(map(writable, tuple.__iter__(value)))
    try:
        return copy.deepcopy(value)
    except Exception:  # whatever objects of users raise
        return value


Observation = TypeVar("Observation")
Action = TypeVar("Action")


@dataclass(frozen=True, eq=False)
class Walk:
    """One episode.

    Attributes:
        states: What the env returned, steps + 1 of them: the one before the first step first.
        actions: One for each step, at least one.
    """

    states: Sequence[Any]
    actions: Sequence[Any]


class KeepWalks(gymnasium.Wrapper[Observation, Action, Observation, Action]):
    """Keeps copies of states and actions, which nobody can write into; changes nothing of the env.

    Attributes:
        walks: Of all episodes since the wrapper was made.
    """

    def __init__(self, env: gymnasium.Env[Observation, Action]) -> None:
        super().__init__(env)
        self.walks: list[Walk] = []
        self._seal = Sealer().seal
        self._states: list[Any] = []
        self._actions: list[Any] = []

    def reset(self, **options: Any) -> tuple[Observation, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**options)
        self._states, self._actions = [self._seal(observation)], []
        return observation, info

    def step(self, action: Action) -> Any:
        """Take a step."""
        answer = self.env.step(action)
        self._states.append(self._seal(answer[0]))
        self._actions.append(self._seal(action))
        if len(self._actions) == 1:
            self.walks.append(Walk(self._states, self._actions))
        return answer
