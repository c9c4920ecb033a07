"""Soft actor-critic, by stable-baselines3."""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.algorithm import ActionSpace, Progress
from harness.policy import Policy

if TYPE_CHECKING:
    from stable_baselines3 import SAC

    from harness.env import ReachVectorEnv

Positive = Annotated[float, Field(gt=0)]
Count = Annotated[int, Field(gt=0)]


@dataclass(frozen=True)
class Sac:
    """stable-baselines3's SAC on the CPU, with settings that learn the FD100 task in 10,000 steps.

    The library's own defaults (learning rate 3e-4, gamma 0.99, 256x256) do not. The entropy coefficient starts at 0.1:
    a step pays some 0.1, and from the library's 1 it takes thousands of steps before the reward outweighs the noise.
    """

    learning_rate: Annotated[Positive, Field(description="of actor, critics and entropy coefficient")] = 1e-3
    gamma: Annotated[float, Field(ge=0, le=1, description="discount")] = 0.95
    net_arch: Annotated[tuple[Count, ...], Field(min_length=1, description="hidden layers of actor and critics")] = (
        64,
        64,
    )
    batch_size: Annotated[Count, Field(description="transitions per update")] = 256
    buffer_size: Annotated[Count, Field(description="transitions kept for replay")] = 1_000_000
    learning_starts: Annotated[int, Field(ge=0, description="steps with random actions before the first update")] = 100
    train_freq: Annotated[Count, Field(description="steps between updates")] = 1
    gradient_steps: Annotated[int, Field(ge=-1, description="updates each time; -1: as many as steps taken")] = 1
    tau: Annotated[float, Field(gt=0, le=1, description="share of the new weights in the target critics")] = 0.005
    ent_coef: Annotated[
        str,
        Field(
            pattern=r"^(auto|auto_0*\.?0*[1-9]\d*\.?\d*|\d*\.?\d+)$",
            description="entropy coefficient: a number, or auto_X to learn it from X on (auto: from 1)",
        ),
    ] = "auto_0.1"
    activation: Annotated[Literal["relu", "tanh"], Field(description="between the layers")] = "relu"
    num_envs: Annotated[Count, Field(description="envs that are trained on at once")] = 1

    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    def train(self, env: "ReachVectorEnv", steps: int, seed: int, progress: Progress) -> Policy:
        """See `harness.algorithm.Algorithm`."""
        # Imported here: the settings above are checked before anything runs, and torch takes seconds.
        import torch
        from stable_baselines3 import SAC

        from harness_plugins.sb3 import SilentProgress, VecEnvAdapter

        torch.set_num_threads(1)
        model = SAC(
            "MlpPolicy",
            VecEnvAdapter(env),
            learning_rate=self.learning_rate,
            gamma=self.gamma,
            batch_size=self.batch_size,
            buffer_size=min(self.buffer_size, steps),
            learning_starts=self.learning_starts,
            train_freq=self.train_freq,
            gradient_steps=self.gradient_steps,
            tau=self.tau,
            ent_coef=self.ent_coef if self.ent_coef.startswith("auto") else float(self.ent_coef),
            policy_kwargs={"net_arch": list(self.net_arch), "activation_fn": _activation(self.activation)},
            seed=seed % 2**32,
            device="cpu",
        )
        model.learn(steps, callback=SilentProgress(progress, steps))
        return _policy_of(model, self.activation)


def _activation(name: str) -> Any:
    import torch

    return {"relu": torch.nn.ReLU, "tanh": torch.nn.Tanh}[name]


def _policy_of(model: "SAC", activation: str) -> Policy:
    """The actor's weights under the names that `Policy` gives them."""
    actor: Any = model.policy.actor
    hidden = [layer for layer in actor.latent_pi if hasattr(layer, "weight")]
    layers = {**{f"hidden.{i}": layer for i, layer in enumerate(hidden)}, "mean": actor.mu, "log_std": actor.log_std}
    weights = {}
    for name, layer in layers.items():
        weights[f"{name}.weight"] = layer.weight.detach().numpy().astype(np.float32, copy=True)
        weights[f"{name}.bias"] = layer.bias.detach().numpy().astype(np.float32, copy=True)
    space: Any = model.action_space
    return Policy(weights, activation, tuple(space.low.tolist()), tuple(space.high.tolist()), "sac")
