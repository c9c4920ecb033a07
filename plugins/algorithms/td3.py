"""Twin delayed deep deterministic policy gradient, by stable-baselines3."""

from typing import Annotated, Any, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace, Progress, TrainingEnv
from harness.policy import Policy

from ..off_policy import OffPolicy
from ..sb3 import SOURCES

NotNegative = Annotated[float, Field(ge=0)]


@dataclass(frozen=True)
class Td3(OffPolicy):
    """Twin delayed deep deterministic policy gradient (TD3) of stable-baselines3.

    The policy is deterministic. Noise is added to its actions while it trains.
    """

    action_noise: Annotated[
        NotNegative, Field(description="standard deviation of the noise on actions, whose range counts as [-1, 1]")
    ] = 0.1
    policy_delay: Annotated[int, Field(gt=0, description="updates of the critics per update of the actor")] = 2
    target_noise: Annotated[
        NotNegative, Field(description="standard deviation of the noise on actions in the critics' targets")
    ] = 0.2
    target_noise_clip: Annotated[NotNegative, Field(description="largest size of the noise in these targets")] = 0.5

    sources: ClassVar[tuple[str, ...]] = SOURCES
    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        # Imported here: the settings above are checked before anything runs, and torch takes seconds.
        from stable_baselines3 import TD3

        from ..sb3.policies import policy_from
        from ..sb3.training import train

        return train(
            TD3, env, steps, seed, progress,
            lambda model: policy_from(model, self.activation, "td3", self.action_noise),
            decisions_per_update=self.train_freq * self.num_envs,
            **self._settings(env.single_action_space, steps),
        )  # fmt: skip

    def _settings(self, actions: Any, steps: int) -> dict[str, Any]:
        """The keyword arguments of the library's class; `actions` is the action space of one env."""
        import numpy as np
        from stable_baselines3.common.noise import NormalActionNoise

        from ..sb3.training import replay_settings

        dimensions = np.ones(actions.shape or ())
        return {
            **replay_settings(self, steps),
            "action_noise": NormalActionNoise(0.0 * dimensions, self.action_noise * dimensions),
            "policy_delay": self.policy_delay,
            "target_policy_noise": self.target_noise,
            "target_noise_clip": self.target_noise_clip,
        }
