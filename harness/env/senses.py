"""Noise and delays, in whole control periods, between the world and the learner."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.conditions import Conditions
from harness.env.episodes import Episodes
from harness.progress import TrainingState, as_state
from harness.robot import Robot

BLOCK = 128
"""How many steps' noise is drawn at once."""
NOISE = 0
"""What the generator of a block is for, see `Senses`."""

Draw = Callable[[int, int, int], np.random.Generator]
"""Env, purpose, number: the generator of the env's present episode for that."""


class Senses:
    """Stands between the episodes and the learner: adds noise and delays.

    The noise of a step is drawn from the env's own stream by the number of the step alone: it is the same in any batch,
    under every reward, and however often one looks.
    """

    def __init__(self, conditions: Conditions, robot: Robot, episodes: Episodes, action_size: int, draw: Draw) -> None:
        """Read `episodes`, which are not changed.

        Args:
            conditions: How noisy, how late.
            robot: The arm as it is drawn, whose kinematics the learner is told.
            episodes: As they are.
            action_size: Length of an action.
            draw: See `Draw`.
        """
        self._conditions, self._robot, self._episodes, self._draw = conditions, robot, episodes, draw
        n = len(episodes.matrix)
        self.seen = episodes.another()
        self._history = np.zeros((conditions.observation_delay + 1, *episodes.matrix.shape))
        self._queue = np.zeros((conditions.action_delay, n, action_size))
        self._noisy = conditions.is_noisy
        deviations = (
            conditions.joint_noise * robot.per_radian,
            conditions.speed_noise * robot.per_radian,
            conditions.speed_noise * np.sqrt(2.0) * robot.per_radian,
            np.full(3, conditions.target_noise),
            np.full(action_size, conditions.action_noise),
        )
        self._deviation = np.concatenate(deviations)
        self._places = np.cumsum([len(deviation) for deviation in deviations])[:-1]
        self._noise = np.zeros((n, BLOCK, len(self._deviation)))
        self._blocks = np.full(n, -1)

    def begin(self, mask: Mask, resting: Float) -> None:
        """New episodes in the envs of `mask`: they were always as they are now, and `resting`, (num_envs, action_size).

        Args:
            mask: (num_envs,).
            resting: Actions that leave the arms where they are.
        """
        self._history[:, mask] = self._episodes.matrix[mask]
        self._queue[:, mask] = resting[mask]
        self._blocks[mask] = -1

    def push(self, active: Mask | None) -> None:
        """Note that a control period is over, in the envs that are `active`; None: in all."""
        history, matrix = self._history, self._episodes.matrix
        where = slice(None) if active is None else active
        if len(history) > 1:
            history[1:, where] = history[:-1, where]
        history[0, where] = matrix[where]

    def act(self, wanted: Float, active: Mask | None) -> Float:
        """The actions of this control period, if the learner wants `wanted`, (num_envs, action_size)."""
        done = wanted
        if len(self._queue):
            done, where = self._queue[-1].copy(), slice(None) if active is None else active
            self._queue[1:, where] = self._queue[:-1, where]
            self._queue[0, where] = wanted[where]
        if self._conditions.action_noise > 0.0:
            done = np.clip(done + self._noise_now()[4], -1.0, 1.0)
        return done

    def look(self) -> Episodes:
        """The episodes as they are seen now; valid until the next look."""
        seen, conditions = self.seen, self._conditions
        seen.matrix[...] = self._history[-1]
        if self._noisy:
            joints, speeds, changes, target, _ = self._noise_now()
            seen.qpos += joints
            seen.qvel += speeds
            seen.qvel_change += changes
            seen.target += target
        if conditions.joint_noise > 0.0 or conditions.length_variation > 0.0:
            # What an arm knows of its end effector follows from its joint angles and its drawing.
            seen.end_effector[...] = self._robot.end_effector(seen.qpos)
        if self._noisy or conditions.length_variation > 0.0:
            seen.measure_offset()
        return seen

    def state(self) -> TrainingState:
        """Everything that `restore` needs; noise follows from the streams."""
        return as_state({"history": self._history.copy(), "queue": self._queue.copy()})

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._history[...], self._queue[...] = state["history"], state["queue"]
        self._blocks[:] = -1

    def _noise_now(self) -> list[NDArray[np.float64]]:
        """The noise of joints, speeds, their changes, target and action in the present steps, (num_envs, ...) each."""
        steps = self._episodes.step.astype(int)
        blocks = steps // BLOCK
        for k in np.flatnonzero(blocks != self._blocks):
            rng = self._draw(int(k), NOISE, int(blocks[k]))
            self._noise[k] = rng.standard_normal(self._noise.shape[1:]) * self._deviation
        self._blocks[:] = blocks
        return np.split(self._noise[np.arange(len(steps)), steps % BLOCK], self._places, axis=1)
