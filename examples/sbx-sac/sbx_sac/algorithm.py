"""Soft actor-critic by sbx, which is stable-baselines3's interface on JAX."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from harness.algorithm import ActionSpace, Progress, TrainingEnv
from harness.policy import SquashedGaussian

Count = Annotated[int, Field(gt=0)]
Positive = Annotated[float, Field(gt=0)]


@dataclass(frozen=True)
class SbxSac:
    """SAC with the settings that the built-in `sac` has; it leaves no checkpoints, so a killed one starts over."""

    learning_rate: Positive = 1e-3
    gamma: Annotated[float, Field(gt=0, le=1)] = 0.95
    net_arch: tuple[Count, ...] = (64, 64)
    batch_size: Count = 256
    learning_starts: Count = 100
    num_envs: Count = 1

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})
    # The manifest has a hash of all modules that can change a result.
    sources: ClassVar[tuple[str, ...]] = ("sbx_sac", "harness_plugins.sb3")

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> SquashedGaussian:
        # Imported here: JAX takes seconds, and settings are checked before anything runs.
        from sbx import SAC

        from harness_plugins.sb3 import ProgressCallback, VecEnvAdapter

        model = SAC(
            "MlpPolicy",
            VecEnvAdapter(env),
            learning_rate=self.learning_rate,
            gamma=self.gamma,
            batch_size=self.batch_size,
            learning_starts=self.learning_starts,
            buffer_size=steps,
            ent_coef="auto_0.1",
            policy_kwargs={"net_arch": list(self.net_arch)},
            seed=seed % 2**32,
        )
        model.learn(steps, callback=ProgressCallback(env, progress, steps, self._policy))
        return self._policy(model)

    def _policy(self, model: Any) -> SquashedGaussian:
        """The actor as a policy that acts with numpy alone; Flax keeps weights as (in, out)."""
        layers = model.policy.actor_state.params["params"]
        depth = len(self.net_arch)
        names = [*(f"hidden.{i}" for i in range(depth)), "mean", "log_std"]
        weights = {}
        for index, name in enumerate(names):
            layer = layers[f"Dense_{index}"]
            weights[f"{name}.weight"] = np.array(layer["kernel"], np.float32).T
            weights[f"{name}.bias"] = np.array(layer["bias"], np.float32)
        low, high = (tuple(bound.tolist()) for bound in (model.action_space.low, model.action_space.high))
        return SquashedGaussian(weights, "relu", low, high, "sbx-sac")
