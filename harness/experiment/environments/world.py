"""Somebody's environment, as a cell trains in it; see `harness.experiment.world.CellWorld`."""

import importlib
import math
import shutil
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from harness.algorithm import Algorithm, needs_goals
from harness.environment import AnyEnv, Environment, envs_together, goal_rewards
from harness.eta.manner import ACTED_AT_RANDOM, DETERMINISTIC, Acted
from harness.executor import Word
from harness.experiment.environments.batch import EnvironmentBatch
from harness.experiment.environments.plan import columns_of
from harness.experiment.environments.spaces import Acting
from harness.experiment.trials.tried import Tried
from harness.experiment.workers.order import named_scalars
from harness.experiment.world import CellWorld
from harness.log import Log
from harness.policy import Policy
from harness.progress import RETURN, SUCCESS
from harness.record.folder import EVALUATIONS, TRAINING_RECORDING
from harness.record.recording.facts import TrainingFacts
from harness.record.recording.recorded_training import (
    facts_name,
    read_recording,
    recorder_numbers,
    recordings_in,
)
from harness.recorder.evaluate_policy import FIRST_SEED, evaluate_policy
from harness.recorder.gate import Gate
from harness.recorder.record_rewards import RecordRewards
from harness.registry.choice import Choice, choose
from harness.registry.spec import blamed_on
from harness.results.recordings.episodes import cut_text, episodes_of, unended_text
from harness.results.recordings.recording_results import terms_in


