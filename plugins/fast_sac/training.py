"""A training: the learner, its replay buffer, and the env that fills it."""

from functools import partial
from typing import Any

import numpy as np

from harness.algorithm import TrainingEnv
from harness.arrays import Float32
from harness.authoring.generator_state import pack_generator, restore_generator
from harness.policy import SquashedGaussian
from harness.progress import SCALARS_EVERY, TOLD_EVERY, Progress, TrainingState, as_state, prefixed, under

from ..episode_means import EpisodeMeans
from ..soft_actor_critic import SoftActorCritic
from .actor import draw
from .learner import Learner, Losses
from .network import Networks, Room, forward
from .replay import Replay

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
        self._means = EpisodeMeans(env.num_envs)
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
        return {
            **as_state({**own, "done": self._done, "observation": observation, "rng": pack_generator(self._rng)}),
            **prefixed("learner.", self._learner.state()),
            **prefixed("means.", self._means.state()),
            "replay": self._replay.ring(),
        }

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
        self._means.restore(under("means.", state))
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
        self._means.watch(reward, ended)
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
            self._progress.scalars(done, {**self._means.take(), **self._told_by(self._losses)})

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
