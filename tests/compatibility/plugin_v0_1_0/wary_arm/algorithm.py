"""The algorithm."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.acting import act_for
from harness.algorithm import ActionSpace
from harness.env import ReachVectorEnv
from harness.policy import Policy, Uniform
from harness.progress import Progress, State, as_state
from harness.random_state import pack_generator, restore_generator


@dataclass(frozen=True)
class Careful:
    """Acts at random, as little as it may."""

    num_envs: ClassVar[int] = 1
    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})
    learns: ClassVar[bool] = False

    def train(self, env: ReachVectorEnv, steps: int, seed: int, progress: Progress) -> Policy:
        """See `harness.algorithm.Algorithm`."""
        space = env.single_action_space
        policy = Uniform(tuple(space.low.tolist()), tuple(space.high.tolist()), "wary-algo")
        rng = np.random.default_rng(seed)
        state: State = as_state({"generator": pack_generator(rng)})
        restore_generator(rng, state["generator"])
        act_for(env, steps, policy, seed, progress)
        return policy
