"""Soft actor-critic, one update after the other (Haarnoja et al. 2018, with a learned entropy coefficient)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from harness.arrays import Float32
from harness.progress import TrainingState, as_state, prefixed, under

from ..soft_actor_critic import SoftActorCritic
from .actor import Draw, draw, put_error
from .adam import Adam
from .coefficient import EntropyCoefficient
from .network import (
    Networks,
    Room,
    backward,
    count_parameters,
    draw_weights,
    forward,
    networks_in,
)
from .replay import Batch


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
        return {
            **prefixed("actor.", self._actor.descent.state()),
            **prefixed("critics.", self._critics.descent.state()),
            **prefixed("coefficient.", self._coefficient.state()),
            **as_state({"targets": self._target_parameters}),
        }

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
        drawn = draw(output, self._noise(batch))
        following[:, :size] = drawn.action[1]
        value = self._least(self._targets, following) - coefficient * drawn.log_prob[1]
        value_loss = self._improve_critics(now, batch.reward + settings.gamma * batch.goes_on * value)
        now[:, :size] = drawn.action[0]
        expected = self._improve_actor(now, Draw(*(part[0] for part in drawn)), coefficient)
        entropy = -float(drawn.log_prob[0].mean())
        self._coefficient.learn(entropy)
        self._follow()
        return Losses(-coefficient * entropy - expected, value_loss, entropy)

    def _noise(self, batch: Batch) -> Float32:
        return self._rng.standard_normal((*batch.inputs.shape[:2], self._action_size), dtype=np.float32)

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
        by_action = np.matmul(hidden, critics[0][:, : self._action_size].swapaxes(-1, -2)).sum(axis=0)
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
