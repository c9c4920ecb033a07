"""Train and evaluate one cell in an environment of anybody."""

import math
import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.algorithm import Algorithm
from harness.environment import AnyEnv, Environment, lower_is_better, measured_behaviour, rewards_of
from harness.executor import NO_SCALARS, CellOptions, Word
from harness.experiment.attempt import restart
from harness.experiment.draft import Draft
from harness.experiment.environments.acting import Acting
from harness.experiment.environments.batch import EnvironmentBatch
from harness.experiment.order import Report
from harness.experiment.provenance import describe_environment
from harness.experiment.watch import Watch
from harness.policy import Policy
from harness.progress import RETURN, SPEED, SUCCESS, Progress
from harness.record.cell import Cell
from harness.record.folder import EVALUATION_RECORDING, POLICY, TRAINING_RECORDING
from harness.record.manifest import Manifest
from harness.recorder.evaluate_policy import evaluate_policy
from harness.recorder.record_rewards import RecordRewards
from harness.registry.registry import Registry
from harness.registry.spec import blamed_on

TELL_EVERY = 1.0
"""Seconds."""


@dataclass(frozen=True)
class EnvironmentTraining:
    """One cell on its way."""

    cell: Cell
    registry: Registry
    report: Report
    options: CellOptions
    watch: Watch

    def leave(self, draft: Draft[Manifest]) -> None:
        """Train and evaluate; leave everything but the manifest, and put into that what there is to say.

        A training that was killed starts over: what an environment of anybody is like in the middle of an episode
        cannot be kept.
        """
        cell, registry = self.cell, self.registry
        draft.note(environment=describe_environment(cell, None, registry), note=restart(draft.partial))
        self.report(Word(0))
        environment: Environment = cell.task.build(registry, "environments")
        algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
        policy = self._train(environment, algorithm, draft)
        policy.save(draft.partial / POLICY, cell.to_json())
        self.watch.enter("evaluation")
        self._evaluate(environment, policy, draft.partial / EVALUATION_RECORDING)
        self.watch.enter("saving")

    def _train(self, environment: Environment, algorithm: Algorithm, draft: Draft[Manifest]) -> Policy:
        """Train, every step recorded, and put down how long that took."""
        cell, clock = self.cell, time.perf_counter()
        env_seed, algorithm_seed = (int(seed) for seed in np.random.SeedSequence(cell.seed).generate_state(2))
        path = draft.partial / TRAINING_RECORDING
        with closing(self._open(environment, algorithm.num_envs, path)) as batch:
            batch.reset(seed=env_seed)
            progress = TrainingProgress(self.report, batch, self.options.tracked)
            policy = algorithm.train(batch, cell.steps, algorithm_seed, progress)  # type: ignore[arg-type] # see there
            self.report(Word(min(batch.environment_steps, cell.steps), progress.learned()))
        draft.note(training_seconds=round(time.perf_counter() - clock, 3))
        return policy

    def _open(self, environment: Environment, count: int, path: Path) -> EnvironmentBatch:
        """Envs that record, each under its number, and pay the cell's reward."""
        return EnvironmentBatch([self._recorded(environment, path, number) for number in range(count)])

    def _recorded(self, environment: Environment, path: Path, number: int) -> RecordRewards[Any, Any]:
        env = self._made(environment)
        told = self._told(environment, env)
        return RecordRewards(env, path, seed=self.cell.seed, pay=True, number=number, on_error="raise", **told)

    def _evaluate(self, environment: Environment, policy: Policy, path: Path) -> None:
        with closing(self._made(environment)) as env:
            act = _Told(Acting(env, policy, self.cell.deterministic), self.cell, self.report)
            evaluate_policy(
                act,
                env,
                path,
                seed=self.cell.seed,
                episodes=self.cell.evaluation_episodes,
                on_error="raise",
                **self._told(environment, env),
            )

    def _made(self, environment: Environment) -> AnyEnv:
        with blamed_on(self.registry.get("environments", self.cell.task.name), "an env was made"):
            return environment.make()

    def _told(self, environment: Environment, env: AnyEnv) -> Mapping[str, Any]:
        """What recordings are told of an env."""
        with blamed_on(self.registry.get("environments", self.cell.task.name), "its rewards were named"):
            return {
                "trained_with": self.cell.reward.name,
                "rewards": rewards_of(environment, env),
                "behaviour": measured_behaviour(environment, env),
                "lower_is_better": lower_is_better(environment),
            }


class TrainingProgress(Progress):
    """Passes on the steps, what the last episodes came to, and scalars for who tracks them."""

    def __init__(self, report: Report, batch: EnvironmentBatch, tracked: bool) -> None:
        """Begin to count.

        Args:
            report: Told the steps and the scalars.
            batch: What is trained on.
            tracked: Whether what the algorithm tells is passed on.
        """
        self._report, self._batch, self._tracked = report, batch, tracked
        self._told, self._steps = time.monotonic(), 0

    def __call__(self, steps: int) -> None:
        """See `harness.progress.Progress`."""
        due = time.monotonic() >= self._told + TELL_EVERY
        self._report(Word(int(steps), self.learned() if due else NO_SCALARS))

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        """See `harness.progress.Progress`."""
        if self._tracked:
            self._report(Word(int(steps), {name: float(value) for name, value in values.items()}))

    def learned(self) -> dict[str, float]:
        """What there is to tell now, by the names of `harness.progress`."""
        now, batch, found = time.monotonic(), self._batch, {}
        if now > self._told:
            found[SPEED] = (batch.environment_steps - self._steps) / (now - self._told)
        self._told, self._steps = now, batch.environment_steps
        for name, values in ((RETURN, batch.returns), (SUCCESS, batch.successes)):
            if values:
                found[name] = math.fsum(values) / len(values)
        return found


class _Told:
    """Acts, and says now and then that the evaluation gets on."""

    def __init__(self, act: Acting, cell: Cell, report: Report) -> None:
        self._act, self._cell, self._report = act, cell, report
        self._told = time.monotonic()

    def __call__(self, observation: Any) -> Any:
        if time.monotonic() >= self._told + TELL_EVERY:
            self._told = time.monotonic()
            self._report(Word(self._cell.steps))
        return self._act(observation)
