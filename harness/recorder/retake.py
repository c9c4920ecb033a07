"""Pays a recorded training by rewards that were written later: a new env gets the same calls, and the rewards look on.

Nothing is learned again. Each answer of the new env is compared with the one that was recorded. If one differs, the new
rewards would be paid for another training, so nothing is written.
"""

import tempfile
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from harness.errors import UsageError, one_line
from harness.files.sums import making
from harness.record.recording.facts import BEHAVIOUR, REWARD, ActionFacts, TrainingFacts, term_column
from harness.record.recording.recorded_training import (
    action_columns,
    facts_name,
    read_recording,
    read_steps,
    recorder_numbers,
)
from harness.record.recording.scores import Scores, read_scores, scores_name, write_scores
from harness.recorder.calls import NO_SEED, UNCHECKED, action_of, checksum
from harness.recorder.record_rewards import RecordRewards
from harness.recorder.recorder import GivenUp, Noted
from harness.recorder.walk import KeepWalks, Walk
from harness.reward.given import OWN, Given

Columns = Mapping[str, NDArray[Any]]
Tell = Callable[[int], None]


@dataclass(frozen=True)
class Later:
    """Rewards and measures that were written later, for one env.

    Attributes:
        rewards: By name.
        behaviour: By name.
        lower_is_better: Names of the measures among them of which less is better.
    """

    rewards: Mapping[str, Given]
    behaviour: Mapping[str, Given]
    lower_is_better: Collection[str] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """What their columns are called."""
        return (*(f"{REWARD}{name}" for name in self.rewards), *(f"{BEHAVIOUR}{name}" for name in self.behaviour))


@dataclass(frozen=True)
class Retake:
    """How recordings are paid again.

    Attributes:
        make: Makes an env like the one that was recorded.
        later: Gives the rewards and measures for such an env.
        tell: Called after each step with the number of steps of this recording that are done.
    """

    make: Callable[[], gymnasium.Env[Any, Any]]
    later: Callable[[gymnasium.Env[Any, Any]], Later]
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
        read_recording(folder)  # raises an error if it is damaged
        found: dict[Path, Scores] = {}
        done = 0
        for number in recorder_numbers(folder):
            facts = TrainingFacts.read(folder / facts_name(number))
            actions = _require_calls(folder, facts)
            columns = read_steps(folder, number, facts, with_calls=True)
            path, steps = folder / scores_name(number), len(columns["time"])
            scores = self._of_recorder(folder, facts, actions, columns, done)
            earlier = read_scores(path, steps)
            found[path] = scores if earlier is None else scores.with_earlier(earlier)
            done += steps
        for path, scores in found.items():
            with making(path):
                write_scores(path, scores)
        failures = dict.fromkeys(failure for scores in found.values() for failure in scores.failures)
        return tuple(f"{it.column} fails in episode {it.episode}, step {it.step}: {it.reason}" for it in failures)

    def walks(self, folder: Path) -> Iterator[tuple[int, list[Walk]]]:
        """What was seen and done in a recording: by number of the env, its episodes in order.

        An env's walks are all in memory at once.

        Raises:
            UsageError: The recording does not tell all calls, or the new env answers otherwise.
            SchemaError: The recording is damaged.
        """
        begin = 0
        for number in recorder_numbers(folder):
            facts = TrainingFacts.read(folder / facts_name(number))
            actions = _require_calls(folder, facts)
            columns = read_steps(folder, number, facts, with_calls=True)
            numbers = np.stack([columns[name] for name in action_columns(facts)], axis=1)
            for env in range(facts.num_envs):
                rows = np.flatnonzero(columns["env"] == env)
                calls = _Calls(actions, numbers[rows], {name: column[rows] for name, column in columns.items()})
                yield begin + env, self._walks_of(folder, facts, calls)
            begin += facts.num_envs

    def _walks_of(self, folder: Path, facts: TrainingFacts, calls: "_Calls") -> list[Walk]:
        with tempfile.TemporaryDirectory(prefix="harness-retake-") as place, closing(KeepWalks(self.make())) as env:
            again = RecordRewards(
                env, Path(place) / "again", trained_with=OWN, rewards={}, horizon=facts.horizon or None
            )
            try:
                calls.repeat(again, f"'{folder}'", self.tell)
            finally:
                again.finish()
            return env.walks

    def _of_recorder(
        self, folder: Path, facts: TrainingFacts, actions: ActionFacts, columns: Columns, done: int
    ) -> Scores:
        """Its envs one after the other: each of them went on by itself."""
        numbers = np.stack([columns[name] for name in action_columns(facts)], axis=1)
        values: dict[str, NDArray[np.float64]] = {}
        scores: list[Scores] = []
        for env in range(facts.num_envs):
            rows = np.flatnonzero(columns["env"] == env)
            calls = _Calls(actions, numbers[rows], {name: column[rows] for name, column in columns.items()})
            scores.append(self._of_env(folder, facts, calls, env, done))
            for name, column in scores[-1].columns.items():
                values.setdefault(name, np.full(len(numbers), np.nan))[rows] = column
            done += len(rows)
        return replace(scores[0], columns=values, failures=tuple(it for one in scores for it in one.failures))

    def _of_env(self, folder: Path, facts: TrainingFacts, calls: "_Calls", number: int, done: int) -> Scores:
        with tempfile.TemporaryDirectory(prefix="harness-retake-") as place, closing(self.make()) as env:
            later, path = self.later(env), Path(place) / "again"
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", GivenUp)  # `score` returns what failed
                warnings.simplefilter("ignore", Noted)
                again = RecordRewards(
                    env,
                    path,
                    trained_with=OWN,
                    rewards=later.rewards,
                    behaviour=later.behaviour,
                    lower_is_better=later.lower_is_better,
                    horizon=facts.horizon or None,  # episodes were cut, and are cut again
                )
                try:
                    calls.repeat(again, f"'{folder}'", lambda steps: self.tell(done + steps))
                finally:
                    again.finish()
            recording = read_recording(path)
            terms = {name: recording.terms.get(name, {}) for name in later.rewards}
            columns = {
                **{f"{REWARD}{name}": recording.rewards[name] for name in later.rewards},
                **{term_column(name, term): values for name, of in terms.items() for term, values in of.items()},
                **{f"{BEHAVIOUR}{name}": recording.behaviour[name] for name in later.behaviour},
            }
        told = recording.facts
        return Scores(
            columns,
            told.lower_is_better,
            {name: told.sources[name] for name in later.columns},
            tuple(replace(failure, env=number) for failure in told.failures),
        )


