"""Where the episodes of a batch stand: one matrix, whose first columns are the row that a trace records."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import SimulationDiverged
from harness.record.trace import COLUMN, SCALARS
from harness.reward import Sample
from harness.simulator import State


class Episodes:
    """`num_envs` episodes side by side. Every array below is a view into `matrix`, which has a row per env.

    Attributes:
        matrix: (num_envs, width): the row to record, then qvel, qvel_change and offset.
        record: The row to record, (num_envs, recorded width); columns as in `harness.record.trace`.
        episode: Number of the episode in its env, (num_envs,).
        step: Environment steps since its start.
        begin_distance: d(0), or the distance when the target was last set, [m].
        previous_best: The smallest distance since then, before this step, [m].
        distance: d(t), [m].
        delta_distance: distance - previous_best, [m].
        shaped: The shaped reward of the step.
        events: What the events of the step paid, (num_envs, 2): ground, target.
        step_price: What each step pays, (num_envs,).
        flags: 0 or 1, (num_envs, 5): ground, reached, held, terminated, truncated.
        target: (num_envs, 3), world frame, [m].
        end_effector: The same.
        offset: target - end_effector, [m].
        qpos: (num_envs, dof), [rad].
        qvel: (num_envs, dof), [rad/s].
        qvel_change: Since the step before.
        action: (num_envs, action_size).
        sample: What rewards are given: the same arrays.
    """

    def __init__(self, num_envs: int, dof: int, action_size: int) -> None:
        width = len(SCALARS) + dof + action_size
        self._places = _places(dof, action_size)
        self.matrix = matrix = np.zeros((num_envs, width + 2 * dof + 3))
        matrix[:, COLUMN["env"]] = np.arange(num_envs)
        matrix[:, COLUMN["episode"]] = -1
        self.record = matrix[:, :width]
        self.episode, self.step = self._column("episode"), self._column("step")
        self.begin_distance, self.previous_best = self._column("begin_distance"), self._column("previous_best")
        self.distance, self.delta_distance = self._column("distance"), self._column("delta_distance")
        self.shaped, self.step_price = self._column("reward"), self._column("reward_step")
        self.events, self.flags = self._part("events"), self._part("flags")
        self.target, self.end_effector, self.offset = map(self._part, ("target", "end_effector", "offset"))
        self.qpos, self.action = self._part("qpos"), self._part("action")
        self.qvel, self.qvel_change = self._part("qvel"), self._part("qvel_change")
        self._previous_distance = np.zeros(num_envs)
        self.sample = Sample(
            self.begin_distance,
            self.previous_best,
            self._previous_distance,
            self.distance,
            self.delta_distance,
            self.step,
        )

    def columns(self, *names: str) -> NDArray[np.intp]:
        """Where in `matrix` the arrays of these names stand, one after the other."""
        return np.concatenate([np.arange(*self._places[name]) for name in names])

    def start(self, mask: Mask, state: State, target: Float) -> None:
        """Begin new episodes in the envs of `mask` with `target`, (num_envs, 3)."""
        envs = np.flatnonzero(mask)  # of many envs few begin in a step: their numbers are quicker than the mask
        self.qpos[envs], self.qvel[envs] = state.qpos[envs], state.qvel[envs]
        self.end_effector[envs] = state.end_effector[envs]
        self.step[envs] = self.shaped[envs] = self.step_price[envs] = 0.0
        self.qvel_change[envs] = self.events[envs] = self.flags[envs] = 0.0
        self.action[envs] = 0.0
        self.set_target(mask, target)

    def set_target(self, mask: Mask, target: Float) -> None:
        """Give the envs of `mask` a target; their distances restart."""
        envs = np.flatnonzero(mask)
        self.target[envs] = target[envs]
        self.offset[envs] = offset = target[envs] - self.end_effector[envs]
        distance = _length(offset)
        self.require_finite(distance, envs)
        for column in (self.begin_distance, self.previous_best, self.distance, self._previous_distance):
            column[envs] = distance
        self.delta_distance[envs] = 0.0

    def measure(self, state: State) -> Float:
        """Bring the matrix up to the state after a step; previous_best is still the value before it.

        Returns:
            The distances, (num_envs,), a new array.
        """
        self.step += 1.0
        self.end_effector[...] = state.end_effector
        self.qpos[...] = state.qpos
        np.subtract(state.qvel, self.qvel, out=self.qvel_change)
        self.qvel[...] = state.qvel
        np.subtract(self.target, state.end_effector, out=self.offset)
        distance = _length(self.offset)
        self._previous_distance[...] = self.distance
        self.distance[...] = distance
        np.subtract(distance, self.previous_best, out=self.delta_distance)
        return distance

    def require_finite(self, distance: Float, envs: NDArray[np.intp] | None = None) -> None:
        """Raises SimulationDiverged where an end effector is nowhere; `envs` are the distances', all if None."""
        if not np.isfinite(distance).all():
            nowhere = np.flatnonzero(~np.isfinite(distance))
            lost = (nowhere if envs is None else envs[nowhere]).tolist()
            raise SimulationDiverged(f"the end effector of env {lost} is nowhere at step {self.step[lost[0]]:.0f}")

    def _column(self, name: str) -> Float:
        return self.matrix[:, self._places[name][0]]

    def _part(self, name: str) -> Float:
        return self.matrix[:, slice(*self._places[name])]


def _places(dof: int, action_size: int) -> dict[str, tuple[int, int]]:
    """First column of each array in the matrix, and the one after its last."""
    places = {name: (at, at + 1) for name, at in COLUMN.items()}
    groups = {
        "events": ("reward_ground", "reward_target"),
        "flags": ("ground", "truncated"),
        "target": ("target_x", "target_z"),
        "end_effector": ("end_effector_x", "end_effector_z"),
    }
    places.update({name: (COLUMN[first], COLUMN[last] + 1) for name, (first, last) in groups.items()})
    at = len(SCALARS)
    for name, size in (("qpos", dof), ("action", action_size), ("qvel", dof), ("qvel_change", dof), ("offset", 3)):
        places[name] = (at, at + size)
        at += size
    return places


def _length(vectors: Float) -> Float:
    """Euclidean length along the last axis."""
    length: Float = np.sqrt(np.vecdot(vectors, vectors))
    return length
