"""Pays a recorded training by rewards that were written later: a new env gets the same calls, and the rewards look on.

Nothing is learned again. Each answer of the new env is compared with the one that was recorded. If one differs, the new
rewards would be paid for another training, so nothing is written.
"""

import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from harness.arrays import Float
from harness.errors import UsageError, one_line
from harness.log import Log, Rows, in_memory
from harness.record.recording.facts import ActionFacts, TrainingFacts, facts_of, file_column, term_column
from harness.record.recording.recorded_training import (
    ACTION,
    CALLS,
    INTEGERS,
    add_scores,
    read_recorder,
    read_recording,
    recorder_numbers,
)
from harness.recorder.env_facts import Columns
from harness.recorder.record_rewards import RecordRewards
from harness.recorder.recorder import NO_SEED, UNCHECKED, GivenUp, Noted, action_of, checksum
from harness.recorder.sealed import KeepWalks, Walk
from harness.reward.given import OWN
from harness.reward.steps import ENDS

Tell = Callable[[int], None]


@dataclass(frozen=True)
class Retake:
    """How recordings are paid again.

    Attributes:
        make: Makes an env like the one that was recorded.
        later: Gives the rewards and measures for such an env.
        tell: Called after each step with the number of steps of this recording that are done.
    """

    make: Callable[[], gymnasium.Env[Any, Any]]
    later: Callable[[gymnasium.Env[Any, Any]], Columns]
    tell: Tell = lambda steps: None

    def score(self, folder: Path) -> tuple[str, ...]:
        """Write what the rewards and measures say of a recording into its folder.

        The recording stays as it is, and so do earlier scores of other rewards.

        Returns:
            What failed, a line each: such a column is NaN from that step on.

        Raises:
            UsageError: The recording does not tell all calls, or the new env answers otherwise.
            SchemaError: The recording is damaged.
            OSError: The folder cannot be written.
        """
        for _ in (log := read_recording(folder)).pieces(log.names):
            pass  # raises an error if it is damaged
        found: dict[int, Log] = {}
        done = 0
        for number in recorder_numbers(folder):
            log = read_recorder(folder, number)
            rows = _calls_in(folder, log)
            found[number] = self._of_recorder(folder, facts_of(log), rows, done)
            done += len(rows)
        add_scores(folder, found)
        failures = dict.fromkeys(failure for scores in found.values() for failure in facts_of(scores).failures)
        return tuple(
            f"{file_column(it.column)} fails in episode {it.episode}, step {it.step}: {it.reason}" for it in failures
        )

    def walks(self, folder: Path) -> Iterator[tuple[int, list[Walk]]]:
        """What was seen and done in a recording: by number of the env, its episodes in order.

        An env's walks are all in memory at once.

        Raises:
            UsageError: The recording does not tell all calls, or the new env answers otherwise.
            SchemaError: The recording is damaged.
        """
        begin = 0
        for number in recorder_numbers(folder):
            log = read_recorder(folder, number)
            rows, facts = _calls_in(folder, log), facts_of(log)
            for env in range(facts.num_envs):
                calls, again = rows.part(rows["env"] == env), KeepWalks(self.make())
                with closing(again), self._recorded(folder, facts, calls, again, Columns({}, {}), 0):
                    found = again.walks
                yield begin + env, found
            begin += facts.num_envs

    def _of_recorder(self, folder: Path, facts: TrainingFacts, calls: Rows, done: int) -> Log:
        """Its envs one after the other: each of them went on by itself."""
        values: dict[str, Float] = {}
        scores: list[Log] = []
        for env in range(facts.num_envs):
            rows = np.flatnonzero(calls["env"] == env)
            scores.append(self._of_env(folder, facts, calls.part(rows), env, done))
            for name, column in scores[-1].known.items():
                values.setdefault(name, np.full(len(calls), np.nan))[rows] = column
            done += len(rows)
        told = [facts_of(one) for one in scores]
        return in_memory(replace(told[0], failed=tuple(it for one in told for it in one.failed)), values)

    def _of_env(self, folder: Path, facts: TrainingFacts, calls: Rows, number: int, done: int) -> Log:
        with closing(self.make()) as env:
            later = self.later(env)
            with self._recorded(folder, facts, calls, env, later, done) as log:
                told = facts_of(log)
                terms = [term_column(name, term) for name in later.rewards for term in told.terms.get(name, ())]
                columns = log.rows([*later.names[: len(later.rewards)], *terms, *later.names[len(later.rewards) :]])
        facts = replace(
            told,
            rewards=tuple(later.rewards),
            sources={name: told.sources[name] for name in later.names},
            failed=tuple(replace(failure, env=number) for failure in told.failures),
            terms={name: told.terms[name] for name in later.rewards if name in told.terms},
        )
        return in_memory(facts, columns.columns)

    @contextmanager
    def _recorded(
        self, folder: Path, facts: TrainingFacts, calls: Rows, env: gymnasium.Env[Any, Any], later: Columns, done: int
    ) -> Iterator[Log]:
        """What a new env answers to the calls of one env, and what rewards and measures say of it."""
        with tempfile.TemporaryDirectory(prefix="harness-retake-") as place, warnings.catch_warnings():
            warnings.simplefilter("ignore", GivenUp)  # `score` returns what failed
            warnings.simplefilter("ignore", Noted)
            again = RecordRewards(
                env,
                place,
                trained_with=OWN,
                **vars(later),
                evaluation=True,  # nothing is trained, and none of these measures has to decide
                horizon=facts.horizon or None,  # episodes were cut, and are cut again
            )
            try:
                actions = _require_actions(folder, facts)
                _repeat(calls, actions, again, f"'{folder}'", lambda steps: self.tell(done + steps))
            finally:
                again.finish()
            yield read_recording(Path(place))


