"""What the algorithm checks train on: an easy task, an env that keeps an account, and a policy's evaluation."""

from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.algorithm import Algorithm
from harness.env import Infos, Mask, ReachVectorEnv
from harness.make import load_robot
from harness.policy import Policy
from harness.reward import Array, Carry, Sample
from harness.robot import Robot
from harness.task import ReachTask
from harness.testing.ideal import IdealSimulator

Float32 = NDArray[np.float32]

EASY = ReachTask(epsilon=0.2, horizon=20, target_center=(0.6, 0.6, 0.6), target_half_extent=(0.0, 0.0, 0.0))
"""One target, about 0.7 m from home: the arm gets there in 10 steps and more."""
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
        """See `harness.reward.Reward`."""
        return carry, -sample.distance


class WatchedEnv(ReachVectorEnv):
    """Keeps an account of what an algorithm does with the env."""

    def __init__(self, num_envs: int) -> None:
        super().__init__(IdealSimulator(), easy_robot(), EASY, NegativeDistance(), num_envs)
        self.steps = 0
        self.actions_in_box = True
        self.seeds: list[Any] = []

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Float32, Infos]:
        """As any reset; keeps the seed."""
        self.seeds.append(seed)
        return super().reset(seed=seed, options=options)

    def step(self, actions: Float32) -> tuple[Float32, NDArray[np.float64], Mask, Mask, Infos]:  # type: ignore[override]
        """As any step; counts it, and looks at the actions."""
        self.steps += self.num_envs
        self.actions_in_box &= self.action_space.contains(np.asarray(actions, np.float32))
        return super().step(actions)


@dataclass
class Training:
    """A training that was done: the policy, what the env saw, what the caller was told."""

    policy: Policy
    env: WatchedEnv
    told: list[int] = field(default_factory=list)


def train(algorithm: Algorithm, steps: int, seed: int = 0) -> Training:
    """Train on the easy task for `steps`, or a few more to make it a multiple of the algorithm's envs."""
    env = WatchedEnv(algorithm.num_envs)
    told: list[int] = []
    env.reset(seed=ENV_SEED)
    env.seeds.clear()
    policy = algorithm.train(env, steps_for(algorithm, steps), seed, told.append)
    return Training(policy, env, told)


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


def mean_return(policy: Policy) -> float:
    """The mean return of episodes in which the policy acts without noise."""
    env = WatchedEnv(EVALUATION_EPISODES)
    seen, _ = env.reset(seed=ENV_SEED)
    running, returns = np.ones(env.num_envs, bool), np.zeros(env.num_envs)
    while running.any():
        seen, rewards, terminated, truncated, _ = env.step(policy.act(seen))
        returns += np.where(running, rewards, 0.0)
        running &= ~(terminated | truncated)
    return float(returns.mean())
