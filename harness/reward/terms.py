"""What a reward returned, as numbers: the pay of steps, and the terms that it is the sum of; and what it reads.

A reward gives its terms as a dict, or as (total, dict). A total, also one under the key ``total``, has to be their sum.
What it reads is found by one call on made-up steps that note what they are asked for.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import chdir
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from harness.arrays import read_only
from harness.errors import HarnessError, UsageError, one_line
from harness.reward.reward import Array, Carry, Reward
from harness.reward.steps import BEFORE, ENDS, MissingField, Steps, map_steps, step_between

TOTAL = "total"
"""The key of a dict of terms under which their sum may stand."""
LONGEST_NAME = 60
"""Characters of the name of a term."""
NO_TERMS: Mapping[str, Array] = MappingProxyType({})


class Paid(NamedTuple):
    """What steps are paid."""

    total: Array
    """What is paid, (num_envs,). Where there are terms it is their sum, in their order."""
    terms: Mapping[str, Array] = NO_TERMS
    """By name, shape (num_envs,) each; none of a reward that returned a plain array."""


@dataclass(frozen=True)
class Unpaid:
    """The reward that pays nothing: what its env pays are the event terms alone."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, steps: Steps) -> tuple[Carry, Array]:
        """Zeros, (num_envs,)."""
        return carry, 0.0 * steps.distance


def pay(reward: Reward, carry: Carry, steps: Steps) -> tuple[Carry, Paid]:
    """What a reward remembers after steps, and what they are paid.

    Args:
        reward: Any.
        carry: What it remembers before them, (num_envs, ...).
        steps: One step of each env, (num_envs, ...) each field.

    Returns:
        The carry, and the pay and its terms, (num_envs,) each.

    Raises:
        UsageError: Its terms are no terms, or their total is not their sum.
    """
    after, returned = reward(carry, steps)
    return after, paid_of(returned)


def paid_of(returned: Any) -> Paid:
    """What a reward returned: an array or a number, a dict of terms, or (total, dict of terms).

    Raises:
        UsageError: The terms are no terms, or the total is not their sum.
    """
    kind = type(returned)  # most steps are paid by an array or a dict: what is quick to see comes first
    if kind is np.ndarray:
        return Paid(returned)
    if kind is dict or isinstance(returned, Mapping):
        return _summed(returned, None)
    if kind is Paid:
        return cast(Paid, returned)
    if isinstance(returned, tuple) and len(returned) == 2 and isinstance(returned[1], Mapping):
        return _summed(returned[1], returned[0])
    return Paid(returned)


def _summed(terms: Mapping[str, Any], total: Any) -> Paid:
    if total is None and TOTAL in terms and len(terms) > 1:
        total, terms = terms[TOTAL], {name: value for name, value in terms.items() if name != TOTAL}
    _require_names(tuple(terms))
    found: Any = sum_of(terms)
    if total is not None and not _is_sum(total, found, terms):
        raise UsageError(
            f"The total {_first(total)} is not the sum of its terms, {_first(found)} "
            f"({', '.join(f'{name} {_first(value)}' for name, value in terms.items())}). Return terms that add up to "
            "it, or the total alone"
        )
    shape = getattr(found, "shape", ())
    for value in terms.values():
        if getattr(value, "shape", ()) != shape:  # a number is that of every env
            return Paid(found, {name: value + 0.0 * found for name, value in terms.items()})
    return Paid(found, terms)


def require_one_each(paid: Paid, count: int) -> None:
    """See that a reward pays one number an arm.

    Args:
        paid: What it pays.
        count: How many arms there are.

    Raises:
        UsageError: It pays something else, such as a number for each joint, or nothing.
    """
    shape = np.shape(paid.total)
    if shape != (count,):
        told = f"values of shape {shape}" if shape else repr(paid.total)
        raise UsageError(f"It returned {told} for {count} arms: {one_each(count)}")


def one_each(count: int) -> str:
    """What a reward is to return for so many arms."""
    return f"return one number an arm, an array of shape ({count},); `.sum(-1)` adds up the joints of each"


def sum_of(terms: Mapping[str, Array]) -> Array:
    """The sum of terms in their order: the same to the last bit wherever it is computed."""
    total: Array = 0.0  # to begin with: two masks are not added as numbers
    for value in terms.values():
        total = total + value
    return total


