"""Spaces of any environment as a search has them: actions that are counted, or one row of numbers."""

import itertools
import math
from collections.abc import Callable
from copy import deepcopy
from typing import Any, NamedTuple, TypeAlias

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Tuple, flatten, unflatten

from harness import Float
from harness.errors import UsageError

from .moves import WIDEST

AnySpace: TypeAlias = gymnasium.Space[Any]
MOST_CHOICES = 256
"""Combinations of choices that are counted; where there are more, each part is some numbers of a row."""
FARTHEST = 1e9
"""Bounds that lie beyond it are none."""
Change: TypeAlias = Callable[[Any], Any]


class Coded(NamedTuple):
    """Actions of an environment as a search has them."""

    space: Box | Discrete
    """The space that is searched."""
    decoded: Change
    """From an action of that space to the environment's."""
    encoded: Change
    """The way back."""
    note: str = ""
    """What a reader of the answer has to know; empty for nothing."""


def coded(space: AnySpace, name: str) -> Coded:
    """How the actions of an environment are searched.

    Raises:
        UsageError: They have parts that are neither choices nor numbers.
    """
    if isinstance(space, Discrete):
        return Coded(deepcopy(space), int, lambda action: np.asarray(action).item())
    leaves = _leaves(space)
    if not all(isinstance(it, Box | MultiDiscrete | MultiBinary | Discrete) for it in leaves):
        raise UsageError(
            f"{name} cannot be searched: its actions are {space}. A search takes Discrete, MultiDiscrete, MultiBinary "
            "and Box, and a Dict or a Tuple of these"
        )
    if not any(isinstance(it, Box) for it in leaves):
        choices = [of for leaf in leaves for of in _choices(leaf)]
        if math.prod(map(len, choices)) <= MOST_CHOICES:
            rows = [np.concatenate(parts) for parts in itertools.product(*choices)]
            numbers = {row.tobytes(): number for number, row in enumerate(rows)}
            return Coded(
                Discrete(len(rows)),
                lambda number: unflatten(space, rows[number]),
                lambda action: numbers[np.asarray(flatten(space, action), float).tobytes()],
            )
    flat: Any = gymnasium.spaces.flatten_space(space)
    is_plain = isinstance(space, Box) and np.issubdtype(space.dtype, np.floating)
    kind = flat.dtype if is_plain else np.float64
    low, high = np.where(flat.low < -FARTHEST, -np.inf, flat.low), np.where(flat.high > FARTHEST, np.inf, flat.high)
    searched = Box(low.astype(kind), high.astype(kind), dtype=kind)
    note = "" if searched.is_bounded() else f"Nothing bounds its actions: {-WIDEST:g} to {WIDEST:g} is searched."
    if is_plain:
        return Coded(searched, lambda row: np.array(row, kind).reshape(space.shape), np.ravel, note)
    return Coded(
        searched,
        lambda row: unflatten(space, _snapped(leaves, row)),
        lambda action: np.asarray(flatten(space, action), kind),
        note,
    )


def _leaves(space: AnySpace) -> list[Any]:
    """Its parts, in the order in which they are flat."""
    if isinstance(space, Dict | Tuple):
        parts = space.spaces.values() if isinstance(space, Dict) else space.spaces
        return [leaf for part in parts for leaf in _leaves(part)]
    return [space]


def _choices(leaf: Any) -> list[Float]:
    """What each number of a part may be in a flat row, (choices, width): a bit itself, else a row that is 1 once."""
    if isinstance(leaf, MultiBinary):
        return [np.array([[0.0], [1.0]])] * math.prod(leaf.shape)
    return [np.eye(int(count)) for count in ([leaf.n] if isinstance(leaf, Discrete) else leaf.nvec.ravel())]


def _snapped(leaves: list[Any], row: Float) -> Float:
    """A flat row of the space that is nearest to numbers: of choices the largest counts."""
    parts, at = list[Any](), 0
    for leaf in leaves:
        if isinstance(leaf, Box):
            part = row[at : at + math.prod(leaf.shape)]
            is_whole = not np.issubdtype(leaf.dtype, np.floating)
            parts.append(np.clip(np.rint(part), leaf.low.ravel(), leaf.high.ravel()) if is_whole else part)
            at += len(part)
        else:
            for choices in _choices(leaf):
                part = row[at : at + choices.shape[1]]
                parts.append(part > 0.5 if len(part) == 1 else choices[part.argmax()])
                at += len(part)
    return np.concatenate(parts, dtype=np.float64)
