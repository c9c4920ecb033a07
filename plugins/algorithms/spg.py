"""The stochastic policy gradient of the NOTE, in this one file: REINFORCE with rewards-to-go and a learned baseline.

The training maximises eq. 12, J(theta) = E[sum_k gamma^k R(s_k, a_k)], by gradient ascent along eq. 11,

    grad J = E[ sum_t  grad log pi_theta(a_t | s_t)  (G_t - b(s_t)) ],    G_t = sum_(k >= t) gamma^(k - t) R(s_k, a_k)

The identity of eq. 10 turns eq. 8 into this expectation, which trials estimate. G_t takes the place of R(s, a) in
eq. 11, because what was paid before an action does not depend on the action. The baseline b(s) does not depend on the
action either. So it does not change the expectation, and it reduces the noise.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, TypeAlias

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness import Float32, Mask
from harness.algorithm import (
    ActionSpace,
    Progress,
    TrainingEnv,
    TrainingState,
    as_state,
    pack_generator,
    restore_generator,
    under,
)
from harness.policy import Gaussian

from ..hyperparameters import IN_ENVIRONMENTS, NumEnvs
from ..torch_state import pack_optimizer, pack_tensors, restore_optimizer, restore_tensors

if TYPE_CHECKING:
    from torch import Tensor
    from torch.optim import Optimizer


Positive = Annotated[float, Field(gt=0)]
Count = Annotated[int, Field(gt=0)]
Net: TypeAlias = "dict[str, Tensor]"
"""Linear layers, ``NAME.weight`` (out, into) and ``NAME.bias`` (out,), in the order in which they act."""

LOG_2_PI = float(np.log(2.0 * np.pi))
SMALL = 0.01
"""Scale of the last layer's first weights: a policy begins with means near 0, the middle of the action box."""


class Segment(NamedTuple):
    """What all envs did from one update to the next; the first axis is time, the second the env."""

    observation: Float32
    """Before the action, (T, num_envs, observation_size)."""
    action: Float32
    """The action as drawn from eq. 37, (T, num_envs, action_size); the env gets it clipped to its box."""
    reward: Float32
    """(T, num_envs)."""
    ended: Mask
    """Whether the episode ended here, terminated or truncated, (T, num_envs)."""
    last: Float32
    """What is observed after the last decision, (num_envs, observation_size)."""


# ---------------------------------------------------------------------------------------------------- the equations


def log_prob(policy: Net, activation: str, observation: "Tensor", action: "Tensor") -> "Tensor":
    """Logarithm of pi_theta(a | s), of NOTE eq. 37, with a diagonal Sigma that does not depend on s.

    Args:
        policy: theta: the layers of mu_theta, and ``log_std``, half the logarithms of Sigma's diagonal.
        activation: Between the layers.
        observation: s, (..., observation_size).
        action: a, (..., action_size).

    Returns:
        (...).
    """
    log_std = policy["log_std"]
    distance = (action - forward(policy, activation, observation)) / log_std.exp()
    log_probability: Tensor = -(0.5 * distance**2 + log_std + 0.5 * LOG_2_PI).sum(dim=-1)
    return log_probability


def rewards_to_go(reward: Float32, ended: Mask, rest: Float32, gamma: float) -> Float32:
    """G_t: what is paid from decision t to the end of its episode, discounted as in NOTE eq. 12.

    A truncated episode has ended like any other: the H of eq. 12 is the task's horizon.

    Args:
        reward: (T, num_envs).
        ended: Where episodes ended, (T, num_envs).
        rest: The G that is expected after the last decision, (num_envs,). It counts where the episode goes on.
        gamma: Discount of a decision.

    Returns:
        (T, num_envs).
    """
    to_go, following = np.empty_like(reward), rest
    for t in reversed(range(len(reward))):
        following = reward[t] + np.float32(gamma) * np.where(ended[t], np.float32(0.0), following)
        to_go[t] = following
    return to_go


def discounts(ended: Mask, gamma: float) -> Float32:
    """gamma^t, (T, num_envs), with t counted from the start of each episode. Every env begins with a new episode."""
    discount, now = np.empty(ended.shape, np.float32), np.ones(ended.shape[1], np.float32)
    for t, here in enumerate(ended):
        discount[t] = now
        now = np.where(here, np.float32(1.0), now * np.float32(gamma))
    return discount


def surrogate(log_probability: "Tensor", weight: "Tensor") -> "Tensor":
    """The number whose gradient by theta is the estimate of eq. 11: the mean of weight * log pi.

    Args:
        log_probability: log pi_theta(a_t | s_t), any shape.
        weight: G_t - b(s_t), the same shape; it does not depend on theta.
    """
    return (weight * log_probability).mean()


# --------------------------------------------------------------------------------------------------------- the nets


def forward(net: Net, activation: str, values: "Tensor") -> "Tensor":
    """The output of `net`, (..., out), for inputs `values`, (..., into); the activation acts between the layers."""
    layers = [name.removesuffix(".weight") for name in net if name.endswith(".weight")]
    for index, layer in enumerate(layers):
        values = values if index == 0 else getattr(values, activation)()
        values = values @ net[f"{layer}.weight"].T + net[f"{layer}.bias"]
    return values


