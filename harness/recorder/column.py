"""A recorded number: what the user gave for it, and how it is measured in each env."""

import hashlib
import inspect
import textwrap
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, is_dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.log.log import is_countable, uncountable_text
from harness.record.recording.facts import (
    FILE_BEHAVIOUR,
    FILE_REWARD,
    MOST_NAMES,
    MOST_SOURCE,
    OWN_SOURCE,
    Source,
    term_column,
)
from harness.recorder.computing import may_wait, only_computes, reads_last
from harness.recorder.env_facts import plain
from harness.recorder.own_copies import own_copies
from harness.registry.choice import choose, parse
from harness.registry.members import missing_members
from harness.registry.plugin_module import file_behind
from harness.registry.registry import load_registry
from harness.reward import Steps
from harness.reward.forms import FAILED, FUNCTION, STEP, reward_class, takes_alone, takes_step
from harness.reward.given import ARM, OWN, Given, OfArm, Terms, arguments, opened
from harness.reward.terms import paid_of, require_same, sum_of


def are_numbers(values: Any) -> bool:
    """Whether what was told or returned can be counted with, all of it."""
    return bool(np.all(is_countable(values)))


def one_number(value: Any) -> float:
    """One number, as a float; it may be none that can be counted with.

    Raises:
        ValueError: It is of another shape.
        TypeError: It is no number.
    """
    if isinstance(value, float):  # what most envs pay: no array is made of it
        return float(value)
    array = np.asarray(value)
    if array.shape != ():
        raise ValueError(f"it is an array of shape {array.shape}, not one number")
    if array.dtype.kind not in "biuf":
        raise TypeError(f"it is {value!r}, no number")
    return float(array)


def as_number(value: Any) -> float:
    """The same, if it can be counted with.

    Raises:
        ValueError: It cannot, or is of another shape.
        TypeError: It is no number.
    """
    number = one_number(value)
    if not is_countable(number):
        raise ValueError(f"it is {uncountable_text(number)}")
    return number


@dataclass(eq=False)
class Column:
    """One recorded number.

    Attributes:
        name: Of the column, ``reward_v1``.
        noun: What messages call it, ``reward 'v1'``.
        given: What the user gave; terms that were given by name as one function, `harness.reward.given.Terms`.
        batched: Whether it is called once with the whole batch.
        measures: Copies of `given` by env, or the one of the batch; empty if it is no function.
        is_watched: Whether it might draw random numbers, or not return.
        waits: Whether it says the same when it is asked later.
        holds_env: Whether it has a memory and holds the env that is recorded, or a part of it.
        given_up: Whether it failed; it is NaN from then on.
        terms: Of a reward, the terms that it pays, in their order; None before it was asked.
        read: Makes a number of what was returned for one.
    """

    name: str
    noun: str
    given: Any
    batched: bool = False
    measures: list[Any] = field(default_factory=list)
    is_watched: bool = False
    waits: bool = False
    holds_env: bool = False
    given_up: bool = False
    terms: tuple[str, ...] | None = None
    read: Callable[[Any], float] = as_number

    @cached_property
    def takes_step(self) -> bool:
        """Whether its functions take a step, and not four arguments."""
        return takes_step(self.given)

    def arguments(self, step: Steps) -> tuple[Any, ...]:
        """What its functions are called with about a step."""
        return arguments(step, self.takes_step)

    def numbers(self, returned: Any) -> list[float]:
        """What was returned for a step: one number, and of a reward those of its terms.

        Raises:
            ValueError: One is of another shape, or not finite.
            TypeError: One is no number.
            UsageError: The terms are no terms, or others than before.
        """
        return self._numbers(returned, self.read)

    def batch(self, returned: Any, count: int) -> Float:
        """The same of what was returned for a step of each env: (num_envs, 1 + terms).

        Raises:
            ValueError: It is of another shape.
            UsageError: The terms are no terms, or others than before.
        """
        return np.column_stack(self._numbers(returned, partial(_of_shape, count)))

    def _numbers(self, returned: Any, read: Callable[[Any], Any]) -> list[Any]:
        if not (isinstance(returned, dict | tuple) and self.name.startswith(FILE_REWARD)):
            if self.terms:
                require_same(self.terms, {})
            return [read(returned)]
        paid = paid_of(returned)
        if not paid.terms:
            raise TypeError(f"it is {returned!r}, no number")
        if self.terms is None:
            self.terms = tuple(paid.terms)
        require_same(self.terms, paid.terms)
        terms = {name: _of_term(name, read, paid.terms[name]) for name in self.terms}
        return [read(sum_of(terms)), *terms.values()]

    @property
    def term_columns(self) -> list[str]:
        """What the columns of its terms are called."""
        return [term_column(self.name.removeprefix(FILE_REWARD), term) for term in self.terms or ()]

    @cached_property
    def reads_info(self) -> bool:
        """Whether its functions may look at what the env told."""
        return not self.is_own and (self.takes_step or not self.waits or reads_last(self.given))

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
        return self.name.startswith(FILE_BEHAVIOUR)

    @property
    def parts(self) -> Collection[Any]:
        """The functions that it is made of."""
        given = self.given.parts.values() if isinstance(self.given, Terms) else [self.given]
        return [part for part in given if not isinstance(part, str)]

    @property
    def remembers(self) -> bool:
        """Whether it has a memory, restarted with each episode."""
        return callable(getattr(self.given, "reset", None))


