"""A recorded number: what the user gave for it, and how it is measured in each env."""

import functools
import hashlib
import inspect
import math
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, is_dataclass
from typing import Any, Protocol

import numpy as np

from harness.errors import UsageError
from harness.record.recording.facts import BEHAVIOUR, MOST_NAMES, MOST_SOURCE, OWN_SOURCE, REWARD, Source
from harness.recorder.computing import only_computes
from harness.recorder.env_facts import plain
from harness.recorder.own_copies import own_copies
from harness.registry.plugin_module import file_behind

OWN = "own"
"""What the env itself pays."""
ARGUMENTS = "(observation, action, next_observation, info)"


class Measure(Protocol):
    """A reward, or a measure of behaviour, of one step. It depends on nothing else, and can write into nothing of it.

    One with a memory is an object that also has ``reset()``, which is called when an episode starts. Each env of a
    batch has a copy of its own, see `own_copies`.
    """

    def __call__(self, observation: Any, action: Any, next_observation: Any, info: Any, /) -> Any:
        """A finite number for the step that led from `observation` to `next_observation`."""


Given = Measure | str
"""A function, a key of ``info``, or ``"own"``."""


@dataclass
class Column:
    """One recorded number.

    Attributes:
        name: Of the column, ``reward_v1``.
        noun: What messages call it, ``reward 'v1'``.
        given: What the user gave.
        batched: Whether it is called once with the whole batch.
        measures: Copies of `given` by env, or the one of the batch; empty if it is no function.
        is_watched: Whether it might draw random numbers, or not return.
        holds_env: Whether it has a memory and holds the env that is recorded, or a part of it.
        given_up: Whether it failed; it is NaN from then on.
    """

    name: str
    noun: str
    given: Given
    batched: bool = False
    measures: list[Measure] = field(default_factory=list)
    is_watched: bool = False
    holds_env: bool = False
    given_up: bool = False

    @property
    def is_own(self) -> bool:
        """Whether it is what the env pays."""
        return isinstance(self.given, str) and self.given == OWN

    @property
    def key(self) -> str | None:
        """The key of ``info``, if it is read there."""
        return self.given if isinstance(self.given, str) and self.given != OWN else None

    @property
    def may_be_untold(self) -> bool:
        """Whether ``info`` may lack it in steps that do not end an episode."""
        return self.name.startswith(BEHAVIOUR)

    @property
    def remembers(self) -> bool:
        """Whether it has a memory, restarted with each episode."""
        return callable(getattr(self.given, "reset", None))


def columns_of(
    env: Any, rewards: Mapping[str, Given], behaviour: Mapping[str, Given], num_envs: int, batched: frozenset[str]
) -> list[Column]:
    """A column for each reward, then for each measure of behaviour.

    Args:
        env: What is measured, a single env or a batch.
        rewards: By name.
        behaviour: By name.
        num_envs: How many envs are measured.
        batched: Names of those that are called once with the whole batch.

    Raises:
        UsageError: A name or what stands under it cannot be used.
    """
    unknown = batched - {*rewards, *behaviour}
    if unknown:
        raise UsageError(f"batched={sorted(batched)} names {sorted(unknown)[0]!r}, which is no reward and no behaviour")
    return [
        _column(env, prefix, noun, name, given, 1 if name in batched else num_envs, name in batched)
        for prefix, noun, given_ones in ((REWARD, "reward", rewards), (BEHAVIOUR, "behaviour", behaviour))
        for name, given in given_ones.items()
    ]


def _column(env: Any, prefix: str, noun: str, name: str, given: Given, copies: int, batched: bool) -> Column:
    if not isinstance(name, str) or not name.isprintable() or not 0 < len(name) <= MOST_NAMES:
        raise UsageError(f"{noun} {name!r}: a name is a text that can be printed, such as 'v1'")
    column = Column(f"{prefix}{name}", f"{noun} {name!r}", given, batched)
    if isinstance(given, str):
        return column
    _require_callable(column)
    column.is_watched = not only_computes(given)
    if column.remembers:
        column.measures, column.holds_env = own_copies(given, column.noun, env, copies)
    else:
        column.measures = [given] * copies
    return column


def _require_callable(column: Column) -> None:
    given = column.given
    if not callable(given) or isinstance(given, type):
        raise UsageError(
            f"{column.noun} is {given!r}: it has to be a function of {ARGUMENTS}, a key of info in quotes, or {OWN!r}"
        )
    try:
        signature = inspect.signature(given)
    except (TypeError, ValueError):
        return  # a built-in: Python does not know its arguments, and calls will tell
    try:
        signature.bind(None, None, None, None)
    except TypeError:
        raise UsageError(f"{column.noun} takes {signature}: it has to take {ARGUMENTS}") from None


def as_number(value: object) -> float:
    """One number, as a float.

    Raises:
        ValueError: It is of another shape, or not finite.
        TypeError: It is no number.
    """
    if isinstance(value, np.float64):  # what most envs pay: no array is made of it
        return as_number(value.item())
    if type(value) is not float:
        array = np.asarray(value)
        if array.shape != ():
            raise ValueError(f"it is an array of shape {array.shape}, not one number")
        if array.dtype.kind not in "biuf":
            raise TypeError(f"it is {value!r}, no number")
        return as_number(float(array))
    if not math.isfinite(value):
        raise ValueError(f"it is {value}")
    return value


def source_of(given: Given) -> Source:
    """The code of a reward or a measure, and its SHA-256 where Python can tell it.

    Of one in a plugin file that is the code of the whole file, followed by that of the files beside it that it imports.
    """
    if isinstance(given, str):
        return Source("", OWN_SOURCE if given == OWN else f"info key {given!r}")
    if isinstance(given, functools.partial):
        inner = source_of(given.func)
        return _hashed(f"{inner.text}# with {plain(given.args)} {plain(given.keywords)}\n") if inner.sha256 else inner
    code: Callable[..., Any] | type = given if inspect.isroutine(given) else type(given)
    file = file_behind(code)
    try:
        text = textwrap.dedent(inspect.getsource(code)) if file is None else file.text
    except (OSError, TypeError):  # typed into a shell, or compiled
        return Source("", "")
    if is_dataclass(code):
        text += f"# with {plain(vars(given))}\n"
    return _hashed(text)


def _hashed(text: str) -> Source:
    return Source(hashlib.sha256(text.encode()).hexdigest(), text[:MOST_SOURCE])


class Untold(KeyError):
    """``info`` does not have a key."""

    def __str__(self) -> str:
        return f"info has no {self.args[0]!r}; it has {', '.join(map(repr, self.args[1])) or 'nothing'}"
