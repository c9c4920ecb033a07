"""Random actions in place of learning: the floor that learners are compared with."""

from typing import Annotated, Any, ClassVar

from gymnasium.spaces import Discrete
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace, Progress, TrainingEnv, act_for
from harness.policy import Policy, Uniform, UniformChoice

from ..hyperparameters import MOST_ENVS


@dataclass(frozen=True)
class Random:
    """Acts uniformly at random and learns nothing. An algorithm that is no better has learned nothing.

    It spends its budget acting, so that its trace can be compared with those of trainings.
    """

    num_envs: Annotated[int, Field(gt=0, le=MOST_ENVS, description="environments that run side by side")] = 1

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous", "discrete"})
    learns: ClassVar[bool] = False

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        policy = _uniform(env.single_action_space)
        act_for(env, steps, policy, seed, progress)
        return policy


def _uniform(space: Any) -> Policy:
    if isinstance(space, Discrete):
        return UniformChoice(int(space.n), "random")
    return Uniform(tuple(space.low.tolist()), tuple(space.high.tolist()), "random")
