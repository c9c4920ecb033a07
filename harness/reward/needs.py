"""What a reward reads and what terms it pays, found by one call on made-up steps that note what they are asked for."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeVar

import numpy as np

from harness.arrays import read_only
from harness.errors import HarnessError, UsageError, one_line
from harness.reward.reward import Reward
from harness.reward.steps import BEFORE, MissingField, Steps, map_steps, step_between
from harness.reward.terms import Paid, pay, require_one_each

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
        "ground": np.array([False, False]),
    }
