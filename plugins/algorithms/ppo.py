"""Proximal policy optimisation, by stable-baselines3."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs

from harness.algorithm import ActionSpace, Progress, TrainingEnv
from harness.policy import Policy

from ..hyperparameters import IN_ENVIRONMENTS, Activation, BatchSize, Gamma, Layers, LearningRate, NumEnvs
from ..sb3 import SOURCES

Share = Annotated[float, Field(ge=0, le=1)]
Positive = Annotated[float, Field(gt=0)]

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "fd100": {},
    "unity": {
        # As published with the baseline: batch 256, buffer 2560, horizon 128 (so 20 envs of 128 decisions), 3 layers of
        # 256, learning rate 3e-4 that decays linearly, gamma 0.99.
        "learning_rate": 3e-4,
        "schedule": "linear",
        "gamma": 0.99,
        "net_arch": (256, 256, 256),
        "batch_size": 256,
        "rollout": 2560,
        "num_envs": 20,
        # Not published with it; the values that Unity ML-Agents takes then.
        "epochs": 3,
        "gae_lambda": 0.95,
        "clip_range": 0.2,
        "ent_coef": 0.005,
    },
}
"""What each preset sets for parameters that are not given."""


@dataclass(frozen=True)
class Ppo:
    """Proximal policy optimisation (PPO) of stable-baselines3, for continuous and for discrete actions.

    PPO moves a stochastic policy, NOTE eq. 2, up the gradient of NOTE eq. 11, with advantages in place of rewards. An
    update never moves it far from the policy that drew the actions. A rollout is what is recorded between two updates.
    If a training ends within a rollout, it does not learn from that rollout.

    The defaults learn the FD100 task in 15,000 steps. Eight envs side by side take half of the time of one: most of it
    goes to calls, and a call acts for all of them. With gamma 0.95 and widely spread actions (log_std 0), under the
    reward `dense`, the policy learns to dive into the ground instead, because that ends the price of the distance.
    """

    preset: Annotated[
        Literal["fd100", "unity"],
        Field(description="fd100: the defaults below; unity: those published with the baseline; a given value wins"),
    ] = "fd100"
    learning_rate: LearningRate = 1e-3
    schedule: Annotated[
        Literal["constant", "linear"],
        Field(description="learning_rate and clip_range: constant, or linear down to 0 at the end of the training"),
    ] = "constant"
    gamma: Gamma = 0.8
    net_arch: Layers = (64, 64)
    batch_size: BatchSize = 64
    rollout: Annotated[
        int, Field(gt=0, description="decisions per update, over all envs; a multiple of num_envs and batch_size")
    ] = 128
    epochs: Annotated[int, Field(gt=0, description="how often an update learns from each decision")] = 10
    gae_lambda: Annotated[
        Share, Field(description="lambda of GAE, 0 to 1: how far ahead the rewards of a rollout count in an advantage")
    ] = 0.95
    clip_range: Annotated[
        Positive, Field(description="limit on the relative change of an action's probability in an update")
    ] = 0.2
    ent_coef: Annotated[float, Field(ge=0, description="weight of the bonus for spread-out actions (entropy)")] = 0.0
    value_coef: Annotated[float, Field(ge=0, description="weight of the value network's error in the loss")] = 0.5
    log_std: Annotated[
        float, Field(description="ln of the standard deviation of continuous actions at the start of the training")
    ] = -0.5
    max_gradient: Annotated[Positive, Field(description="norm at which gradients are clipped")] = 0.5
    activation: Activation = "tanh"
    num_envs: NumEnvs = 8

    sources: ClassVar[tuple[str, ...]] = SOURCES
    in_environments: ClassVar[Mapping[str, Any]] = IN_ENVIRONMENTS
    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous", "discrete"})

    @classmethod
    def defaults_with(cls, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """The defaults that the preset in `values` brings, by the names of the parameters."""
        return PRESETS.get(str(values.get("preset")), {})

    @model_validator(mode="before")
    @classmethod
    def _fill_in_the_preset(cls, given: Any) -> Any:
        """Fill in the defaults of the preset. A value that is given wins, even if it is the class's own default."""
        if isinstance(given, ArgsKwargs):
            values = given.kwargs or {}
            return ArgsKwargs(given.args, {**cls.defaults_with(values), **values})
        return {**cls.defaults_with(given), **given}

    def __post_init__(self) -> None:
        """Check that minibatches have equal size, and that a rollout has as many decisions of each env.

        Raises:
            ValueError: `rollout` is not a multiple of `num_envs` and `batch_size`.
        """
        for name in ("num_envs", "batch_size"):
            if self.rollout % getattr(self, name):
                raise ValueError(f"rollout={self.rollout} is not a multiple of {name}={getattr(self, name)}")

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Policy:
        # Imported here: the settings above are checked before anything runs, and torch takes seconds.
        from stable_baselines3 import PPO

        from ..sb3.policies import policy_from
        from ..sb3.training import train

        return train(
            PPO, env, steps, seed, progress,
            lambda model: policy_from(model, self.activation, "ppo"),
            decisions_per_update=self.rollout,
            **self._settings(),
        )  # fmt: skip

    def _settings(self) -> dict[str, Any]:
        """The keyword arguments of the library's class."""
        from ..sb3.training import network

        return {
            "learning_rate": self._scheduled(self.learning_rate),
            "gamma": self.gamma,
            "batch_size": self.batch_size,
            "n_steps": self.rollout // self.num_envs,
            "n_epochs": self.epochs,
            "gae_lambda": self.gae_lambda,
            "clip_range": self._scheduled(self.clip_range),
            "ent_coef": self.ent_coef,
            "vf_coef": self.value_coef,
            "max_grad_norm": self.max_gradient,
            "policy_kwargs": {**network(self.net_arch, self.activation), "log_std_init": self.log_std},
        }

    def _scheduled(self, value: float) -> float | Callable[[float], float]:
        """A constant, or a function of the share of the training that remains, which falls to 0 at the end."""
        return value if self.schedule == "constant" else lambda remaining: value * remaining
