"""The fifty tasks of Meta-World, each with the two versions of its reward."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import gymnasium
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.environment import AnyEnv
from harness.errors import UsageError
from harness.reward import Given
from harness.task import LONGEST_EPISODE

OBSERVABLE = "-goal-observable"
SCALE = 1 / 200
"""In most tasks this factor brings v1, which pays up to about 2,000 a step, to the range of v2, up to 10."""


@dataclass(frozen=True)
class MetaWorld:
    """A Sawyer arm on a table, in one task of Meta-World.

    Start and goal are drawn anew in every episode, and the goal is observed. Two rewards are Meta-World's own, computed
    by the same env: `v1`, and `v2`, with which its newer results were obtained. `v1-scaled` is v1 divided by 200. It
    shows what the size of v1's numbers alone does to a learner. Success and distance are those that Meta-World reports
    when it pays v2, no matter which reward pays the learner. `success` says whether any step of the episode was a
    success, as Meta-World's own results count it. `success_at_end` looks at the last step alone.
    """

    task: Annotated[str, Field(description="name of a Meta-World task, such as reach-v3 or push-v3")] = "reach-v3"
    episode_steps: Annotated[
        int,
        Field(
            ge=1,
            le=LONGEST_EPISODE,
            description="steps per episode: 500 in today's Meta-World, 150 in its first version",
        ),
    ] = 500

    lower_is_better: ClassVar[frozenset[str]] = frozenset({"distance"})
    bounds: ClassVar[Mapping[str, tuple[float, float]]] = {"distance": (0.0, math.inf)}
    baseline: ClassVar[str] = "v1"

    def make(self) -> AnyEnv:
        from metaworld.env_dict import ALL_V3_ENVIRONMENTS_GOAL_OBSERVABLE as TASKS

        if f"{self.task}{OBSERVABLE}" not in TASKS:
            known = ", ".join(sorted(it.removesuffix(OBSERVABLE) for it in TASKS))
            raise UsageError(f"No task of Meta-World '{self.task}'. There is: {known}.")
        env = TASKS[f"{self.task}{OBSERVABLE}"](seed=0)
        env._freeze_rand_vec, env.seeded_rand_vec = False, True  # starts and goals are drawn, by the env's generator
        env.max_path_length = self.episode_steps
        return Seeded(env)

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        def v1(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            return _paid(env, "v1", action, next_observation)

        def v2(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            return _paid(env, "v2", action, next_observation)

        def v1_scaled(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            return SCALE * _paid(env, "v1", action, next_observation)

        return {"v1": v1, "v2": v2, "v1-scaled": v1_scaled}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {"success": AnySuccess(), "success_at_end": "success", "distance": "obj_to_target"}


class AnySuccess:
    """Whether any step of the episode was a success so far."""

    def __init__(self) -> None:
        self.found = False

    def reset(self) -> None:
        """An episode starts."""
        self.found = False

    def __call__(self, observation: Any, action: Any, next_observation: Any, info: Any) -> bool:
        """Look at one more step."""
        self.found = self.found or bool(info["success"])
        return self.found


class Seeded(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Lets Gymnasium seed an env of Meta-World, and corrects its observation space.

    Meta-World's envs are seeded by a method of their own, and declare the goal as if it were always hidden.
    """

    def __init__(self, env: AnyEnv) -> None:
        super().__init__(env)
        self.observation_space = env.unwrapped.sawyer_observation_space  # type: ignore[attr-defined]

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        if seed is not None:
            self.env.unwrapped.seed(seed)  # type: ignore[attr-defined]
        return self.env.reset(options=options)


def _paid(env: AnyEnv, version: str, action: Any, observation: Any) -> float:
    """What the env's own function pays as version `version` of the reward."""
    arm: Any = env.unwrapped
    kept, arm.reward_function_version = arm.reward_function_version, version
    try:
        return float(arm.compute_reward(action, observation)[0])
    finally:
        arm.reward_function_version = kept
