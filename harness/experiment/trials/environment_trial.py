"""One episode of random actions in an environment: every reward, every measure and every key of info is asked."""

import time
from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from contextlib import closing
from itertools import islice
from typing import Any, TypeAlias

import numpy as np

from harness.environment import AnyEnv, Environment
from harness.errors import one_line
from harness.experiment.environments.plan import RandomStep, columns_of, random_steps, value_of
from harness.experiment.trials.tried import Fault, Tried, error_text, fault_of
from harness.recorder.column import Column, made_columns
from harness.recorder.guard import Guard
from harness.recorder.trial import FIRST_STEPS, Finding, Trial
from harness.registry.choice import Choice, Registry
from harness.registry.spec import unknown_name
from harness.reward.given import Untold

MOST_STEPS, MOST_SECONDS = 2_000, 10.0
"""The most steps that are tried, and the most time that they take."""
MOST_AGAIN = 1.0
"""The time that one function may take, [s], and still be asked again: the trial is no place to wait."""
COMPARED = 100
"""Steps that are taken again, to see whether the seed decides them."""
UNSEEDED = (
    "an env that is reset with the same seed, and given the same actions, answers otherwise. Policies will not meet "
    "the same starts, and no training can be repeated. An env has to draw everything random from its np_random, which "
    "reset(seed) seeds"
)
TOUCHED = "its episodes go on otherwise when rewards and measures are asked: they should only look on"

Tell: TypeAlias = Callable[[str], None]
"""A function that is told the column that is asked next, ``reward_calm``; an empty text: the env itself is at work."""
Rows: TypeAlias = list[list[float]]


def try_environment(
    task: Choice, registry: Registry, without: Collection[str], tell: Tell, rewards: Sequence[Choice] = ()
) -> Tried:
    """Try everything that is recorded of an environment.

    Args:
        task: The environment.
        registry: The plugins.
        without: Names of columns that are not asked.
        tell: Told what is asked next.
        rewards: To have beside those that it always has.
    """
    environment: Environment = task.build(registry, "environments")
    trial = _Trial(rewards, without, tell)
    try:
        notes = trial.run(environment, registry)
    except Exception as error:  # whatever people's envs raise; those of rewards are caught
        notes = [f"the environment fails: {error_text(error)}"]
    return Tried(tuple(trial.faults), tuple(f"{task.label}: {note}" for note in notes))


class _Trial:
    """Asks columns, each until it fails."""

    def __init__(self, rewards: Sequence[Choice], without: Collection[str], tell: Tell) -> None:
        self._rewards, self._without, self._tell = rewards, without, tell
        self.faults: list[Fault] = []
        self._columns: list[Column] = []
        self._seen: dict[str, None] = {}
        self._missing: set[str] = set()
        self._spent: dict[str, float] = defaultdict(float)
        self._steps, self._has_ended = 0, False

    def run(self, environment: Environment, registry: Registry) -> list[str]:
        """Try all of it; returns what there is to know beside the faults."""
        self._tell("")
        with closing(environment.make()) as env:
            found = columns_of(environment, env, registry, self._rewards)
            made = made_columns(env, found.rewards, found.behaviour, 1, frozenset())
            self._columns = [column for column in made if column.name not in self._without]
            self._missing = {column.name for column in self._columns if column.key is not None}
            rows = self._episode(env)
        return [*self._untold(), *_seed_notes(environment, rows, self._tell)]

    def _episode(self, env: AnyEnv) -> Rows:
        """One episode, or what there is time for; returns the first rows of numbers."""
        until, rows = time.monotonic() + MOST_SECONDS, Rows()
        for column in self._columns:
            if column.remembers:
                self._restart(column)
        asked = [column for column in self._columns if not column.given_up]
        again = Trial(env, Guard())
        again.begin(asked)
        self._tell("")
        for step in random_steps(env, 0, MOST_STEPS):
            rows += [step.numbers] if len(rows) < COMPARED else []
            self._seen |= dict.fromkeys(map(str, step.seen.info))
            self._steps, self._has_ended = step.number, step.ended
            for column in asked:
                if not column.given_up:
                    self._ask(column, step, again)
            if step.ended or time.monotonic() >= until:
                break
            self._tell("")
        for column in asked:
            if self._spent[column.name] <= MOST_AGAIN:
                self._tell(column.name)
                for finding in again.look([column]):
                    self._take(finding)
        self._tell("")
        return rows

    def _untold(self) -> list[str]:
        """Keys of measures that no step told, where no episode has ended: the last step of one may tell them."""
        if self._has_ended:
            return []
        return [
            f"no episode ended within {self._steps:,} steps, and none of them told '{column.key}'. "
            f"{unknown_name('key of info', str(column.key), self._seen)}"
            for column in self._columns
            if column.name in self._missing and not column.given_up
        ]

    def _restart(self, column: Column) -> None:
        self._tell(column.name)
        try:
            column.measures[0].reset()
        except (Exception, SystemExit) as error:  # whatever rewards of users raise
            self._give_up(column, f"fails in reset(): {error_text(error)}.")

    def _ask(self, column: Column, step: RandomStep, again: Trial) -> None:
        self._tell(column.name)
        began, given = time.monotonic(), column.arguments(step.seen) if column.measures else ()
        try:
            answer = column.numbers(value_of(column, step))[0]
        except (Exception, SystemExit) as error:
            if isinstance(error, Untold) and not given:
                if not column.may_be_untold or step.ended:
                    last = ", the last of an episode" * step.ended
                    told = unknown_name("key of info", str(column.key), self._seen)
                    self._give_up(column, f"cannot be read in step {step.number - 1}{last}: {told}")
                return
            reason = error_text(error)
            if given and (own := step.guard.reason(column.measures[0], given, error)) != one_line(error):
                reason = own
            self._give_up(column, f"fails in step {step.number - 1}: {reason.rstrip('.')}{'.' * (reason[-1:] != '?')}")
            return
        self._missing.discard(column.name)
        if column.measures and step.number <= FIRST_STEPS and self._spent[column.name] <= MOST_AGAIN:
            self._tell(column.name)
            self._take(again.note(column, given, answer, bool(step.guard.drew)))
            self._spent[column.name] += time.monotonic() - began

    def _take(self, finding: Finding | None) -> None:
        """Give up what remembers something that nobody restarts; what remembers a whole training may."""
        if finding is not None and finding.is_wrong:
            self._give_up(finding.column, f"cannot be used: {finding.told}.")

    def _give_up(self, column: Column, reason: str) -> None:
        column.given_up = True
        self.faults.append(fault_of(column.name, reason))


def _seed_notes(environment: Environment, rows: Rows, tell: Tell) -> list[str]:
    """Whether the same seed and the same actions give the same steps in other envs, which nobody looks at."""
    tell("")
    if _are_equal(_bare(environment, len(rows)), rows):
        return []
    again = [_bare(environment, len(rows)) for _ in range(2)]
    return [TOUCHED if _are_equal(*again) else UNSEEDED]


def _bare(environment: Environment, count: int) -> Rows:
    with closing(environment.make()) as env:
        return [step.numbers for step in islice(random_steps(env, 0, max(count, 1)), count)]


def _are_equal(one: Any, other: Any) -> bool:
    return bool(np.array_equal(one, other, equal_nan=True))
