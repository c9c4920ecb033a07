"""The environment of one arm with its goal apart, as `gymnasium.make("harness/ReachGoal-v0")` gives it.

Learners that pretend another goal had been meant, such as those with hindsight experience replay (HER, Andrychowicz and
others, NeurIPS 2017), have recorded steps paid again for it. `ReachGoalEnv.compute_reward` does that.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, cast

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.arrays import Float
from harness.conditions.conditions import conditions_of
from harness.env.arm_observation import ArmObservation
from harness.env.decisions import GROUND
from harness.env.vector_env import Action, Given, ReachEnv
from harness.errors import UsageError
from harness.registry.choice import Registry, build_defaults, choose
from harness.registry.registry import load_registry
from harness.reward import Reward, Sample, pay
from harness.reward.steps import MissingField
from harness.task import Task

GoalObservation: TypeAlias = dict[str, NDArray[Any]]
NEEDED = ("begin_position", "previous_position", "step", "goal_free_reward", "target_reward")
"""What `ReachGoalEnv.compute_reward` takes from the info of a step."""


class ReachGoalEnv(gymnasium.Env[GoalObservation, Action]):
    """A `ReachEnv` that observes three arrays, and pays any recorded step again for another goal.

    ===============  =============  ================================================================================
    observation      (3 dof + 3,)   joints and end effector, as in `harness.env.arm_observation.ArmObservation`
    achieved_goal    (3,)           the end effector, world frame, [m]
    desired_goal     (3,)           the target, world frame, [m]
    ===============  =============  ================================================================================

    The info of a step also holds `NEEDED`: the end effector at the episode's start and before the step, (3,), [m]; the
    number of the step; what the step pays whatever the goal is (its price, the ground); and what reaching a goal in
    this pose pays.
    """

    metadata = ReachEnv.metadata

    def __init__(
        self,
        simulator: Given = "mujoco",
        task: Given = "fd100-reach",
        reward: Given = "sparse",
        robot: str | Path | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Open the simulator.

        Raises:
            UsageError: The reward or the task cannot be paid again for another goal; or a name is not known.
        """
        registry = load_registry()
        _require_payable_again(reward, registry)
        _require_one_goal(task, registry)
        self._env = ReachEnv(simulator, task, reward, robot, render_mode)
        self.render_mode = render_mode
        self.vector_env = vector_env = self._env.vector_env
        self._arm = ArmObservation(vector_env.robot, vector_env.task.control_period)
        self._begin = self._previous = np.zeros(3)
        self.action_space = self._env.action_space
        columns, extent = self._arm.arm_columns, float(self._arm.high[-1])
        goal = gymnasium.spaces.Box(-extent, extent, (3,), np.float64)
        parts: dict[str, gymnasium.Space[Any]] = {
            "observation": gymnasium.spaces.Box(self._arm.low[columns], self._arm.high[columns]),
            "achieved_goal": goal,
            "desired_goal": goal,
        }
        self.observation_space = cast(gymnasium.Space[GoalObservation], gymnasium.spaces.Dict(parts))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[GoalObservation, dict[str, Any]]:
        """Start an episode; see `ReachVectorEnv.reset`."""
        super().reset(seed=seed)
        _, info = self._env.reset(seed=seed, options=options)
        observation = self._observe()
        self._begin = self._previous = observation["achieved_goal"]
        return observation, info

    def step(self, action: Action) -> tuple[GoalObservation, float, bool, bool, dict[str, Any]]:
        """One control period; see `ReachVectorEnv.step`. It pays what `compute_reward` says of it."""
        _, _, terminated, truncated, info = self._env.step(action)
        info |= self._needed()
        observation = self._observe()
        self._previous = observation["achieved_goal"]
        reward = self.compute_reward(observation["achieved_goal"], observation["desired_goal"], info)
        return observation, float(reward), terminated, truncated, info

    def compute_reward(
        self,
        achieved_goal: ArrayLike,
        desired_goal: ArrayLike,
        info: Mapping[str, Any] | Sequence[Mapping[str, Any]] | NDArray[Any],
    ) -> Float | float:
        """What a step, or each of several, pays if its goal is `desired_goal`.

        Args:
            achieved_goal: The end effector after the step, (3,) or (n, 3), world frame, [m].
            desired_goal: The target, the same.
            info: That of the step, or n of them.

        Returns:
            The shaped reward, the step's price and the events, as `step` pays them; (n,) for several.

        Raises:
            UsageError: An info lacks what is needed.
        """
        achieved, goal = np.asarray(achieved_goal, np.float64), np.asarray(desired_goal, np.float64)
        infos = [info] if isinstance(info, Mapping) else list(info)
        begin, previous, step, goal_free, target = (_column(infos, name) for name in NEEDED)
        distance = np.atleast_1d(_length(goal - achieved))
        # The best so far of another goal is not known; the rewards that are let in do not look at it.
        unknown = np.full_like(distance, np.nan)
        sample = Sample(_length(goal - begin), unknown, _length(goal - previous), distance, unknown, step)
        shaped = pay(self.vector_env.reward, (), sample)[1].total
        paid: Float = shaped + goal_free + np.where(distance <= self.vector_env.task.epsilon, target, 0.0)
        return paid if achieved.ndim > 1 else float(paid[0])

    def render(self) -> NDArray[np.uint8] | None:
        return self._env.render()

    def close(self) -> None:
        """Close the simulator."""
        self._env.close()

    def _observe(self) -> GoalObservation:
        episodes = self.vector_env.episodes
        return {
            "observation": self._arm.observe(episodes)[0, self._arm.arm_columns],
            "achieved_goal": episodes.end_effector[0].copy(),
            "desired_goal": episodes.target[0].copy(),
        }

    def _needed(self) -> dict[str, Any]:
        task, robot, episodes = self.vector_env.task, self.vector_env.robot, self.vector_env.episodes
        values = (
            self._begin.copy(),
            self._previous.copy(),
            int(episodes.step[0]),
            task.step_reward + float(episodes.flags[0, GROUND]) * task.ground_reward,
            float(task.target_rewards(robot, episodes.qpos)[0]),
        )
        return dict(zip(NEEDED, values, strict=True))