@dataclass(frozen=True)
class _Calls:
    """The calls that one env got, and its answers.

    Attributes:
        actions: How actions are recorded.
        numbers: The actions, (steps, action_size).
        columns: The other columns of its steps, (steps,) each.
    """

    actions: ActionFacts
    numbers: NDArray[np.float64]
    columns: Columns

    def repeat(self, env: RecordRewards[Any, Any], where: str, tell: Tell) -> None:
        """Give the same calls to another env.

        Raises:
            UsageError: It answers otherwise, or raises an error.
        """
        names = ("seed", "resets", "answer", "terminated", "truncated")
        rows = zip(*(self.columns[name].tolist() for name in names), self.numbers, strict=True)
        for number, (seed, resets, answer, terminated, truncated, action) in enumerate(rows):
            try:
                if seed != NO_SEED:
                    env.reset(seed=seed)
                for _ in range(resets):
                    env.reset()
                observation, _, *ends, _ = env.step(action_of(action, self.actions))
            except Exception as error:  # whatever people's envs raise
                raise UsageError(f"{self._place(where, number)}: the environment raises {one_line(error)}") from error
            answered = UNCHECKED if answer == UNCHECKED else checksum(observation)
            if (answered, *map(bool, ends)) != (answer, terminated, truncated):
                raise UsageError(
                    f"{self._place(where, number)}: the environment does not answer as it did. It, a library or the "
                    "machine has changed since, or it draws numbers that its seed does not decide. Nothing is paid"
                )
            tell(number + 1)

    def _place(self, where: str, number: int) -> str:
        episode, step = (int(self.columns[name][number]) for name in ("episode", "step"))
        return f"{where}, episode {episode}, step {step}"


def _require_calls(folder: Path, facts: TrainingFacts) -> ActionFacts:
    if facts.actions is None:
        raise UsageError(
            f"'{folder}' does not hold the actions of its training, so no other reward can pay it. Recordings of "
            "earlier versions do not, nor those of actions that are no numbers, or of envs that are stepped as a batch"
        )
    if facts.actions.problem:
        raise UsageError(
            f"'{folder}' cannot be paid by another reward: {facts.actions.problem}, so that its actions cannot be "
            "taken again"
        )
    return facts.actions