def _repeat(calls: Rows, actions: ActionFacts, env: RecordRewards[Any, Any], where: str, tell: Tell) -> None:
    """Give the calls that one env got to another one.

    Raises:
        UsageError: It answers otherwise, or raises an error.
    """
    rows = zip(*(calls[name].tolist() for name in (*CALLS, *ENDS)), calls[ACTION], strict=True)
    for number, (seed, resets, answer, terminated, truncated, action) in enumerate(rows):
        try:
            if seed != NO_SEED:
                env.reset(seed=seed)
            for _ in range(resets):
                env.reset()
            observation, _, *ends, _ = env.step(action_of(action, actions))
        except Exception as error:  # whatever people's envs raise
            raise UsageError(f"{_place(calls, where, number)}: the environment raises {one_line(error)}") from error
        answered = UNCHECKED if answer == UNCHECKED else checksum(observation)
        if (answered, *map(bool, ends)) != (answer, terminated, truncated):
            raise UsageError(
                f"{_place(calls, where, number)}: the environment does not answer as it did. It, a library or the "
                "machine has changed since, or it draws numbers that its seed does not decide. Nothing is paid"
            )
        tell(number + 1)


def _place(calls: Rows, where: str, number: int) -> str:
    return f"{where}, episode {calls['episode'][number]}, step {calls['step'][number]}"


def _calls_in(folder: Path, log: Log) -> Rows:
    """The calls that the envs of a recorder got, and their answers."""
    _require_actions(folder, facts_of(log))
    return log.rows((*INTEGERS, *ENDS, *CALLS, ACTION))


def _require_actions(folder: Path, facts: TrainingFacts) -> ActionFacts:
    actions = facts.actions
    if actions is None:
        raise UsageError(
            f"'{folder}' does not hold the actions of its training, so no other reward can pay it. Recordings of "
            "earlier versions do not, nor those of actions that are no numbers, or of envs that are stepped as a batch"
        )
    if actions.problem:
        raise UsageError(
            f"'{folder}' cannot be paid by another reward: {actions.problem}, so that its actions cannot be taken again"
        )
    return actions
