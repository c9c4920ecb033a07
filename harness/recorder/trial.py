"""The first steps of a recording, about which every function is asked more than once.

One that remembers something outside of what it is given is found so: it answers otherwise when it is asked about the
same step again, at once, or after the steps that followed.
"""

import copy
import math
import pickle
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from harness.errors import Unscored, UsageError, sentence
from harness.record.recording.facts import FILE_REWARD
from harness.recorder.column import Column, one_number
from harness.recorder.computing import only_computes
from harness.recorder.guard import Asking, Guard, Raised, said
from harness.recorder.limit import LONGEST
from harness.recorder.own_copies import as_defined, uses_parts_of
from harness.reward import Steps
from harness.reward.given import Given, Untold, opened

FIRST_STEPS = 100
RESTART = "reset"
"""In place of an answer: the function was told that an episode starts."""
SHARED = "Its copies share a memory, as an attribute of the class. Keep it in self"
WHAT_IS_WRONG = (
    "It remembers something from call to call, as a global variable does, or draws by chance. "
    "Write a class with reset() that keeps in self what it remembers and sets it anew in reset()"
)


@dataclass(frozen=True)
class Finding:
    """What was found of a function.

    Attributes:
        column: Of it.
        told: A line.
        is_wrong: Whether its numbers are wrong, so that it is given up; else it is only told.
    """

    column: Column
    told: str
    is_wrong: bool = True


@dataclass
class Trial:
    """Asks again.

    Attributes:
        env: What is recorded.
        guard: Asks.
        has_looked: Whether every function was asked again about an episode.
    """

    env: Any
    guard: Guard
    has_looked: bool = False
    _noted: dict[str, list[tuple[Asking, Any]]] = field(default_factory=dict)
    _begun: dict[str, Any] = field(default_factory=dict)

    def begin(self, columns: Sequence[Column]) -> None:
        """Note what all are like when the first episode starts, those with a memory after their ``reset()``."""
        for column in columns:
            if column.measures and not column.holds_env and column.name not in self._begun:
                self._begun[column.name] = _copy(column) if column.remembers else as_defined(column.measures[0])

    def restarted(self, column: Column, given: Asking) -> None:
        """Note that a function with a memory was told that another episode starts.

        Args:
            column: Of the function.
            given: What its ``reset`` was given.
        """
        if noted := self._noted.get(column.name):
            noted.append((given, RESTART))

    def note(self, column: Column, step: Asking, answer: Any, drew: bool) -> Finding | None:
        """Take a step and the function's answer to it; one without ``reset()`` is asked at once again.

        Args:
            column: Of the function.
            step: What it was given.
            answer: A number, or an array of one for each env.
            drew: Whether it drew from a generator of all: then it answers otherwise, which is told elsewhere.
        """
        noted = self._noted.setdefault(column.name, [])
        if drew:
            answer = math.nan  # not asked again
        elif not column.remembers:
            again = self._total(column, column.measures[0], step)
            if not _alike(answer, again):
                return Finding(column, f"{_other(answer, again)} about the same step at once. {WHAT_IS_WRONG}")
        noted.append((step, answer))
        return None

    def _total(self, column: Column, function: Any, step: Asking) -> Any:
        """What a function says of a step; of terms the sum, as it is recorded."""
        (found,) = self.guard.ask([function], [step])
        if not isinstance(found, dict | tuple):
            return found
        try:
            return column.batch(found, self.env.num_envs)[:, 0] if column.batched else column.numbers(found)[0]
        except (TypeError, ValueError, UsageError) as error:
            return Raised(error)

    def look(self, columns: Sequence[Column]) -> Iterator[Finding]:
        """Ask all that were not given up about the noted steps again, from the first one on. That ends the trial."""
        self.has_looked = True
        for column in columns:
            if column.given_up or not self._noted.get(column.name):
                continue
            found = self._of_memory(column) if column.remembers else self._of_function(column)
            if found is not None:
                yield found
        self.guard.longest = LONGEST

    def look_at_last(self, columns: Sequence[Column]) -> Iterator[Finding]:
        """Ask those without ``reset()`` again when all is over: what they remember may show late."""
        for found in self.look([column for column in columns if not column.remembers]):
            yield replace(found, is_wrong=False)

    def _of_function(self, column: Column) -> Finding | None:
        apart = self._first_apart(column, column.measures[0]) or self._apart_backwards(column)
        if not apart or uses_parts_of(column.given, self.env):  # the env stands elsewhere now
            return None
        return Finding(column, f"{apart}. {WHAT_IS_WRONG}")

    def _apart_backwards(self, column: Column) -> str:
        """The same of a function as it was at the beginning, from the last step on: it may remember the first one."""
        begun: Any = self._begun.get(column.name)
        noted = self._noted[column.name]
        for number, (step, answer) in reversed([*enumerate(noted)] if begun is not None else []):
            again = self._total(column, begun, step)
            if not isinstance(again, Raised) and not _alike(answer, again):
                return f"{_other(answer, again)} about step {number} before others"
        return ""

    def _of_memory(self, column: Column) -> Finding | None:
        begun = self._begun.get(column.name)
        one, other = (None, None) if begun is None else (_copy(column), _copy(column))
        if one is None or other is None or not self._restart(one, other, column=column):
            return None  # it holds the env, or cannot be copied
        has_grown = _has_grown(begun, one)
        apart = self._first_apart(column, one)
        if apart and _is_surely_anew(begun, one) and not uses_parts_of(type(column.given).__call__, self.env):
            return Finding(column, f"{apart}, though reset() has made it as it was. {SHARED}")
        if apart or has_grown:
            late = "" if apart else " (its numbers have not shown it so far)"
            told = (
                f"it remembers something beyond reset(){late}, which every env has for itself and an evaluation "
                "starts anew. "
                "To hand it on, give evaluate_policy `env.functions[NAME]` of the trained env as this reward"
            )
            return Finding(column, told, is_wrong=False)
        self._restart(one, column=column)
        apart = self._first_apart(column, one, other)
        if apart:
            return Finding(column, f"{apart}. {SHARED}")
        return None

    def _restart(self, *copies: Any, column: Column) -> bool:
        """Whether they could be reset."""
        given = (np.ones(self.env.num_envs, bool),) if column.batched else ()
        return not any(
            isinstance(it, Raised) for it in self.guard.ask([it.reset for it in copies], [given] * len(copies))
        )

    def _first_apart(self, column: Column, function: Any, between: Any = None) -> str:
        """The first step to which a function answers otherwise, in words.

        Args:
            column: Of the function.
            function: It, or a copy of it that was reset.
            between: Another copy, which is asked about other steps in between.
        """
        noted = self._noted[column.name]
        steps = [step for step, answer in noted if answer is not RESTART]
        others = reversed(steps)
        number = -1
        for step, answer in noted:
            if answer is RESTART:
                self.guard.ask([function.reset], [step])
                continue
            number += 1
            if between is not None:
                self.guard.ask([between], [next(others)])
            again = self._total(column, function, step)
            if not _alike(answer, again):
                return f"{_other(answer, again)} about step {number} after others"
        return ""


