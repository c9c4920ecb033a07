"""Joins somebody's envs to the vector env that an algorithm trains on."""

import hashlib
import math
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from harness.algorithm import Goals
from harness.arrays import Float, Float32
from harness.environment import SUCCESS, GoalReward, announce_all
from harness.errors import SchemaError, UsageError, one_line
from harness.experiment.environments.spaces import (
    ACHIEVED,
    DESIRED,
    flat_actions,
    flat_observation,
    flat_observations,
    goal_columns,
)
from harness.progress import LAST_EPISODES, Ring, TrainingState, as_state
from harness.record.recording.facts import FILE_BEHAVIOUR
from harness.recorder.record_rewards import RecordRewards

Actions = np.ndarray[Any, Any]
Flags = np.ndarray[Any, np.dtype[np.bool_]]


class EnvironmentBatch(VectorEnv[Float32, Actions, Any]):
    """Recorded envs, stepped one after the other; an episode that ends is followed by the next in the same step.

    Attributes:
        environment_steps: Taken so far, counted over all envs.
        returns: What the last `LAST_EPISODES` episodes were paid, in the order in which they ended.
        successes: Whether they ended in success; empty where nothing measures that.
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
        self._space, actions = envs[0].observation_space, envs[0].action_space
        self.single_observation_space = flat = flat_observations(self._space)
        self.single_action_space = flat_actions(actions)
        self.observation_space = batch_space(flat, self.num_envs)
        self._shape = self.num_envs, *flat.shape
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._is_discrete, self._action_type = isinstance(actions, Discrete), actions.dtype
        self.goals = Goals(*goal_columns(self._space), pay) if pay else None
        self._log = StepLog()
        self.environment_steps = 0
        self._paid = np.zeros(self.num_envs)
        self.returns: deque[float] = deque(maxlen=LAST_EPISODES)
        self.successes: deque[bool] = deque(maxlen=LAST_EPISODES)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32, dict[str, Any]]:
        """Start an episode in every env; a seed is that of the first env, and the next ones have the next."""
        self._log.note_reset(is_plain=seed is None and options is None)
        seeds = _seeds(seed, self.num_envs)
        self._paid[:] = 0.0
        rows = [env.reset(seed=one, options=options)[0] for env, one in zip(self._envs, seeds, strict=True)]
        observations = np.stack([flat_observation(self._space, row) for row in rows])
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
        chosen = [int(action) for action in given] if self._is_discrete else list(given)
        announce_all(self._unwrapped, chosen)
        for k, (env, action) in enumerate(zip(self._envs, chosen, strict=True)):
            told, reward, terminated[k], truncated[k], _ = env.step(action)
            observations[k], paid[k] = flat_observation(self._space, told), float(reward)
            if self.goals:
                _require_paid_by_goals(self.goals, told, paid[k])
            self._paid[k] += paid[k]
            if terminated[k] or truncated[k]:
                success[k] = self._end(k, env)
                final[k] = observations[k]
                observations[k] = flat_observation(self._space, env.reset()[0])
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

    def _end(self, k: int, env: RecordRewards[Any, Any]) -> bool:
        """Note an episode that ended; returns whether it ended in success."""
        self.returns.append(float(self._paid[k]))
        self._paid[k] = 0.0
        told = env.recorded.get(f"{FILE_BEHAVIOUR}{SUCCESS}", math.nan)
        if not math.isnan(told):
            self.successes.append(told > 0)
        return told > 0


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