def forgets_the_way(reward: Reward) -> bool:
    """Whether a reward needs only the beginning and the last step of an episode. It is tried on random steps.

    Such a reward carries nothing from step to step and pays the same whatever the best distance so far was.
    """
    rng = np.random.default_rng(0)
    begin, before, now, one, other = rng.uniform(0.01, 1.0, (5, 1000))
    carry, step = reward.initial_carry(begin), np.arange(1.0, 1001.0)
    if not isinstance(carry, tuple) or carry:
        return False
    try:
        paid = [pay(reward, (), Sample(begin, best, before, now, now - best, step))[1].total for best in (one, other)]
    except MissingField:  # it reads more than distances, which belong to the goal that was followed
        return False
    return np.array_equal(*paid)


def _require_payable_again(given: Given, registry: Registry) -> None:
    choice = choose(registry, "rewards", given)
    if not forgets_the_way(choice.build(registry, "rewards")):
        allowed = [name for name, reward in build_defaults(registry, "rewards").items() if forgets_the_way(reward)]
        raise UsageError(
            f"Reward '{choice.label}' depends on more than the distances of a step, such as how it ended or the best "
            f"distance so far: it cannot be paid again for another goal. Allowed: {', '.join(allowed)}"
        )


def _require_one_goal(given: Given, registry: Registry) -> None:
    choice = choose(registry, "tasks", given)
    if not _has_one_goal(choice.build(registry, "tasks")):
        allowed = [name for name, task in build_defaults(registry, "tasks").items() if _has_one_goal(task)]
        raise UsageError(
            f"Task '{choice.label}' sets several goals in an episode, repeats an action for several steps, asks for "
            "more than a point that does not move, or has noise, delays, obstacles or varied arms: its steps cannot be "
            f"paid again for another goal. Allowed: {', '.join(allowed)}"
        )


def _has_one_goal(task: Task) -> bool:
    is_simple = task.ends_at_target and task.decision_period == 1 and not hasattr(task, "goal")
    return is_simple and conditions_of(task).are_plain


def _column(infos: Sequence[Mapping[str, Any]], name: str) -> Float:
    try:
        return np.array([info[name] for info in infos], np.float64)
    except KeyError as error:
        raise UsageError(
            f"An info of a step has no '{name}', without which the step cannot be paid again: hand compute_reward the "
            "infos that step returned; of stable-baselines3's HerReplayBuffer, set copy_info_dict=True"
        ) from error


def _length(vectors: Float) -> Float:
    """Euclidean length along the last axis, as `harness.env.episodes` measures it."""
    length: Float = np.sqrt(np.vecdot(vectors, vectors))
    return length