def paid_twice(terms: Mapping[str, Any]) -> str:
    """The term that is the sum of all others in every step, as a total beside its parts; empty if there is none.

    Args:
        terms: By name, what each paid, (steps,). Those that paid nothing do not count, and what never changes is no
            sum. Two that pay alike may do so by chance.
    """
    paid = {name: np.asarray(values, float) for name, values in terms.items()}
    paid = {name: values for name, values in paid.items() if values.any()}
    total = sum(paid.values())
    for name, values in paid.items() if len(paid) > 2 else ():
        if values.min() < values.max() and np.allclose(total - values, values, rtol=1e-5, atol=1e-9):
            return name
    return ""


def paid_twice_text(name: str, steps: int) -> str:
    """The same in a sentence without its end."""
    return f"the term '{name}' is the sum of all others in all {steps:,} steps, so that they are paid twice"


def require_same(expected: tuple[str, ...], terms: Mapping[str, Array]) -> None:
    """See that a reward pays the terms that it paid before.

    Raises:
        UsageError: It pays others.
    """
    if tuple(terms) != expected and terms.keys() != set(expected):
        raise UsageError(
            f"It paid the terms {', '.join(expected) or 'none'} at first, and now {', '.join(terms) or 'none'}: return "
            "every term in every step, 0 where it pays nothing"
        )


@lru_cache(maxsize=256)  # every step has the same ones
def _require_names(terms: tuple[Any, ...]) -> None:
    if not terms:
        raise UsageError("A dict of terms is empty: return at least one term, {'reach': -step.distance}")
    for name in terms:
        is_name = isinstance(name, str) and 0 < len(name) <= LONGEST_NAME and name.isprintable()
        if not is_name or any(sign in name for sign in "/,:=()") or name.strip() != name:
            raise UsageError(
                f"{name!r} is no name of a term: write letters, digits, '_', '-' or '.', at most {LONGEST_NAME}"
            )


def _is_sum(total: Any, found: Any, terms: Mapping[str, Any]) -> bool:
    """Whether a total is the sum up to what another order of adding, or single precision, may change.

    Terms that cancel out leave an error of their size, which may be large beside their sum. An array of another
    library, as one that JAX compiles with, has no numbers to look at.
    """
    are_floats = isinstance(total, float) and isinstance(found, float)  # else a call of NumPy takes 30 microseconds
    if are_floats and (abs(total - found) <= 1e-6 + 1e-5 * abs(found) or (math.isnan(total) and math.isnan(found))):
        return True
    if any(hasattr(it, "__array_namespace__") and not isinstance(it, np.ndarray | np.generic) for it in (total, found)):
        return True
    told, summed = np.asarray(total, float), np.asarray(found, float)
    rounding = 1e-6 * sum(np.abs(np.asarray(value, float)) for value in terms.values())
    return bool(np.isclose(told, summed, rtol=1e-5, atol=1e-6 + rounding, equal_nan=True).all())


def _first(value: Any) -> str:
    """The first number of a value, for messages."""
    numbers = np.asarray(value, float).ravel()
    return f"{numbers[0]:.6g}" if numbers.size else "nothing"


ROWS = 2
Answer = TypeVar("Answer")
SIZES = (6, 7, 8, 5, 4, 3, 2, 9, 10, 12)
"""Numbers of joints that are tried, where nothing says which arm a reward is for."""


@dataclass(frozen=True)
class Needs:
    """What one call of a reward showed.

    Attributes:
        fields: Names of the fields that it read, ``qvel`` or ``before.action``, sorted.
        terms: Names of the terms that it paid, in their order; none of a reward that pays a plain number.
    """

    fields: tuple[str, ...] = ()
    terms: tuple[str, ...] = ()


