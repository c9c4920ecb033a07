"""Trains and evaluates one cell in somebody's environment."""

import importlib
import math
import shutil
import time
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.algorithm import Algorithm, needs_goals
from harness.environment import AnyEnv, Environment, goal_rewards
from harness.executor import NO_SCALARS, CellOptions, Word
from harness.experiment.checkpoints.attempt import Attempt, begin_attempt
from harness.experiment.checkpoints.left_checkpoints import LeftCheckpoints
from harness.experiment.draft import Draft
from harness.experiment.environments.acting import Acting
from harness.experiment.environments.batch import EnvironmentBatch
from harness.experiment.environments.columns import columns_of
from harness.experiment.evaluation.scalars import named_scalars
from harness.experiment.progress.beat import Beat
from harness.experiment.progress.learning_so_far import TELL_EVERY
from harness.experiment.provenance import describe_environment
from harness.experiment.watch import Watch
from harness.experiment.workers.order import Report
from harness.policy import Policy
from harness.progress import RETURN, SPEED, SUCCESS, Progress, TrainingState
from harness.record.cell import Cell
from harness.record.folder import EVALUATION_RECORDING, POLICY, TRAINING_RECORDING
from harness.record.manifest import Manifest
from harness.record.recording.facts import TrainingFacts
from harness.record.recording.recorded_training import (
    RecordedTraining,
    facts_name,
    read_recording,
    recorder_numbers,
)
from harness.recorder.evaluate_policy import evaluate_policy
from harness.recorder.record_rewards import RecordRewards
from harness.registry.registry import Registry
from harness.registry.spec import blamed_on
from harness.results.recordings.episodes import cut_text, episodes_of

NO_END = "no episode of the training ended: give the environment a time limit"


@dataclass(frozen=True)
class EnvironmentTraining:
    """The training of one cell."""

    cell: Cell
    registry: Registry
    report: Report
    options: CellOptions
    watch: Watch

    def leave(self, draft: Draft[Manifest]) -> None:
        """Train and evaluate; leave everything but the manifest, and put into that what there is to say.

        A training that was killed goes on from its last checkpoint: all that its envs were told before is told to new
        ones, which record it anew.
        """
        cell, registry = self.cell, self.registry
        draft.note(environment=describe_environment(cell, None, registry))
        self.report(Word(0))
        environment: Environment = cell.task.build(registry, "environments")
        algorithm: Algorithm = cell.algorithm.build(registry, "algorithms")
        for library in self._learners:
            importlib.import_module(library)
        attempt, batch = self._begin(environment, algorithm, draft)
        draft.note(resumed_from=attempt.begun_from, note=attempt.note)
        with closing(batch):
            policy = self._train(algorithm, batch, attempt)
        note = _together(attempt.note, "" if batch.returns else NO_END)
        draft.note(training_seconds=round(attempt.seconds, 3), note=note)
        policy.save(draft.partial / POLICY, cell.to_json())
        self.watch.enter("evaluation")
        path = draft.partial / EVALUATION_RECORDING
        self._evaluate(environment, policy, path)
        draft.note(note=_together(note, self._look_at(path), *_given_up(draft.partial)))
        self.watch.enter("saving")

    def _begin(
        self, environment: Environment, algorithm: Algorithm, draft: Draft[Manifest]
    ) -> tuple[Attempt, EnvironmentBatch]:
        """Envs in the state in which the training begins. After a kill it goes on where it was, if that is possible."""
        folder, done_again = draft.partial, list[EnvironmentBatch]()

        def restore(state: TrainingState) -> None:
            for name in (TRAINING_RECORDING, EVALUATION_RECORDING, POLICY):
                if (folder / name).exists():
                    shutil.rmtree(folder / name)
            batch = self._open(environment, algorithm, folder / TRAINING_RECORDING)
            try:
                batch.do_again(state, self._seeds[0], Beat(self.report))
            except BaseException:
                batch.close()
                raise
            done_again.append(batch)

        every, described = self.options.checkpoint_every, draft.record.environment
        attempt = begin_attempt(self.cell, folder, described, every, restore)
        if done_again:
            return attempt, done_again[0]
        return attempt, self._open(environment, algorithm, folder / TRAINING_RECORDING)

    def _train(self, algorithm: Algorithm, batch: EnvironmentBatch, attempt: Attempt) -> Policy:
        """Train, every step recorded."""
        env_seed, algorithm_seed = self._seeds
        if attempt.checkpoint is None:
            batch.reset(seed=env_seed)
        progress = TrainingProgress(self.report, batch, attempt, self.options.tracked)
        policy = algorithm.train(batch, self.cell.steps, algorithm_seed, progress)
        self.report(Word(min(batch.environment_steps, self.cell.steps), progress.learned()))
        return policy

    @property
    def _seeds(self) -> tuple[int, int]:
        """The seeds of the envs and of the algorithm."""
        env, algorithm = np.random.SeedSequence(self.cell.seed).generate_state(2).tolist()
        return env, algorithm

    def _open(self, environment: Environment, algorithm: Algorithm, path: Path) -> EnvironmentBatch:
        """Envs that record, each under its number, and pay the cell's reward."""
        envs = [self._recorded(environment, path, number) for number in range(algorithm.num_envs)]
        if not needs_goals(algorithm):
            return EnvironmentBatch(envs)
        with blamed_on(self.registry.get("environments", self.cell.task.name), "its rewards were named"):
            return EnvironmentBatch(envs, goal_rewards(environment, envs[0].env)[self.cell.reward.name])

    def _recorded(self, environment: Environment, path: Path, number: int) -> RecordRewards[Any, Any]:
        env = self._made(environment)
        told = self._told(environment, env)
        return RecordRewards(env, path, seed=self.cell.seed, pay=True, number=number, **told)

    def _evaluate(self, environment: Environment, policy: Policy, path: Path) -> None:
        with closing(self._made(environment)) as env:
            act = _Act(Acting(env, policy, self.cell.deterministic), self.cell, self.report)
            evaluate_policy(
                act,
                env,
                path,
                seed=self.cell.seed,
                episodes=self.cell.evaluation_episodes,
                horizon=self.cell.evaluation_horizon,
                **self._told(environment, env),
            )

    def _look_at(self, path: Path) -> str:
        """Tell trackers what an evaluation came to; returns what there is to say of episodes that were cut."""
        if self.options.tracked:
            self.report(Word(self.cell.steps, evaluation_scalars(read_recording(path), self.cell.reward.name)))
        facts = TrainingFacts.read(path / facts_name(0))
        return cut_text(facts.cut, self.cell.evaluation_episodes, facts.horizon) if facts.cut else ""

    def _made(self, environment: Environment) -> AnyEnv:
        with blamed_on(self.registry.get("environments", self.cell.task.name), "an env was made"):
            return environment.make()

    def _told(self, environment: Environment, env: AnyEnv) -> Mapping[str, Any]:
        """What a recording says about an env."""
        with blamed_on(self.registry.get("environments", self.cell.task.name), "its rewards were named"):
            return {
                "trained_with": self.cell.reward.name,
                "learners": self._learners,
                **vars(columns_of(environment, env, self.registry)),
            }

    @property
    def _learners(self) -> tuple[str, ...]:
        """The libraries that the algorithm needs, whose versions a recording tells; other imports do not matter."""
        return self.registry.get("algorithms", self.cell.algorithm.name).modules


