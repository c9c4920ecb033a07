"""Inverse kinematics in place of learning: the ceiling that learners are compared with."""

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace, Progress, act_for
from harness.env.arm_observation import kinematics_policy, why_not_kinematics
from harness.policy import Policy
from harness.robot import Robot
from harness.task import Task

from ..hyperparameters import MOST_ENVS

if TYPE_CHECKING:
    from harness.env.vector_env import ReachVectorEnv


@dataclass(frozen=True)
class Ik:
    """Reaches by inverse kinematics and learns nothing. It shows what a learner could do that knew the arm.

    Otherwise it knows no more than a learner: it gets the same observations. It does not look out for the ground.
    """

    num_envs: Annotated[int, Field(gt=0, le=MOST_ENVS, description="environments that run side by side")] = 10

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})
    learns: ClassVar[bool] = False
    needs_arm: ClassVar[bool] = True

    def why_not(self, task: Task, robot: Robot) -> str:
        return why_not_kinematics(task, robot)

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        policy = kinematics_policy(env.task, env.robot, "ik")
        act_for(env, steps, policy, seed, progress)
        return policy
