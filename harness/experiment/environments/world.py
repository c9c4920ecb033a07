"""Somebody's environment, as a cell trains in it; see `harness.experiment.world.CellWorld`.

Its envs are joined to the vector env that an algorithm trains on.
"""

import hashlib
import importlib
import math
import shutil
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from harness.algorithm import Algorithm, Goals, needs_goals
from harness.arrays import Float, Float32
from harness.environment import SUCCESS, AnyEnv, Environment, GoalReward, announce_all, envs_together, goal_rewards
from harness.errors import SchemaError, UsageError, one_line
from harness.eta.manner import ACTED_AT_RANDOM, DETERMINISTIC, Acted
from harness.executor import Word
from harness.experiment.environments.plan import columns_of
from harness.experiment.environments.spaces import (
    ACHIEVED,
    DESIRED,
    Acting,
    flat_actions,
    flat_observations,
    goal_columns,
    rows_of,
)
from harness.experiment.trials.tried import Tried
from harness.experiment.workers.order import named_scalars
from harness.experiment.world import CellWorld, LastEpisodes
from harness.log import Log
from harness.policy import Policy
from harness.record.folder import EVALUATIONS, TRAINING_RECORDING
from harness.record.progress import Ring, TrainingState, as_state
from harness.record.recording.facts import FILE_BEHAVIOUR
from harness.record.recording.recorded_training import (
    read_facts,
    read_recording,
    recorder_numbers,
    recordings_in,
)
from harness.recorder.evaluate_policy import FIRST_SEED, evaluate_policy
from harness.recorder.gate import Gate
from harness.recorder.record_rewards import RecordRewards
from harness.registry.choice import Choice, choose
from harness.results.recordings.episodes import cut_text, episodes_of, unended_text
from harness.results.recordings.recording_results import terms_in

Actions = np.ndarray[Any, Any]
Flags = np.ndarray[Any, np.dtype[np.bool_]]


