"""The Fetch arm of Gymnasium-Robotics, which moves its gripper to a point."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar

import gymnasium
import numpy as np
from pydantic.dataclasses import dataclass

from harness import Float
from harness.environment import AnyEnv, GoalReward
from harness.errors import UsageError
from harness.reward import Given

REMEDY = "pip install 'fd100-harness[robotics]'"


@dataclass(frozen=True)
class FetchReach:
    """FetchReach-v4: the gripper of a Fetch arm moves to a random point; an episode has 50 steps of 0.04 s.

    Both rewards are the environment's own: `sparse` pays 0 within 5 cm of the point and -1 elsewhere, `dense` pays
    minus the distance in metres. An observation is a dict of observation, achieved goal and desired goal.
    """

    lower_is_better: ClassVar[frozenset[str]] = frozenset({"distance"})
    bounds: ClassVar[Mapping[str, tuple[float, float]]] = {"distance": (0.0, math.inf)}
    baseline: ClassVar[str] = "sparse"

    def make(self) -> AnyEnv:
        import gymnasium_robotics

        gymnasium.register_envs(gymnasium_robotics)
        try:
            return gymnasium.make("FetchReach-v4")
        except (TypeError, AttributeError, KeyError) as error:
            import mujoco

            told = f"Gymnasium-Robotics cannot make FetchReach-v4 with mujoco {mujoco.__version__}: {error!r}"
            raise UsageError(f"{told}. Its versions up to 1.4 need mujoco below 3.12: {REMEDY}") from error

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        def sparse(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            return float(_paid(env, "sparse", next_observation["achieved_goal"], next_observation["desired_goal"]))

        def dense(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            return float(_paid(env, "dense", next_observation["achieved_goal"], next_observation["desired_goal"]))

        return {"sparse": sparse, "dense": dense}

    def goal_rewards(self, env: AnyEnv) -> Mapping[str, GoalReward]:
        """See `harness.environment.goal_rewards`: both rewards are functions of goals."""
        return {"sparse": partial(_paid, env, "sparse"), "dense": partial(_paid, env, "dense")}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"success": "is_success", "distance": distance}


def distance(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
    """Distance from the gripper to the point, [m]."""
    return float(np.linalg.norm(next_observation["achieved_goal"] - next_observation["desired_goal"]))


def _paid(env: AnyEnv, kind: str, achieved: Float, desired: Float) -> Any:
    """What the environment's own function pays as reward `kind`, (...), for goals (..., 3)."""
    arm: Any = env.unwrapped
    kept, arm.reward_type = arm.reward_type, kind
    try:
        return arm.compute_reward(achieved, desired, {})
    finally:
        arm.reward_type = kept
