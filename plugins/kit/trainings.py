"""What the algorithm checks train on: an easy task, an env that keeps an account, and a policy's evaluation."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness import Float, Float32, Mask, load_robot
from harness.algorithm import ActionSpace, Algorithm, Goals, Progress, needs_goals
from harness.env.ideal import IdealSimulator
from harness.env.vector_env import Actions, Infos, ReachVectorEnv
from harness.payoff.rollout import discounted_sum
from harness.policy import Policy
from harness.reward import Array, Carry, Sample
from harness.robot import Robot
from harness.task import ReachTask

EASY = ReachTask(epsilon=0.2, horizon=20, target_center=(0.6, 0.6, 0.6), target_half_extent=(0.0, 0.0, 0.0))
"""One target, about 0.7 m from home: the arm gets there in 10 steps and more."""
MODES: dict[ActionSpace, str] = {"continuous": "movej", "discrete": "discrete:action=movej"}
"""The action mode of that task for each kind of action."""
ENV_SEED = 7
EVALUATION_EPISODES = 8


@cache
def easy_robot() -> Robot:
    """The arm of the easy task."""
    return load_robot("fd100")


@dataclass(frozen=True)
class NegativeDistance:
    """A reward that is easy to learn from: minus the distance, [m]."""

    def initial_carry(self, begin_distance: Array) -> Carry:
        """Remembers nothing."""
        return ()

    def __call__(self, carry: Carry, sample: Sample) -> tuple[Carry, Array]:
        return carry, -sample.distance


class Told(Progress):
    """Keeps what it is told: the steps, and the newest policy."""

    def __init__(self) -> None:
        self.steps: list[int] = []
        self.newest: Policy | None = None

    def __call__(self, steps: int) -> None:
        self.steps.append(steps)

    def policy(self, steps: int, make: Callable[[], Policy]) -> None:
        self.newest = make()


class Decision(NamedTuple):
    """One decision of a training.

    Attributes:
        observation: What was seen, (num_envs, size).
        action: What was done, (num_envs, ...).
        episode: Number of the episode of each env, (num_envs,).
        policy: The newest one that the algorithm had told; None where it had told none.
    """

    observation: Float32
    action: Actions
    episode: NDArray[np.intp]
    policy: Policy | None


class WatchedEnv(ReachVectorEnv):
    """The easy task with one kind of action; keeps an account of what an algorithm does with it.

    Attributes:
        space: The kind of action.
        bonus: Paid on top, (num_envs,): whether a training heeds what each env pays.
        hindsight_bonus: Paid on top of what is paid again for other goals.
        goals: For an algorithm that learns in hindsight; what is observed then says nowhere else where the target is.
        told: What the algorithm tells while it trains.
        decisions: All of them.
    """

    def __init__(self, num_envs: int, space: ActionSpace = "continuous", with_goals: bool = False) -> None:
        task = replace(EASY, action=MODES[space])
        super().__init__(IdealSimulator(), easy_robot(), task, NegativeDistance(), num_envs, resumable=True)
        self.space = space
        self.bonus, self.hindsight_bonus = np.zeros(num_envs), 0.0
        target = 3 * self.robot.dof  # its column; see `harness.env.arm_observation.ArmObservation`
        achieved, desired = slice(target + 3, target + 6), slice(target, target + 3)
        self.goals = Goals(achieved, desired, self._pay_again) if with_goals else None
        self.told = Told()
        self.decisions: list[Decision] = []
        self._seen: Any = None
        self._episode = np.zeros(num_envs, np.intp)
        self.steps = 0
        self.actions_in_box = True
        self.seeds: list[Any] = []

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Float32, Infos]:
        """Any reset; keeps the seed."""
        self.seeds.append(seed)
        observations, infos = super().reset(seed=seed, options=options)
        self._seen = self._shown(observations)
        self._episode = self._episode + 1
        return self._seen, infos

    def step(self, actions: Actions) -> tuple[Float32, Float, Mask, Mask, Infos]:  # type: ignore[override]
        """Any step; counts it, and looks at the actions."""
        self.steps += self.num_envs
        self.actions_in_box &= self.action_space.contains(np.asarray(actions, self.action_space.dtype))
        self.decisions.append(Decision(self._seen, np.array(actions), self._episode, self.told.newest))
        observations, rewards, terminated, truncated, infos = super().step(actions)
        observations = self._shown(observations)
        if "final_obs" in infos:
            infos["final_obs"] = self._shown(infos["final_obs"])
        self._seen, self._episode = observations, self._episode + (terminated | truncated)
        return observations, rewards + self.bonus, terminated, truncated, infos

    def _shown(self, observations: Float32) -> Float32:
        """Without what depends on the goal beside the goal itself, which is another one in hindsight."""
        if self.goals:
            observations[:, self.goals.achieved.stop :] = 0.0
        return observations

    def _pay_again(self, achieved: Float, desired: Float) -> Float:
        paid: Float = self.hindsight_bonus - np.linalg.norm(achieved - desired, axis=1)
        return paid


@dataclass
class Training:
    """A training that was done: the policy, what the env saw, what the caller was told."""

    policy: Policy
    env: WatchedEnv
    told: list[int] = field(default_factory=list)

    @property
    def tells_its_policy(self) -> bool:
        """Whether the algorithm told its policy before half of its decisions were made, and later."""
        decisions = self.env.decisions
        return any(decision.policy is not None for decision in decisions[: len(decisions) // 2])


def trainings(algorithm: Algorithm, steps: int, seed: int = 0) -> Iterator[Training]:
    """One training with each kind of action that the algorithm takes."""
    for space in sorted(algorithm.action_spaces):
        yield train(algorithm, steps, seed, space)


def train(algorithm: Algorithm, steps: int, seed: int = 0, space: ActionSpace | None = None, **paid: Any) -> Training:
    """Train on the easy task for `steps`, or a few more to make it a multiple of the algorithm's envs.

    A training that was done before is not done again, see `train_anew`: most checks look at the same one.

    Args:
        algorithm: What learns.
        steps: Environment steps.
        seed: Of the algorithm.
        space: The kind of action; None for the first that the algorithm takes.
        paid: See `train_anew`.
    """
    try:
        hash(algorithm)
    except TypeError:  # not frozen: another check says so
        return train_anew(algorithm, steps, seed, space, **paid)
    wanted = space or min(algorithm.action_spaces)
    return _train_once(algorithm, steps, seed, wanted, **paid)  # type: ignore[arg-type]  # it has a hash


def train_anew(
    algorithm: Algorithm,
    steps: int,
    seed: int = 0,
    space: ActionSpace | None = None,
    bonus: float = 0.0,
    env: int = 0,
    hindsight_bonus: float = 0.0,
) -> Training:
    """The same as `train`, whatever was done before.

    Args:
        algorithm: What learns.
        steps: Environment steps.
        seed: Of the algorithm.
        space: The kind of action; None for the first that the algorithm takes.
        bonus: Paid on top on every step of one env.
        env: Which one.
        hindsight_bonus: Paid on top of what is paid again for other goals.
    """
    watched = WatchedEnv(algorithm.num_envs, space or min(algorithm.action_spaces), needs_goals(algorithm))
    watched.bonus[env], watched.hindsight_bonus = bonus, hindsight_bonus
    watched.reset(seed=ENV_SEED)
    watched.seeds.clear()
    policy = algorithm.train(watched, steps_for(algorithm, steps), seed, watched.told)
    return Training(policy, watched, watched.told.steps)


_train_once = lru_cache(maxsize=16)(train_anew)


def in_several_envs(algorithm: Algorithm) -> Algorithm:
    """The algorithm on two envs at least, where its `num_envs` is a hyperparameter; else as it is."""
    settings: Any = algorithm  # a dataclass, but that is another check's to say
    chooses = is_dataclass(settings) and "num_envs" in {field.name for field in fields(settings)}
    several: Algorithm = replace(settings, num_envs=2) if chooses and settings.num_envs < 2 else settings
    return several


def steps_for(algorithm: Algorithm, steps: int) -> int:
    """The smallest multiple of the algorithm's envs that is not below `steps`."""
    return -(-steps // algorithm.num_envs) * algorithm.num_envs


def observations() -> Float32:
    """What a policy may see: the starts of some episodes, and a few steps into them."""
    env = WatchedEnv(EVALUATION_EPISODES)
    seen = [env.reset(seed=ENV_SEED)[0]]
    for _ in range(5):
        seen.append(env.step(np.ones((env.num_envs, env.robot.dof), np.float32))[0])
    return np.concatenate(seen)


def mean_return(training: Training) -> float:
    """The mean return of episodes in which the policy of a training acts without noise."""
    env = WatchedEnv(EVALUATION_EPISODES, training.env.space, training.env.goals is not None)
    seen, _ = env.reset(seed=ENV_SEED)
    running, paid = np.ones(env.num_envs, bool), list[Float]()
    while running.any():
        seen, rewards, terminated, truncated, _ = env.step(training.policy.act(seen))
        paid.append(np.where(running, rewards, 0.0))
        running &= ~(terminated | truncated)
    return float(discounted_sum(np.array(paid), 1.0).mean())