class EnvironmentBatch(VectorEnv[Float32, Actions, Any]):
    """Recorded envs, stepped one after the other; an episode that ends is followed by the next in the same step.

    Attributes:
        environment_steps: Taken so far, counted over all envs.
        learning: What the last episodes came to.
        goals: For an algorithm that learns in hindsight; None where the reward is no function of goals.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.SAME_STEP}  # noqa: RUF012 # Gymnasium's own

    def __init__(
        self,
        envs: Sequence[RecordRewards[Any, Any]],
        pay: GoalReward | None = None,
        seed: int = 0,
        tell: Callable[[int], None] = lambda steps: None,
    ) -> None:
        """Take envs of one kind.

        Args:
            envs: They pay the reward that is trained with.
            pay: The same reward as a function of goals, if it is one.
            seed: That `restore` resets them with.
            tell: Told by it now and then how many environment steps were done.

        Raises:
            UsageError: An algorithm cannot train on such envs.
        """
        self._envs, self.num_envs, self._seed, self._tell = envs, len(envs), seed, tell
        self._unwrapped = [env.unwrapped for env in envs]
        space, actions = envs[0].observation_space, envs[0].action_space
        self._row, self.single_observation_space = rows_of(space).of, (flat := flat_observations(space))
        self.single_action_space = flat_actions(actions)
        self.observation_space = batch_space(flat, self.num_envs)
        self._shape = self.num_envs, *flat.shape
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._is_discrete, self._action_type = isinstance(actions, Discrete), actions.dtype
        self.goals = Goals(*goal_columns(space), pay) if pay else None
        self._log = StepLog()
        self.environment_steps = 0
        self.learning, self._episodes = LastEpisodes(), [0] * self.num_envs

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32, dict[str, Any]]:
        """Start an episode in every env; a seed is that of the first env, and the next ones have the next."""
        self._log.note_reset(is_plain=seed is None and options is None)
        seeds = _seeds(seed, self.num_envs)
        self._episodes = [number + 1 for number in self._episodes]
        rows = [env.reset(seed=one, options=options)[0] for env, one in zip(self._envs, seeds, strict=True)]
        observations = np.stack([self._row(it) for it in rows], dtype=np.float32)
        self._log.note_answers(observations)
        return observations, {}

    def step(self, actions: Actions) -> tuple[Float32, Float, Flags, Flags, dict[str, Any]]:
        """A step in every env.

        Returns:
            Observations (num_envs, observation_size), payments, terminations, truncations, and in `infos`
            ``is_success`` (num_envs,), and where an episode ended ``final_obs``, as the observations.
        """
        given = np.asarray(actions, self._action_type)
        self._log.note_actions(given)
        observations = np.empty(self._shape, np.float32)
        paid, success = np.empty(self.num_envs), np.zeros(self.num_envs, bool)
        terminated, truncated = np.zeros(self.num_envs, bool), np.zeros(self.num_envs, bool)
        final = np.zeros_like(observations)
        rows = list[tuple[float, ...]]()
        chosen = [int(action) for action in given] if self._is_discrete else list(given)
        announce_all(self._unwrapped, chosen)
        for k, (env, action) in enumerate(zip(self._envs, chosen, strict=True)):
            told, reward, terminated[k], truncated[k], _ = env.step(action)
            observations[k], paid[k] = self._row(told), float(reward)
            if self.goals:
                _require_paid_by_goals(self.goals, told, paid[k])
            number, is_last, did = self._episodes[k], terminated[k] or truncated[k], 0.0
            if is_last:
                did = env.recorded.get(f"{FILE_BEHAVIOUR}{SUCCESS}", math.nan)
                success[k] = did > 0
                self._episodes[k] += 1
                final[k] = observations[k]
                observations[k] = self._row(env.reset()[0])
            rows.append((k, number, is_last, True, paid[k], did if math.isnan(did) else success[k]))
        self.learning.take(rows)
        self._log.note_answers(observations, final, paid, terminated, truncated, success)
        self.environment_steps += self.num_envs
        ended = terminated | truncated
        infos: dict[str, Any] = {"is_success": success}
        if ended.any():
            infos |= {"final_obs": final, "_final_obs": ended}
        return observations, paid, terminated, truncated, infos

    def state(self) -> TrainingState | None:
        """What was done since the first reset, which had a seed; None where that is not all."""
        return self._log.state() if self._log.is_complete else None

    def restore(self, state: TrainingState) -> None:
        """Bring new envs to the state of others by giving them the same calls.

        Raises:
            SchemaError: They answer otherwise than the others did, or raise an error.
        """
        try:
            self.reset(seed=self._seed)
            for actions in actions_of(state):
                if actions is None:
                    self.reset()
                else:
                    self.step(actions)
                    self._tell(self.environment_steps)
        except Exception as error:  # whatever people's envs raise
            raise SchemaError(f"the environment fails when the same actions are repeated: {one_line(error)}") from error
        self._log.require_same(state)

    def close_extras(self, **kwargs: Any) -> None:
        """Close the envs, and their recordings."""
        for env in self._envs:
            env.close()


def _require_paid_by_goals(goals: Goals, told: Any, paid: float) -> None:
    """Raise UsageError if a step was not paid what the reward pays for the goals observed after it."""
    pays = float(np.asarray(goals.pay(told[ACHIEVED][np.newaxis], told[DESIRED][np.newaxis]))[0])
    if abs(pays - paid) > 1e-6 + 1e-5 * abs(paid):
        raise UsageError(
            f"a step was paid {paid:.9g}, and the reward as a function of goals pays {pays:.9g} for it: it is no "
            "function of goals alone, so that steps cannot be paid again for other goals"
        )


def _seeds(seed: int | Sequence[int | None] | None, count: int) -> list[int | None]:
    """The seed of each env."""
    if isinstance(seed, Sequence):
        return list(seed)
    return [None if seed is None else seed + k for k in range(count)]


FIRST_ROOM = 1024
"""The number of decisions for which there is room at the beginning."""


class StepLog:
    """A log that grows with every decision by an action of each env.

    Attributes:
        is_complete: False where they were reset in a way that the log does not hold.
    """

    def __init__(self) -> None:
        self.is_complete, self._has_begun = True, False
        self._actions: NDArray[Any] = np.empty((0, 0))
        self._decisions, self._resets = 0, list[int]()
        self._digest = hashlib.sha256()

    def note_reset(self, is_plain: bool) -> None:
        """Note a reset of all envs. The first reset has a seed, which is not noted; later ones have none."""
        self.is_complete &= is_plain == self._has_begun
        if self._has_begun:
            self._resets.append(self._decisions)
        self._has_begun = True

    def note_actions(self, actions: NDArray[Any]) -> None:
        """Note the actions of a decision, (num_envs, ...)."""
        if self._decisions == len(self._actions):
            grown = np.empty((max(FIRST_ROOM, 2 * self._decisions), *actions.shape), actions.dtype)
            grown[: self._decisions] = self._actions[: self._decisions] if self._decisions else 0
            self._actions = grown
        self._actions[self._decisions] = actions
        self._decisions += 1

    def note_answers(self, *answers: NDArray[Any]) -> None:
        """Note the envs' answers, which are arrays in row-major order."""
        for answer in answers:
            self._digest.update(answer.data)

    def state(self) -> TrainingState:
        """The whole log; see `actions_of`."""
        return as_state(
            {
                "actions": Ring({"actions": self._actions}, self._decisions),
                "resets": np.array(self._resets, np.int64),
                "digest": np.frombuffer(self._digest.digest(), np.uint8),
            }
        )

    def require_same(self, state: TrainingState) -> None:
        """Check that the envs gave the same answers when the calls were repeated.

        Raises:
            SchemaError: It was not.
        """
        if self._digest.digest() != np.asarray(state["digest"]).tobytes():
            raise SchemaError(
                "the environment did something else when the same actions were repeated: it depends on more than the "
                "seed that it is reset with"
            )


def actions_of(state: TrainingState) -> Iterator[NDArray[Any] | None]:
    """What the envs of a log were told, in order: actions, (num_envs, ...), or None for a reset without a seed."""
    ring, resets = state["actions"], Counter(np.asarray(state["resets"]).tolist())
    for decision in range(ring.written):
        yield from [None] * resets[decision]
        yield ring.columns["actions"][decision]
    yield from [None] * resets[ring.written]


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
        if not self._envs.learning.means():
            facts = read_facts(folder / TRAINING_RECORDING)
            steps = self._cell.steps / self._algorithm.num_envs
            ended = [f"no episode of the training ended: {unended_text(facts, steps)}"]
        recorded = sorted(recordings_in(folder), key=lambda path: path.name != TRAINING_RECORDING)
        return (*ended, *self._cuts(recorded), *_given_up(recorded))

    def _cuts(self, recorded: Sequence[Path]) -> Iterator[str]:
        """How many episodes of the final policy were cut."""
        for facts in (read_facts(path) for path in recorded):
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
        return self._envs.learning.means()

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
        return self._cell.task.blamed(self._registry, "environments", doing)

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
            facts = read_facts(path, number)
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
