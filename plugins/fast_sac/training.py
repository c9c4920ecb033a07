"""A training: the learner, its replay buffer, and the env that fills it."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness import Float32, Mask
from harness.algorithm import (
    Progress,
    Ring,
    TrainingEnv,
    TrainingState,
    as_state,
    pack_generator,
    restore_generator,
    under,
)
from harness.policy import SquashedGaussian

from ..hyperparameters import SCALARS_EVERY, TOLD_EVERY
from ..soft_actor_critic import SoftActorCritic
from .network import Networks, Room, backward, count_parameters, draw_weights, forward, networks_in, product

LOWEST_LOG_STD, HIGHEST_LOG_STD = -20.0, 2.0
HALF_LOG_2_PI = 0.5 * float(np.log(2.0 * np.pi))
SMALL = 1e-6
"""Keeps the logarithm of 1 - a^2 finite where tanh is 1."""


class Draw(NamedTuple):
    """Actions, and the quantities from which they were computed."""

    action: Float32
    """In (-1, 1), (..., action_size)."""
    log_prob: Float32
    """Logarithm of their density, (...)."""
    noise: Float32
    """(..., action_size)."""
    std: Float32
    """(..., action_size)."""
    slope: Float32
    """Slope of tanh, 1 - a^2, (..., action_size)."""


def draw(output: Float32, noise: Float32) -> Draw:
    """Draw actions from the output of the actor's network.

    Args:
        output: Means and logarithms of the standard deviations side by side, (..., 2 * action_size).
        noise: Standard normal, (..., action_size).
    """
    size = noise.shape[-1]
    log_std = np.clip(output[..., size:], LOWEST_LOG_STD, HIGHEST_LOG_STD)
    std = np.exp(log_std)
    action: Float32 = np.tanh(output[..., :size] + std * noise)
    slope = 1.0 - action * action
    density = 0.5 * noise * noise + log_std + np.log(slope + SMALL)
    log_prob = -density.sum(axis=-1) - size * HALF_LOG_2_PI
    return Draw(action, log_prob, noise, std, slope)


def put_error(output: Float32, drawn: Draw, by_action: Float32, by_log_prob: float, error: Float32) -> None:
    """Compute the gradient of a loss by the network's output.

    Args:
        output: The output from which the actions were drawn, (rows, 2 * action_size).
        drawn: The draw from this output.
        by_action: Gradient of the loss by the actions, without their effect on log_prob, (rows, action_size).
        by_log_prob: Gradient of the loss by each log_prob.
        error: Gets the result, (rows, 2 * action_size).
    """
    size, slope = by_action.shape[-1], drawn.slope
    # log_prob falls with log(1 - tanh(u)^2), whose derivative by u is -2 tanh(u) (1 - tanh(u)^2) / (1 - tanh(u)^2)
    by_mean = slope * (by_action + 2.0 * by_log_prob * drawn.action / (slope + SMALL))
    error[:, :size] = by_mean
    error[:, size:] = by_mean * drawn.noise * drawn.std - by_log_prob
    log_std = output[:, size:]
    error[:, size:] *= (log_std >= LOWEST_LOG_STD) & (log_std <= HIGHEST_LOG_STD)  # beyond, it was clipped


class Batch(NamedTuple):
    """Transitions drawn from the buffer: views of one array, valid until the next draw.

    The inputs have the form that the networks take: action, observation and a 1 side by side for the critics, the same
    without the action for the actor. The learner overwrites the actions with those that the actor would take.
    """

    inputs: Float32
    """Before the decision and after it, (2, rows, action_size + observation_size + 1); after it the action is empty."""
    reward: Float32
    """What the decision was paid, (rows,)."""
    goes_on: Float32
    """0 where the decision terminated the episode, else 1, (rows,)."""


class Replay:
    """The last `capacity` transitions, in float32."""

    def __init__(self, capacity: int, observation_size: int, action_size: int) -> None:
        """Allocate room for all of them. The operating system provides the memory only when it is written."""
        self._action_size, self._width = action_size, action_size + observation_size + 1
        self._rows = np.empty((capacity, 2 * self._width + 2), np.float32)
        self._drawn = np.empty((0, 0), np.float32)
        self._written = self._next = self.size = 0

    def add(
        self,
        observation: Float32,
        action: Float32,
        following: Float32,
        reward: NDArray[np.floating],
        terminated: Mask,
    ) -> None:
        """Keep a decision of every env. If the buffer is full, it forgets the oldest transitions.

        Args:
            observation: What was observed before the decision, (num_envs, observation_size).
            action: The decision, (num_envs, action_size).
            following: What was observed after it, (num_envs, observation_size).
            reward: What it was paid, (num_envs,).
            terminated: Whether it terminated the episode, (num_envs,).
        """
        a, w, count = self._action_size, self._width, len(self._rows)
        where = np.arange(self._next, self._next + len(observation)) % count
        row = np.ones((len(observation), self._rows.shape[1]), np.float32)
        row[:, :a], row[:, a : w - 1] = action, observation
        row[:, w : w + a], row[:, w + a : 2 * w - 1] = 0.0, following
        row[:, -2], row[:, -1] = reward, ~terminated
        self._rows[where] = row
        self._next = (self._next + len(observation)) % count
        self.size = min(self.size + len(observation), count)
        self._written += len(observation)

    def ring(self) -> Ring:
        """The transitions in the buffer, for `restore`."""
        return Ring({"rows": self._rows}, self._written)

    def restore(self, ring: Ring) -> None:
        """Take over the transitions of the buffer that returned `ring`."""
        ring.copy_into({"rows": self._rows})
        self._written, self._next = ring.written, ring.written % len(self._rows)
        self.size = min(ring.written, len(self._rows))

    def draw(self, rows: int, rng: np.random.Generator) -> Batch:
        """Draw `rows` transitions, each with equal probability from those in the buffer."""
        if len(self._drawn) != rows:
            self._drawn = np.empty((rows, self._rows.shape[1]), np.float32)
        # "clip" clips nothing here: it is the mode that writes into `out` without a copy
        np.take(self._rows, rng.integers(0, self.size, rows), axis=0, out=self._drawn, mode="clip")
        inputs = self._drawn[:, :-2].reshape(rows, 2, self._width).swapaxes(0, 1)
        return Batch(inputs, self._drawn[:, -2], self._drawn[:, -1])


BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-8


class Adam:
    """Gradient descent with moments (Kingma and Ba 2015), in as few passes over memory as numpy can.

    The moments are kept without their factors 1 - beta, which the step size makes up for.
    """

    def __init__(self, parameters: Float32, gradient: Float32, learning_rate: float) -> None:
        """Begin with `parameters`, (size,). Each step changes them in place by what stands in `gradient`, (size,)."""
        self._parameters, self._gradient, self._learning_rate = parameters, gradient, learning_rate
        self._first, self._second = np.zeros_like(parameters), np.zeros_like(parameters)
        self._room = np.empty_like(parameters)
        self._steps = 0

    def state(self) -> TrainingState:
        """Everything that `restore` needs, the parameters included."""
        return as_state(
            {"parameters": self._parameters, "first": self._first, "second": self._second, "steps": self._steps}
        )

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._parameters[...], self._steps = state["parameters"], int(state["steps"])
        self._first[...], self._second[...] = state["first"], state["second"]

    def step(self) -> None:
        """One step down the gradient."""
        self._steps += 1
        first, second, room = self._first, self._second, self._room
        np.multiply(first, BETA_1, out=first)
        np.add(first, self._gradient, out=first)
        np.multiply(self._gradient, self._gradient, out=room)
        np.multiply(second, BETA_2, out=second)
        np.add(second, room, out=second)
        # first * c1 / (sqrt(second * c2) + epsilon), with one multiplication for both corrections
        correction_1 = (1.0 - BETA_1) / (1.0 - BETA_1**self._steps)
        correction_2 = float(np.sqrt((1.0 - BETA_2) / (1.0 - BETA_2**self._steps)))
        np.sqrt(second, out=room)
        np.add(room, EPSILON / correction_2, out=room)
        np.divide(first, room, out=room)
        np.multiply(room, self._learning_rate * correction_1 / correction_2, out=room)
        np.subtract(self._parameters, room, out=self._parameters)


class EntropyCoefficient:
    """The entropy coefficient. Its logarithm is learned, so that it stays positive. A fixed one may be 0."""

    def __init__(self, settings: SoftActorCritic, action_size: int) -> None:
        """Begin as the settings say. The target of the entropy is -action_size, in nats."""
        self.value = settings.first_coefficient
        self._learns, self._aim = settings.learns_coefficient, -action_size
        self._logarithm = np.array([np.log(self.value)] if self._learns else [0.0], np.float32)
        self._gradient = np.empty(1, np.float32)
        self._descent = Adam(self._logarithm, self._gradient, settings.learning_rate)

    def state(self) -> TrainingState:
        """Everything that `restore` needs."""
        return {**self._descent.state(), **as_state({"value": self.value})}

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._descent.restore(state)
        self.value = float(state["value"])

    def learn(self, entropy: float) -> None:
        """Learn once, if the coefficient is learned. It rises if `entropy`, in nats, is less than its target."""
        if self._learns:
            self._gradient[0] = entropy - self._aim
            self._descent.step()
            self.value = float(np.exp(self._logarithm[0]))


class Losses(NamedTuple):
    """The losses of one update, and the entropy."""

    policy: float
    value: float
    """Half the mean squared error, summed over both critics."""
    entropy: float
    """Entropy of the actions that the actor would draw, in nats, estimated from one draw per observation."""


class Trained:
    """Networks with their gradients and their optimiser."""

    def __init__(self, count: int, sizes: Sequence[int], learning_rate: float, rng: np.random.Generator) -> None:
        """Draw the first weights."""
        self.parameters = np.empty(count_parameters(count, sizes), np.float32)
        self.networks = networks_in(self.parameters, count, sizes)
        draw_weights(self.networks, rng)
        gradient = np.empty_like(self.parameters)
        self.gradient = networks_in(gradient, count, sizes)
        self.descent = Adam(self.parameters, gradient, learning_rate)


class Learner:
    """An actor, two critics side by side, their target networks, and the entropy coefficient.

    In an update the critics learn first. The actor then learns from the new critics, as in stable-baselines3. Both use
    the coefficient from before the update.
    """

    def __init__(
        self, settings: SoftActorCritic, observation_size: int, action_size: int, rng: np.random.Generator
    ) -> None:
        """Begin with weights drawn from `rng`. All noise is drawn from it later."""
        self._settings, self._rng = settings, rng
        self._action_size = action_size
        actor = [observation_size, *settings.net_arch, 2 * action_size]
        critic = [action_size + observation_size, *settings.net_arch, 1]
        self._actor = Trained(1, actor, settings.learning_rate, rng)
        self._critics = Trained(2, critic, settings.learning_rate, rng)
        self._target_parameters = self._critics.parameters.copy()
        self._targets = networks_in(self._target_parameters, 2, critic)
        self._lag = np.empty_like(self._target_parameters)
        self._coefficient = EntropyCoefficient(settings, action_size)
        # The actor gets the observations before a decision first, then those after it.
        self._actor_room = Room.of(2, settings.batch_size, actor)
        self._critic_room = Room.of(2, settings.batch_size, critic)

    @property
    def actor(self) -> Networks:
        """The one network of the policy: means and logarithms of the standard deviations side by side."""
        return self._actor.networks

    @property
    def coefficient(self) -> float:
        """What a nat of entropy is worth."""
        return self._coefficient.value

    def state(self) -> TrainingState:
        """Everything that `restore` needs, except the random generator."""
        return as_state(
            {
                "actor": self._actor.descent.state(),
                "critics": self._critics.descent.state(),
                "coefficient": self._coefficient.state(),
                "targets": self._target_parameters,
            }
        )

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._actor.descent.restore(under("actor.", state))
        self._critics.descent.restore(under("critics.", state))
        self._coefficient.restore(under("coefficient.", state))
        self._target_parameters[...] = state["targets"]

    def update(self, batch: Batch) -> Losses:
        """Learn once from transitions. Their actions are overwritten."""
        settings, coefficient, size = self._settings, self.coefficient, self._action_size
        now, following = batch.inputs
        output = forward(self.actor, settings.activation, batch.inputs[..., size:], self._actor_room)
        drawn = draw(output, self._rng.standard_normal((*batch.inputs.shape[:2], size), dtype=np.float32))
        following[:, :size] = drawn.action[1]
        value = self._least(self._targets, following) - coefficient * drawn.log_prob[1]
        value_loss = self._improve_critics(now, batch.reward + settings.gamma * batch.goes_on * value)
        now[:, :size] = drawn.action[0]
        expected = self._improve_actor(now, Draw(*(part[0] for part in drawn)), coefficient)
        entropy = -float(drawn.log_prob[0].mean())
        self._coefficient.learn(entropy)
        self._follow()
        return Losses(-coefficient * entropy - expected, value_loss, entropy)

    def _least(self, critics: Networks, inputs: Float32) -> Float32:
        """The lesser of both critics' values, (rows,)."""
        values = forward(critics, self._settings.activation, inputs, self._critic_room)
        return np.minimum(values[0, :, 0], values[1, :, 0])

    def _improve_critics(self, inputs: Float32, target: Float32) -> float:
        """Move both critics towards `target`, (rows,), for `inputs`, (rows, into + 1); returns the loss."""
        values = forward(self._critics.networks, self._settings.activation, inputs, self._critic_room)
        error = self._critic_room.error[-1]
        np.subtract(values, target[:, np.newaxis], out=error)
        loss = 0.5 * float(np.vdot(error, error)) / len(target)
        error /= len(target)
        backward(self._critics.networks, inputs, self._critic_room, self._critics.gradient)
        self._critics.descent.step()
        return loss

    def _improve_actor(self, inputs: Float32, drawn: Draw, coefficient: float) -> float:
        """Move the actor to where the lesser critic and the entropy are higher; returns the lesser critic's mean.

        Args:
            inputs: The drawn actions and observations side by side, (rows, into + 1).
            drawn: Those actions, of the first half of the last pass through the actor.
            coefficient: What a nat of entropy is worth.
        """
        rows, critics, room = len(inputs), self._critics.networks, self._critic_room
        expected = float(self._least(critics, inputs).mean())
        first, second = room.value[-1]
        np.less_equal(first, second, out=room.error[-1][0], casting="unsafe")
        np.subtract(1.0, room.error[-1][0], out=room.error[-1][1])
        room.error[-1][...] /= -rows
        hidden = backward(critics, inputs, room, None)
        by_action = product(hidden, critics[0][:, : self._action_size].swapaxes(-1, -2)).sum(axis=0)
        half = self._actor_room.first()
        put_error(half.value[-1][0], drawn, by_action, coefficient / rows, half.error[-1][0])
        backward(self.actor, inputs[:, self._action_size :], half, self._actor.gradient)
        self._actor.descent.step()
        return expected

    def _follow(self) -> None:
        """Move the target networks towards the critics by the share `tau` of the difference."""
        np.subtract(self._critics.parameters, self._target_parameters, out=self._lag)
        np.multiply(self._lag, self._settings.tau, out=self._lag)
        np.add(self._target_parameters, self._lag, out=self._target_parameters)