def made_columns(
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
        for prefix, noun, given_ones in ((FILE_REWARD, "reward", rewards), (FILE_BEHAVIOUR, "behaviour", behaviour))
        for name, given in given_ones.items()
    ]


def for_env(env: Any, given: Any) -> Any:
    """What was given for a reward, as it pays the steps of an env: in one of an arm also an arm's reward, or its name.

    A function of a step is an arm's where it can pay a step of an arm.
    """
    if not getattr(env, "metadata", {}).get(ARM):
        return given
    if isinstance(given, str):
        registry = load_registry()
        if parse(given)[0] in registry.names("rewards"):
            given = choose(registry, "rewards", given).build(registry, "rewards")
    elif takes_alone(given, STEP) and not getattr(reward_class(given), FAILED):
        given = reward_class(given)()
    return given if missing_members("rewards", given) else OfArm(given)


def _column(env: Any, prefix: str, noun: str, name: str, given: Given, copies: int, batched: bool) -> Column:
    if not isinstance(name, str) or not name.isprintable() or not 0 < len(name) <= MOST_NAMES:
        raise UsageError(f"{noun} {name!r}: a name is a text that can be printed, such as 'v1'")
    noun, given = f"{noun} {name!r}", for_env(env, given) if prefix == FILE_REWARD and not batched else given
    column = Column(f"{prefix}{name}", noun, opened(given, noun), batched)
    if isinstance(given, str):
        return column
    if isinstance(given, Mapping) and prefix != FILE_REWARD:
        raise UsageError(f"{noun} is {given!r}: a measure is one number, only rewards have terms")
    column.is_watched = not all(map(only_computes, column.parts))
    column.waits = not (column.is_watched or column.remembers) and all(map(may_wait, column.parts))
    if column.remembers:
        column.measures, column.holds_env = own_copies(column.given, column.noun, env, copies)
    else:
        column.measures = [column.given] * copies
    return column


def _of_term(name: str, read: Callable[[Any], Any], value: Any) -> Any:
    try:
        return read(value)
    except (TypeError, ValueError) as error:
        raise type(error)(f"its term '{name}': {error}") from None


def _of_shape(count: int, values: Any) -> Float:
    found = np.asarray(values, float)
    if found.shape != (count,):
        raise ValueError(f"it is an array of shape {found.shape}, not {(count,)}")
    return found


def source_of(given: Any) -> Source:
    """The code of a reward or a measure, and its SHA-256 where Python can tell it.

    Of one in a plugin file that is the code of the whole file, followed by that of the files beside it that it imports.
    """
    if isinstance(given, str):
        return Source("", OWN_SOURCE if given == OWN else f"info key {given!r}")
    if isinstance(given, Terms):
        parts = {name: source_of(part) for name, part in given.parts.items()}
        text = "".join(f"# {name}\n{part.text.rstrip()}\n" for name, part in parts.items())
        text += f"# with {plain(given.weights)}\n" if given.weights else ""
        is_known = all(part.sha256 or isinstance(given.parts[name], str) for name, part in parts.items())
        return _hashed(text) if is_known else Source("", text[:MOST_SOURCE])
    if isinstance(given, OfArm):
        given = given.reward
    if isinstance(given, partial):
        inner = source_of(given.func)
        return _hashed(f"{inner.text}# with {plain(given.args)} {plain(given.keywords)}\n") if inner.sha256 else inner
    code: Callable[..., Any] | type = given if inspect.isroutine(given) else getattr(given, FUNCTION, type(given))
    file = file_behind(code)
    try:
        text = textwrap.dedent(inspect.getsource(code)) if file is None else file.text
    except (OSError, TypeError):  # typed into a shell, or compiled
        return Source("", "")
    if is_dataclass(given):
        text += f"# with {plain(vars(given))}\n"
    return _hashed(text)


def _hashed(text: str) -> Source:
    return Source(hashlib.sha256(text.encode()).hexdigest(), text[:MOST_SOURCE])