def draw_layers(sizes: Sequence[int], last: str, scale: float, rng: np.random.Generator) -> dict[str, Float32]:
    """First weights of layers ``hidden.0``, ``hidden.1``, ... and `last`, whose weights are scaled by `scale`."""
    names = [*(f"hidden.{index}" for index in range(len(sizes) - 2)), last]
    layers: dict[str, Float32] = {}
    for name, into, out in zip(names, sizes, sizes[1:], strict=False):
        spread = (scale if name == last else 1.0) / np.sqrt(into)
        layers[f"{name}.weight"] = (spread * rng.standard_normal((out, into))).astype(np.float32)
        layers[f"{name}.bias"] = np.zeros(out, np.float32)
    return layers


# -------------------------------------------------------------------------------------------------------- the training


@dataclass(frozen=True)
class Spg:
    """The NOTE's stochastic policy gradient (REINFORCE, rewards-to-go, learned baseline), on the CPU.

    If an update comes in the middle of an episode, the baseline estimates what follows, and the episode goes on under
    the new policy. If `decisions` is the length of a whole episode and `restart` is 1, only whole episodes count, as in
    eq. 11.

    The discount is low on purpose. Under a reward that charges every step, a learner that looks far ahead first finds
    that the ground ends the charges.
    """

    learning_rate: Annotated[Positive, Field(description="step size of the policy (Adam)")] = 5e-3
    gamma: Annotated[float, Field(ge=0, le=1, description="discount factor per decision, 0 to 1, NOTE eq. 12")] = 0.8
    net_arch: Annotated[
        tuple[Count, ...], Field(min_length=1, description="sizes of the hidden layers of policy and baseline")
    ] = (
        64,
        64,
    )
    activation: Annotated[Literal["relu", "tanh"], Field(description="activation function between the layers")] = "tanh"
    std: Annotated[Positive, Field(description="standard deviation of the first actions, NOTE eq. 37")] = 0.6
    baseline: Annotated[bool, Field(description="whether a baseline b(s) is learned; without it, b = 0")] = True
    baseline_learning_rate: Annotated[Positive, Field(description="step size of the baseline (Adam)")] = 1e-2
    baseline_updates: Annotated[
        Count, Field(description="gradient steps of the baseline per gradient step of the policy")
    ] = 10
    normalize: Annotated[
        bool, Field(description="whether return minus baseline, G - b, gets mean 0 and standard deviation 1")
    ] = True
    discount_states: Annotated[
        bool,
        Field(description="whether gamma^t weighs decision t: the exact gradient of eq. 12, blind to late decisions"),
    ] = False
    decisions: Annotated[Count, Field(description="decisions in each environment between updates")] = 20
    restart: Annotated[Count, Field(description="updates after which all environments start new episodes")] = 20
    num_envs: NumEnvs = 16

    sources: ClassVar[tuple[str, ...]] = ("harness_plugins.torch_state",)
    in_environments: ClassVar[Mapping[str, Any]] = IN_ENVIRONMENTS
    action_spaces: ClassVar[frozenset[ActionSpace]] = frozenset({"continuous"})

    def train(self, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> Gaussian:
        import torch  # here: the settings are checked before anything runs, and torch takes seconds

        torch.set_num_threads(1)
        learner = Learner(self, env, seed)
        state = progress.restored()
        done = 0 if state is None else learner.restore(state)
        before = env.environment_steps - done
        while done < steps:
            learner.begin()
            losses = learner.update(learner.collect(before + steps))
            done = env.environment_steps - before
            learner.tell(progress, done, losses)
            progress.checkpoint(done, partial(learner.state, done))
        return learner.policy()


class Learner:
    """One training: the nets, their optimisers, the random numbers, and the env that they learn on."""

    _observation: Float32

    def __init__(self, settings: Spg, env: TrainingEnv, seed: int) -> None:
        import torch

        self._settings, self._env, self._rng = settings, env, np.random.default_rng(seed)
        box: Any = env.single_action_space
        self._low, self._high = box.low, box.high
        sizes = [int(np.prod(env.single_observation_space.shape or ())), *settings.net_arch]
        policy = draw_layers([*sizes, len(box.low)], "mean", SMALL, self._rng)
        policy["log_std"] = np.full(len(box.low), np.log(settings.std), np.float32)
        self._policy = _learnable(policy)
        self._baseline = _learnable(draw_layers([*sizes, 1], "value", SMALL, self._rng))
        self._ascent = torch.optim.Adam(self._policy.values(), settings.learning_rate, maximize=True)
        self._descent = torch.optim.Adam(self._baseline.values(), settings.baseline_learning_rate)
        self._updates = 0

    def begin(self) -> None:
        """Start a new episode in every env, once in `restart` updates."""
        if self._updates % self._settings.restart == 0:
            self._observation, _ = self._env.reset()

    def collect(self, until: int) -> Segment:
        """Let the policy decide, until the next update or until the env has done `until` steps in all."""
        env = self._env
        rows: list[tuple[Float32, Float32, Float32, Mask]] = []
        while len(rows) < self._settings.decisions and env.environment_steps < until:
            action = self._draw(self._observation)
            following, reward, terminated, truncated, _ = env.step(np.clip(action, self._low, self._high))
            rows.append((self._observation, action, reward.astype(np.float32), terminated | truncated))
            self._observation = following
        observation, actions, rewards, ended = (np.stack(column) for column in zip(*rows, strict=True))
        return Segment(observation, actions, rewards, ended, self._observation)

    def update(self, segment: Segment) -> dict[str, float]:
        """One step of gradient ascent for the policy, then some of descent for the baseline; returns their losses."""
        import torch

        settings, observation = self._settings, torch.as_tensor(segment.observation)
        self._updates += 1
        expected, rest = self._value(segment.observation), self._value(segment.last)
        to_go = rewards_to_go(segment.reward, segment.ended, rest, settings.gamma)
        weight = to_go - expected
        if settings.normalize:
            weight = (weight - weight.mean()) / (weight.std() + np.float32(1e-8))
        if settings.discount_states:
            weight = weight * discounts(segment.ended, settings.gamma)
        likely = log_prob(self._policy, settings.activation, observation, torch.as_tensor(segment.action))
        objective = surrogate(likely, torch.as_tensor(weight))
        _climb(self._ascent, objective)
        losses = {"Losses/Policy Loss": -float(objective.detach())}
        if settings.baseline:
            losses["Losses/Value Loss"] = self._fit_baseline(observation, torch.as_tensor(to_go))
        return losses

    def tell(self, progress: Progress, done: int, losses: Mapping[str, float]) -> None:
        """Report the steps done, the policy and the scalars after an update."""
        progress(done)
        progress.policy(done, self.policy)
        entropy = float((self._policy["log_std"] + 0.5 * (LOG_2_PI + 1.0)).sum().detach())
        progress.scalars(done, {"Policy/Entropy": entropy, **losses})

    def policy(self) -> Gaussian:
        """The present policy."""
        box = tuple(self._low.tolist()), tuple(self._high.tolist())
        return Gaussian(pack_tensors(self._policy), self._settings.activation, *box, algorithm="spg")

    def state(self, done: int) -> TrainingState:
        """All that `restore` needs to go on."""
        arrays = {
            "done": done,
            "updates": self._updates,
            "observation": self._observation,
            "rng": pack_generator(self._rng),
        }
        for name, net, optimizer in self._parts():
            arrays[name] = {**pack_tensors(net), "adam": pack_optimizer(optimizer)}
        return as_state(arrays)

    def restore(self, state: TrainingState) -> int:
        """Go on from `state`, which the method of this name returned; returns the steps that were done."""
        self._updates, self._observation = int(state["updates"]), state["observation"]
        restore_generator(self._rng, state["rng"])
        for name, net, optimizer in self._parts():
            restore_tensors(net, under(f"{name}.", state))
            restore_optimizer(optimizer, under(f"{name}.adam.", state))
        return int(state["done"])

    def _parts(self) -> "list[tuple[str, Net, Optimizer]]":
        return [("policy", self._policy, self._ascent), ("baseline", self._baseline, self._descent)]

    def _draw(self, observation: Float32) -> Float32:
        """Actions from the Gaussian of eq. 37, (num_envs, action_size)."""
        import torch

        with torch.no_grad():
            mean = forward(self._policy, self._settings.activation, torch.as_tensor(observation)).numpy()
            std = self._policy["log_std"].exp().numpy()
        action: Float32 = mean + std * self._rng.standard_normal(mean.shape, dtype=np.float32)
        return action

    def _value(self, observation: Float32) -> Float32:
        """b(s) of observations (..., observation_size), (...); 0 without a baseline."""
        import torch

        if not self._settings.baseline:
            return np.zeros(observation.shape[:-1], np.float32)
        with torch.no_grad():
            value = forward(self._baseline, self._settings.activation, torch.as_tensor(observation))
        expected: Float32 = value[..., 0].numpy()
        return expected

    def _fit_baseline(self, observation: "Tensor", to_go: "Tensor") -> float:
        """Bring b(s) nearer to the G that followed s, by least squares; returns the loss before the first step."""
        first = 0.0
        for update in range(self._settings.baseline_updates):
            value = forward(self._baseline, self._settings.activation, observation)[..., 0]
            loss = ((value - to_go) ** 2).mean()
            first = float(loss.detach()) if update == 0 else first
            _climb(self._descent, loss)
        return first


def _climb(optimizer: "Optimizer", objective: "Tensor") -> None:
    """One step of the optimiser along the gradient of `objective`: upwards if it maximises, else downwards."""
    optimizer.zero_grad()
    objective.backward()  # type: ignore[no-untyped-call]
    optimizer.step()


def _learnable(layers: Mapping[str, Float32]) -> Net:
    import torch

    return {name: torch.from_numpy(weight).requires_grad_() for name, weight in layers.items()}