def _given_up(folder: Path) -> list[str]:
    """A line for each reward and each measure that failed while it looked on; everything else was recorded."""
    failures: dict[str, str] = {}
    for part, where in ((TRAINING_RECORDING, "the training"), (EVALUATION_RECORDING, "the evaluation")):
        for number in recorder_numbers(folder / part):
            for it in TrainingFacts.read(folder / part / facts_name(number)).failures:
                name = it.column.replace("_", " ", 1)
                failures.setdefault(
                    it.column, f"{name} given up in {where}, episode {it.episode}, step {it.step}: {it.reason}"
                )
    return list(failures.values())


def evaluation_scalars(evaluation: RecordedTraining, reward: str) -> dict[str, float]:
    """What a recorded evaluation came to: what the reward paid, and all measures; see `named_scalars`."""
    part = episodes_of(evaluation).part(0, len(evaluation))
    return named_scalars(part.returns[reward], part.behaviour)


def _together(*notes: str) -> str:
    return "; ".join(note for note in notes if note)


class TrainingProgress(Progress):
    """Passes on the steps, what the last episodes came to, and scalars for who tracks them; writes checkpoints."""

    def __init__(self, report: Report, batch: EnvironmentBatch, attempt: Attempt, tracked: bool) -> None:
        """Begin to count.

        Args:
            report: Told the steps and the scalars.
            batch: What is trained on.
            attempt: What the training starts with, and how often it leaves a checkpoint.
            tracked: Whether what the algorithm tells is passed on.
        """
        self._report, self._batch, self._attempt, self._tracked = report, batch, attempt, tracked
        self._checkpoints = LeftCheckpoints(attempt)
        self._told, self._steps = time.monotonic(), batch.environment_steps

    def __call__(self, steps: int) -> None:
        """See `harness.progress.Progress`."""
        due = time.monotonic() >= self._told + TELL_EVERY
        self._report(Word(int(steps), self.learned() if due else NO_SCALARS))

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        """See `harness.progress.Progress`."""
        if self._tracked:
            self._report(Word(int(steps), {name: float(value) for name, value in values.items()}))

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        """See `harness.progress.Progress`."""
        if self._batch.can_be_kept and self._checkpoints.is_due(steps):
            self._checkpoints.leave(steps, make(), self._batch.state(), self._attempt.seconds)

    def restored(self) -> TrainingState | None:
        """See `harness.progress.Progress`."""
        return self._checkpoints.restored()

    def learned(self) -> dict[str, float]:
        """The numbers to report now, by the names of `harness.progress`."""
        now, batch, found = time.monotonic(), self._batch, {}
        if now > self._told:
            found[SPEED] = (batch.environment_steps - self._steps) / (now - self._told)
        self._told, self._steps = now, batch.environment_steps
        for name, values in ((RETURN, batch.returns), (SUCCESS, batch.successes)):
            if values:
                found[name] = math.fsum(values) / len(values)
        return found


class _Act:
    """Acts, and reports now and then that the evaluation goes on.

    Every step is progress, also of an episode that nothing ends: it is cut at the cell's horizon, so that no evaluation
    goes on for ever.
    """

    def __init__(self, act: Acting, cell: Cell, report: Report) -> None:
        self._act, self._cell, self._beat = act, cell, Beat(report)

    def __call__(self, observation: Any) -> Any:
        self._beat(self._cell.steps)
        return self._act(observation)