class EnvironmentWorld(CellWorld):
    """Leaves recordings."""

    _envs: EnvironmentBatch

    def build(self, algorithm: Algorithm) -> Mapping[str, Any]:
        """See `CellWorld`. Envs are made when the training begins or goes on."""
        self._report(Word(0))  # libraries and envs may take long
        self._algorithm = algorithm
        for library in self._learners:
            importlib.import_module(library)
        return {}

    def evaluate(
        self, policy: Policy, acted: Acted, episodes: int, path: Path, *, after: int = 0, seed: int | None = None
    ) -> None:
        """See `CellWorld`: one episode after the other, each with a seed of its own.

        What a policy draws does not depend on anything that was drawn before.
        """
        if path.exists():  # of a process that was killed
            shutil.rmtree(path)
        rng = None if acted == DETERMINISTIC else np.random.default_rng([FIRST_SEED, *[1] * (acted == ACTED_AT_RANDOM)])
        with self._blamed("an env was made"):
            made = self._environment.make()
        with closing(made) as env:
            acting, now = Acting(env, policy, rng), after or self._cell.steps

            def act(observation: Any) -> Any:
                self._beat(now)  # every step is progress
                return acting(observation)

            evaluate_policy(
                act,
                Gate(env, " of an evaluation"),
                path,
                seed=self._cell.seed,
                episodes=episodes,
                horizon=self._cell.evaluation_horizon,
                acted=acted,
                after=after,
                first_seed=FIRST_SEED if seed is None else seed,
                **self._columns(env),
            )

    def try_out(self, rewards: Sequence[Choice], without: Collection[str], tell: Callable[[str], None]) -> Tried:
        """See `CellWorld`: every reward, every measure and every key of info."""
        from harness.experiment.trials.environment_trial import try_environment

        return try_environment(self._cell.task, self._registry, without, tell, rewards)

    def scalars(self, path: Path) -> dict[str, float]:
        """See `CellWorld`: what the reward paid, and all measures."""
        return evaluation_scalars(read_recording(path), self._cell.reward.label)

    def finish(self, folder: Path) -> Sequence[str]:
        ended = []
        if not self._envs.returns:
            facts = TrainingFacts.read(folder / TRAINING_RECORDING / facts_name(0))
            steps = self._cell.steps / self._algorithm.num_envs
            ended = [f"no episode of the training ended: {unended_text(facts, steps)}"]
        recorded = sorted(recordings_in(folder), key=lambda path: path.name != TRAINING_RECORDING)
        return (*ended, *self._cuts(recorded), *_given_up(recorded))

    def _cuts(self, recorded: Sequence[Path]) -> Iterator[str]:
        """How many episodes of the final policy were cut."""
        for facts in (TrainingFacts.read(path / facts_name(0)) for path in recorded):
            is_own = facts.acted == self._cell.acted
            if facts.cut and is_own and not facts.after:
                yield cut_text(facts.cut, self._cell.evaluation_episodes, facts.horizon)

    def _open(self) -> EnvironmentBatch:
        """Envs that record, each under its number, and pay the cell's reward; what others recorded before is gone."""
        for path in self._folder.iterdir():
            if path.is_dir() and path.name != EVALUATIONS:  # of these the policies are gone
                shutil.rmtree(path)
        with self._blamed("envs were made"):
            made = envs_together(self._environment, self._algorithm.num_envs)
        envs, pay = [self._recording(env, number) for number, env in enumerate(made)], None
        if needs_goals(self._algorithm):
            with self._blamed("its rewards were named"):
                pay = goal_rewards(self._environment, made[0])[self._cell.reward.name]
        seed, _ = np.random.SeedSequence(self._cell.seed).generate_state(2).tolist()
        self._envs = EnvironmentBatch(envs, pay, seed, self._beat)
        return self._envs

    def _last_episodes(self) -> Mapping[str, float]:
        told = (RETURN, self._envs.returns), (SUCCESS, self._envs.successes)
        return {name: math.fsum(values) / len(values) for name, values in told if values}

    def _recording(self, env: AnyEnv, number: int) -> RecordRewards[Any, Any]:
        path, where = self._folder / TRAINING_RECORDING, f" of env {number}" * (self._algorithm.num_envs > 1)
        return RecordRewards(
            Gate(env, where),
            path,
            seed=self._cell.seed,
            pay=True,
            number=number,
            steps_asked=self._cell.steps,
            **self._columns(env),
        )

    def _columns(self, env: AnyEnv) -> Mapping[str, Any]:
        """What a recording says about an env."""
        with self._blamed("its rewards were named"):
            reward, registry = self._cell.reward, self._registry
            named = [*(choose(registry, "rewards", it) for it in self._cell.records), reward]
            columns = columns_of(self._environment, env, registry, named)
            return {"trained_with": reward.label, "learners": self._learners, **vars(columns)}

    def _blamed(self, doing: str) -> Any:
        return blamed_on(self._registry.get("environments", self._cell.task.name), doing)

    @cached_property
    def _environment(self) -> Environment:
        built: Environment = self._cell.task.build(self._registry, "environments")
        return built

    @cached_property
    def _learners(self) -> tuple[str, ...]:
        """The libraries that the algorithm needs, whose versions a recording tells; other imports do not matter."""
        return self._registry.get("algorithms", self._cell.algorithm.name).modules


def _given_up(recorded: Sequence[Path]) -> list[str]:
    """A line for each reward and each measure that failed while it looked on, and for what was told of others."""
    failures: dict[str, str] = {}
    notes: dict[str, str] = {}
    for path in recorded:
        where = "training" if path.name == TRAINING_RECORDING else "evaluation"
        for number in recorder_numbers(path):
            facts = TrainingFacts.read(path / facts_name(number))
            for line in facts.notes:
                # The same is told with another step; what to write instead stands in the recording, and in reports.
                notes.setdefault(line.partition(",")[0], line.partition(". ")[0])
            for it in facts.failures:
                name = it.column.replace("/", " ", 1)
                told = f"{name} given up in the {where}, episode {it.episode}, step {it.step}: {it.reason}"
                failures.setdefault(it.column, told)
    return [*failures.values(), *notes.values()]


def evaluation_scalars(evaluation: Log, reward: str) -> dict[str, float]:
    """What a recorded evaluation came to: what the reward and its terms paid, and all measures; see `named_scalars`."""
    part = episodes_of(evaluation).whole
    terms = {name: means.whole for name, means in terms_in(evaluation, reward).terms.items()}
    return named_scalars(part.returns[reward], part.behaviour, terms)
