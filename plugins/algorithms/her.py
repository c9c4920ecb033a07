"""Soft actor-critic with hindsight experience replay, by stable-baselines3."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import Progress, TrainingEnv
from harness.policy import Policy

from ..sb3 import SOURCES
from ..soft_actor_critic import SoftActorCritic


@dataclass(frozen=True)
class Her(SoftActorCritic):
    """stable-baselines3's SAC, which also learns from steps as if another goal had been desired (Andrychowicz 2017).

    The other goal is one that was achieved in the same episode. The reward of the training, as a function of goals,
    pays the step again for that goal. So even a reward that only tells whether the goal was achieved teaches something
    from the first episode on. This algorithm learns only in environments with goals. It begins when the first episode
    has ended.
    """

    sampled_goals: Annotated[
        int, Field(gt=0, description="steps with another goal per step with its own goal, in each update")
    ] = 4
    goal: Annotated[
        Literal["future", "final", "episode"],
        Field(description="future: a goal achieved later in the episode; final: at its end; episode: anywhere in it"),
    ] = "future"

    needs_goals: ClassVar[bool] = True
    sources: ClassVar[tuple[str, ...]] = SOURCES

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        # Imported here: the settings above are checked before anything runs, and torch takes seconds.
        from stable_baselines3 import HerReplayBuffer

        from ..sb3.hindsight import GoalEnvAdapter, HindsightSAC
        from ..sb3.policies import policy_from
        from ..sb3.training import soft_actor_critic_settings, train

        return train(
            HindsightSAC, env, steps, seed, progress,
            lambda model: policy_from(model, self.activation, "her"),
            decisions_per_update=self.train_freq * self.num_envs,
            adapter=GoalEnvAdapter,
            replay_buffer_class=HerReplayBuffer,
            replay_buffer_kwargs={"n_sampled_goal": self.sampled_goals, "goal_selection_strategy": self.goal},
            **soft_actor_critic_settings(self, steps),
        )  # fmt: skip