class Noting:
    """Steps that note which of their fields are read."""

    def __init__(self, steps: Steps, noted: set[str], within: str = "") -> None:
        self._steps, self._noted, self._within = steps, noted, within

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            self._note_all()
            return getattr(self._steps, name)
        try:
            value = getattr(self._steps, name)
        except MissingField:
            raise MissingField(f"{self._within}{name}", self._steps._fields, "A step of an arm") from None
        if name == BEFORE and not self._within:
            return Noting(value, self._noted, f"{BEFORE}.")
        self._noted.add(f"{self._within}{name}")
        return value

    def __iter__(self) -> Iterator[Any]:
        values = tuple(self._steps)  # of an arm's step the distances alone, which come first
        self._noted.update(f"{self._within}{name}" for name in self._steps._fields[: len(values)] if name != BEFORE)
        return iter(values)

    def __getitem__(self, index: Any) -> Any:
        self._note_all()
        return self._steps[index]

    def __len__(self) -> int:
        return len(self._steps)

    def _note_all(self) -> None:
        self._noted.update(f"{self._within}{name}" for name in self._steps._fields if name != BEFORE)


def needs_of(reward: Reward, dof: int | None = None, action_size: int | None = None) -> Needs:
    """What a reward of an arm reads, and the terms that it pays.

    Args:
        reward: It is called once, on `ROWS` made-up steps.
        dof: Joints of the arm; None tries some numbers of them.
        action_size: Length of an action; None takes `dof`.

    Raises:
        UsageError: The reward fails, or reads what a step of an arm does not have.
    """
    fields, paid = of_made_up(partial(call_noted, reward), dof, action_size)
    declared = {str(name) for name in getattr(reward, "needs", ())}
    return Needs(tuple(sorted(fields | declared)), tuple(paid.terms))


def of_made_up(call: Callable[[Steps], Answer], dof: int | None = None, action_size: int | None = None) -> Answer:
    """What a function answers to made-up steps; see `needs_of`.

    Raises:
        UsageError: It fails with every number of joints, or reads what a step of an arm does not have.
    """
    failed = list[Exception]()
    for size in SIZES if dof is None else (dof,):
        try:
            with chdir("."):  # a reward may change it
                return call(made_up(size, action_size or size))
        except HarnessError:
            raise
        except Exception as error:  # whatever a stranger's function raises
            failed.append(error)
    raise UsageError(f"It fails on made-up steps of {ROWS} arms: {one_line(failed[0])}") from failed[0]


def shown_needs(reward: Reward, dof: int | None = None, action_size: int | None = None) -> Needs | None:
    """The same as `needs_of`; None of a reward that fails on made-up steps, which its first real step will say.

    So does code that JAX compiled, which takes arrays alone and not what notes that they are read.

    Raises:
        MissingField: It reads what a step of an arm does not have.
    """
    try:
        return needs_of(reward, dof, action_size)
    except MissingField:
        raise
    except UsageError:
        return None


def call_noted(reward: Reward, steps: Steps) -> tuple[set[str], Paid]:
    """Call a reward once on steps; returns what it read, and what it paid."""
    noted: set[str] = set()
    with np.errstate(all="ignore"):
        carry = reward.initial_carry(np.array(steps.begin_distance))
        paid = pay(reward, carry, Noting(steps, noted))[1]
    require_one_each(paid, len(steps.begin_distance))
    return noted, paid


@cache
def made_up(dof: int, action_size: int) -> Steps:
    """`ROWS` steps of an arm, every field with plausible numbers: one step nears the target, one leaves it."""
    rng = np.random.default_rng(0)
    now = _arm(rng, dof, action_size, np.array([0.3, 0.45]))
    before = {**_arm(rng, dof, action_size, np.array([0.4, 0.4])), "target": now["target"]}
    steps = step_between(before, now, np.array([0.5, 0.5]), before["distance"], np.array([3.0, 4.0]))
    return map_steps(read_only, steps)  # kept for the next reward, and an env's cannot be written into either


def _arm(rng: np.random.Generator, dof: int, action_size: int, distance: Any) -> dict[str, Any]:
    return {
        "distance": distance,
        "qpos": rng.uniform(-0.5, 0.5, (ROWS, dof)),
        "qvel": rng.uniform(-0.5, 0.5, (ROWS, dof)),
        "action": rng.uniform(-1.0, 1.0, (ROWS, action_size)),
        "end_effector": rng.uniform(0.1, 0.5, (ROWS, 3)),
        "target": rng.uniform(0.1, 0.5, (ROWS, 3)),
        **dict.fromkeys(("ground", *ENDS), np.zeros(ROWS, bool)),
    }
