"""Steps of a data set become columns of a log, whatever kind of file has them.

A reader finds arrays of consecutive steps and says where episodes end. What a column means is said here, for all.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints, Mask
from harness.errors import SchemaError, one_line
from harness.log import DatasetFacts, Log
from harness.record.dataset.labels import UNKNOWN, SuccessRule, parse_success

from .dataset import OPERATOR_KEYS, SUCCESS_KEYS, chosen_key

LABEL = "behaviour/success"
ENDS = ("terminated", "truncated")


class Steps(NamedTuple):
    """Consecutive steps, as a file has them.

    Attributes:
        table: By column what stands there, (steps, ...); an observation may lack that after the last step.
        episode: The number of each step's episode, (steps,).
        ends: Whether each step is the last of its episode, (steps,).
        where: They stand, for messages.
    """

    table: Mapping[str, NDArray[Any]]
    episode: Ints
    ends: Mask
    where: str


def nothing_told(number: int, key: str) -> Any:
    """What a data set tells of an episode under a key, that tells nothing beside its steps."""


@dataclass(frozen=True)
class Source:
    """What is known of a data set before its steps are read.

    Attributes:
        facts: What is told of it.
        rule: Where success stands; its key is empty where nothing says it.
        sees_last: Whether it tells what was seen after the last step of an episode.
    """

    facts: DatasetFacts
    rule: SuccessRule
    sees_last: bool

    @property
    def keys(self) -> dict[str, str]:
        """By column what the data set calls it, of those that tell of an episode; empty where nothing does."""
        return {LABEL: self.rule.key, "operator": self.facts.operator, "task": self.facts.task}

    def log(
        self, columns: Iterable[str], read: Callable[[tuple[str, ...]], Iterable[Mapping[str, NDArray[Any]]]]
    ) -> Log:
        """The log of these columns, and of those that follow from what is known."""
        more = {"seen": not self.sees_last, **self.keys}
        return Log(self.facts, (*columns, *(name for name, is_told in more.items() if is_told)), read)

    def columns(
        self, names: Iterable[str], steps: Steps, told: Callable[[int, str], Any] = nothing_told
    ) -> dict[str, NDArray[Any]]:
        """Columns of some steps.

        Args:
            names: Which.
            steps: These.
            told: What is told of an episode as a whole, by its number and a key; None if nothing is.
        """
        table = {**steps.table, "episode": steps.episode, "seen": ~steps.ends}
        return {name: self._column(name, table.get(name), steps, told) for name in names}

    def _column(
        self, name: str, values: NDArray[Any] | None, steps: Steps, told: Callable[[int, str], Any]
    ) -> NDArray[Any]:
        ends, noun = steps.ends, f"{steps.where}: {name}"
        if name == LABEL:
            noun = f"{steps.where}: {self.rule.key}"
            labels = self._labels(steps, told) if values is None else self.rule.of_steps(values, noun)
            return np.where(labels == UNKNOWN, np.nan, labels)
        if values is None and name in self.keys:
            return as_texts(steps.episode, lambda number: text_of(told(number, self.keys[name])))
        if values is None:
            if not name.startswith(("reward/", "info/")):
                raise SchemaError(f"{steps.where} has no {name} of each step, which others have")
            return np.full(len(ends), np.nan)
        if name.startswith("reward/") or name in ENDS:
            numbers = one_number(values, noun)
            # Some files say in each step that is a success that it is done, and the episode goes on.
            return np.asarray(ends & (numbers != 0.0)) if name in ENDS else numbers
        if name == "operator":
            return as_texts(values, str)
        return values if self.sees_last or not name.startswith("observation") else _where_seen(values, ends)

    def _labels(self, steps: Steps, told: Callable[[int, str], Any]) -> NDArray[np.int8]:
        """What is said of a whole episode, in its last step."""
        rule, labels = self.rule, np.full(len(steps.ends), UNKNOWN, np.int8)
        labels[steps.ends] = [
            rule.of_episode(told(number, rule.key), f"{self.facts.path}, episode {number}: {rule.key}")
            for number in steps.episode[steps.ends].tolist()
        ]
        return labels


def source_of(
    facts: DatasetFacts,
    success: str,
    cluster: str,
    keys: Collection[str],
    *,
    sees_last: bool,
    reward: str = "",
    usual: Iterable[str] = SUCCESS_KEYS,
) -> Source:
    """What is known of a data set, with what says whether an episode succeeded, and who made it.

    Args:
        facts: What else is told of it.
        success: What the user says of success: a key, perhaps with a threshold; else the first of the usual ones.
        cluster: The key that the user names, of who made an episode.
        keys: Those that there are.
        sees_last: See `Source`.
        reward: The one under which the data set's own reward stands.
        usual: Keys that mostly tell success.

    Raises:
        UsageError: A key that the user names is not there.
    """
    rule = parse_success(success)
    rule = replace(rule, key=chosen_key("--success", rule.key, keys, usual, facts.path))
    operator = chosen_key("--cluster", cluster, keys, OPERATOR_KEYS, facts.path)
    told_by = "recorded" if rule.key and rule.key == reward else ""
    found = replace(facts, success=rule.text, told_by=told_by, operator=operator)
    return Source(found, rule, sees_last)


def _where_seen(values: NDArray[Any], ends: Mask) -> NDArray[Any]:
    """What was seen after each step; NaN after the last one of an episode, or 0 where it is whole numbers."""
    seen = np.full((len(ends), *values.shape[1:]), np.nan if values.dtype.kind == "f" else 0, values.dtype)
    goes_on = np.flatnonzero(~ends)
    seen[goes_on] = values[goes_on]
    return seen


def as_texts(values: NDArray[Any], text: Callable[[Any], str]) -> NDArray[Any]:
    """A text for each step, by the first of its numbers."""
    found, place = np.unique(values.reshape(len(values), -1)[:, 0], return_inverse=True)
    return np.array([text(value) for value in found], object)[place]


def text_of(told: Any) -> str:
    """What an attribute, or an array of one value, says, on one line; empty of several values, and of none."""
    if told is None or np.size(told) != 1:
        return ""
    told = told.ravel()[0] if isinstance(told, np.ndarray) else told
    text = told.decode(errors="replace") if isinstance(told, bytes) else str(told)
    return one_line(text, 200)


def one_number(values: NDArray[Any], noun: str) -> Float:
    """A column that has one number of each step, (steps,).

    Raises:
        SchemaError: It has several.
    """
    if values.size != len(values):
        raise SchemaError(f"{noun} holds {values.size // max(1, len(values)):,} numbers a step, not one")
    return np.asarray(values, np.float64).reshape(len(values))