COUNTERS = ("rounds", "decisions", "told", "scalars_told")
"""The counters of a training, which a checkpoint holds."""


class Training:
    """One training; see `harness.algorithm.Algorithm.train`."""

    def __init__(self, settings: SoftActorCritic, env: TrainingEnv, steps: int, seed: int, progress: Progress) -> None:
        """Make the learner, the replay buffer and what else the training needs."""
        self._settings, self._env, self._steps, self._progress = settings, env, steps, progress
        self._rng = np.random.default_rng(seed)
        observation_size, action_size = _sizes(env)
        self._learner = Learner(settings, observation_size, action_size, self._rng)
        self._replay = Replay(min(settings.buffer_size, steps), observation_size, action_size)
        self._room = Room.of(1, env.num_envs, [observation_size, *settings.net_arch, 2 * action_size])
        self._observed = np.ones((env.num_envs, observation_size + 1), np.float32)
        self._action_shape = env.num_envs, action_size
        self._losses: Losses | None = None
        self._before, self._rounds, self._decisions = env.environment_steps, 0, 0
        self._told = self._scalars_told = 0

    def run(self) -> SquashedGaussian:
        """Train until the budget of environment steps is spent; returns the policy."""
        settings, progress = self._settings, self._progress
        observation = self._begin(progress.restored())
        while self._done < self._steps:
            observation = self._decide(observation)
            self._rounds += 1
            if self._rounds % settings.train_freq == 0 and self._decisions > settings.learning_starts:
                self._learn()
            self._tell()
            progress.checkpoint(self._done, partial(self._state, observation))
        self._tell(at_the_end=True)
        return self._policy()

    def _state(self, observation: Float32) -> TrainingState:
        """Everything that `_begin` needs; `observation` is the one for the next decision."""
        own = {name: getattr(self, f"_{name}") for name in COUNTERS}
        if self._losses is not None:
            own["losses"] = self._losses
        return as_state(
            {
                **own,
                "done": self._done,
                "observation": observation,
                "rng": pack_generator(self._rng),
                "learner": self._learner.state(),
                "replay": self._replay.ring(),
            }
        )

    def _begin(self, state: TrainingState | None) -> Float32:
        """Start, or go on from `state`; returns the observation for the next decision."""
        if state is None:
            return self._env.reset()[0]
        for name in COUNTERS:
            setattr(self, f"_{name}", int(state[name]))
        self._losses = Losses(*state["losses"].tolist()) if "losses" in state else None
        self._before = self._env.environment_steps - int(state["done"])
        restore_generator(self._rng, state["rng"])
        self._learner.restore(under("learner.", state))
        self._replay.restore(state["replay"])
        observation: Float32 = state["observation"]
        return observation

    @property
    def _done(self) -> int:
        return self._env.environment_steps - self._before

    def _decide(self, observation: Float32) -> Float32:
        """One decision in every env, kept for replay; returns what is observed next."""
        action = self._act(observation)
        following, reward, terminated, truncated, infos = self._env.step(action)
        ended = terminated | truncated
        last = following
        if ended.any():  # the env is in its next episode already
            last = np.where(ended[:, np.newaxis], infos["final_obs"], following)
        self._replay.add(observation, action, last, reward, terminated)
        self._decisions += len(action)
        return following

    def _act(self, observation: Float32) -> Float32:
        """Actions, (num_envs, action_size): at random at the beginning, later drawn by the actor."""
        if self._decisions < self._settings.learning_starts:
            return self._rng.uniform(-1.0, 1.0, self._action_shape).astype(np.float32)
        self._observed[:, :-1] = observation
        output = forward(self._learner.actor, self._settings.activation, self._observed, self._room)[0]
        return draw(output, self._rng.standard_normal(self._action_shape, dtype=np.float32)).action

    def _learn(self) -> None:
        """Do the updates that are due."""
        settings = self._settings
        updates = settings.gradient_steps if settings.gradient_steps >= 0 else settings.train_freq * settings.num_envs
        for _ in range(updates):
            self._losses = self._learner.update(self._replay.draw(settings.batch_size, self._rng))

    def _tell(self, at_the_end: bool = False) -> None:
        done = self._done
        self._progress.policy(done, self._policy)
        if at_the_end or done >= self._told + TOLD_EVERY:
            self._told = done
            self._progress(done)
        if done >= self._scalars_told + (1 if at_the_end else SCALARS_EVERY):
            self._scalars_told = done
            self._progress.scalars(done, self._told_by(self._losses))

    def _told_by(self, losses: Losses | None) -> dict[str, float]:
        if losses is None:
            return {}
        return {
            "Losses/Policy Loss": losses.policy,
            "Losses/Value Loss": losses.value,
            "Policy/Entropy": losses.entropy,
            "Policy/Continuous Entropy Coeff": self._learner.coefficient,
            "Policy/Learning Rate": self._settings.learning_rate,
        }

    def _policy(self) -> SquashedGaussian:
        """The present policy."""
        space: Any = self._env.single_action_space
        box = tuple(space.low.tolist()), tuple(space.high.tolist())
        return SquashedGaussian(_weights(self._learner.actor), self._settings.activation, *box, algorithm="sac-fast")


def _sizes(env: TrainingEnv) -> tuple[int, int]:
    observation, action = env.single_observation_space.shape, env.single_action_space.shape
    assert observation is not None
    assert action is not None
    return observation[0], action[0]


def _weights(actor: Networks) -> dict[str, Float32]:
    """Copies of the actor's weights, under the names that policies give them."""
    layers = [(weight[0, :-1].T, weight[0, -1]) for weight in actor]
    named = {f"hidden.{index}": layer for index, layer in enumerate(layers[:-1])}
    weight, bias = layers[-1]
    half = len(bias) // 2
    named |= {"mean": (weight[:half], bias[:half]), "log_std": (weight[half:], bias[half:])}
    return {
        f"{name}.{part}": np.array(array, order="C")
        for name, layer in named.items()
        for part, array in zip(("weight", "bias"), layer, strict=True)
    }