def _has_grown(begun: Any, restarted: Any) -> bool:
    """Whether a count or a list has grown, as that of a curriculum, whose numbers may show it only later.

    Anything else may be left from the last episode, and be set anew by the first step of the next one.
    """
    before, after = (getattr(it, "__dict__", {}) for it in (begun, restarted))
    return any(_size(after[name]) > _size(before[name]) for name in before.keys() & after.keys())


def _size(value: Any) -> int:
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        return int(value)
    return len(value) if isinstance(value, list | dict | set | deque) else 0


def _is_surely_anew(begun: Any, restarted: Any) -> bool:
    """Whether what two copies hold is the same to the last bit, so that another answer comes from elsewhere."""
    try:
        return pickle.dumps(vars(begun)) == pickle.dumps(vars(restarted))
    except Exception:  # whatever objects of users raise
        return False


def _copy(column: Column) -> Any:
    try:
        return copy.deepcopy(column.measures[0])
    except Exception:  # whatever objects of users raise
        return None


def _other(answer: Any, again: Any) -> str:
    told = f"raised {type(again.error).__name__}" if isinstance(again, Raised) else f"said {_short(again)}"
    return f"it said {_short(answer)}, and {told} when it was asked"


def _short(answer: Any) -> str:
    try:
        return f"{float(answer):.9g}"
    except (TypeError, ValueError):
        return "something else"


def _alike(answer: Any, again: Any) -> bool:
    """Whether an answer is the same number as before, to within what the same computation may differ."""
    known = ~np.isnan(answer)  # the others were not to be compared
    try:
        return bool(np.allclose(np.asarray(again, float)[known], np.asarray(answer)[known], rtol=1e-6, atol=1e-9))
    except (TypeError, ValueError, IndexError):
        return False


class Guarded:
    """A reward that is asked again in its first steps, for what pays steps that were taken long ago."""

    def __init__(self, given: Given, name: str) -> None:
        """Ask nothing yet.

        Args:
            given: A function, or terms by name.
            name: Of the reward.

        Raises:
            UsageError: It is no function.
        """
        noun = f"reward '{name}'"
        self._column = Column(f"{FILE_REWARD}{name}", noun, opened(given, noun), read=one_number)
        self._column.measures = [self._column.given]
        self._guard, self._is_watched = Guard(), not all(map(only_computes, self._column.parts))
        self._trial, self._steps = Trial(None, self._guard), 0
        self._trial.begin([self._column] if not self._column.remembers else [])

    def reset(self) -> None:
        """Tell it that an episode begins, if it remembers something."""
        if self._column.remembers:
            self._guard.answer(self._column.given.reset, ())

    @property
    def terms(self) -> tuple[str, ...]:
        """The terms that it has paid so far; none of a reward that pays a plain number."""
        return self._column.terms or ()

    def __call__(self, steps: Sequence[Steps]) -> list[list[float]]:
        """What the reward pays for each step, then each of its terms.

        Raises:
            UsageError: It remembers something that nobody restarts.
            Unscored: It reads what a step does not have, or its terms are no terms.
            Exception: Whatever it raises.
        """
        asked = list(map(self._column.arguments, steps))
        found = self._guard.ask([self._column.given] * len(asked), asked, is_watched=self._is_watched)
        drew = self._guard.drew.keys()
        return [self._numbers(*it, place in drew) for place, it in enumerate(zip(asked, found, strict=True))]

    def _numbers(self, asking: Asking, answer: Any, drew: bool) -> list[float]:
        try:
            numbers = self._column.numbers(said(answer))
        except (UsageError, Untold) as error:
            raise Unscored(str(error)) from error
        if self._steps < FIRST_STEPS and not self._column.remembers:
            self._steps += 1
            found = self._trial.note(self._column, asking, numbers[0], drew)
            if self._steps == FIRST_STEPS:
                found = found or next(self._trial.look([self._column]), None)
            if found is not None:
                raise UsageError(f"{sentence(self._column.noun)}: {found.told}")
        return numbers
