"""Where the episodes of a batch stand: one matrix, whose first columns are the row that a trace records."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask, read_only
from harness.goal import Goal, Situation
from harness.record.trace import COLUMN, NO_EXTRAS, SCALARS
from harness.reward import Sample
from harness.reward.steps import ARM_BEFORE, BEFORE, ENDS, steps_of
from harness.simulator import State


class Episodes:
    """`num_envs` episodes side by side. Every array below is a view into `matrix`, which has a row per env.

    Attributes:
        matrix: (num_envs, width): the row to record, then qvel, qvel_change and offset; with a goal also what it needs.
        record: The row to record, (num_envs, recorded width); columns as in `harness.record.trace`.
        env: Number of the env, (num_envs,). They count from 0, unless the envs are a part of a batch.
        episode: Number of the episode in its env.
        step: Environment steps since its start.
        begin_distance: d(0), or the distance when the target was last set, [m].
        previous_best: The smallest distance since then, before this step, [m].
        distance: d(t), [m]; with a goal its error, in its unit, as all distances here.
        delta_distance: distance - previous_best, [m].
        shaped: The shaped reward of the step.
        events: What the events of the step paid, (num_envs, 2): ground, target.
        step_price: What each step pays, (num_envs,).
        flags: 0 or 1, (num_envs, 5): ground, reached, held, terminated, truncated.
        target: (num_envs, 3), world frame, [m]; where it is now.
        end_effector: The same.
        offset: target - end_effector, [m].
        qpos: (num_envs, dof), [rad].
        qvel: (num_envs, dof), [rad/s].
        qvel_change: Since the step before.
        action: (num_envs, action_size).
        extras: Columns that the record has beside the usual ones, and their widths; see `harness.record.trace`.
        ground: Whether the step touched the ground, (num_envs,).
        terminated: Whether the step ended the episode, (num_envs,).
        truncated: Whether the horizon cut the episode after the step, (num_envs,).
        ended: Both, (2, num_envs).
        steps: What rewards are given: the same arrays, which they cannot write into, and those of the row before.
        numbers: What belongs to the target beside its position, (num_envs, goal.numbers); (num_envs, 0) without a goal.
        situation: What a goal is given: the same; without a goal it tells nothing.
    """

    def __init__(
        self,
        num_envs: int,
        dof: int,
        action_size: int,
        extras: Mapping[str, int] = NO_EXTRAS,
        goal: Goal | None = None,
    ) -> None:
        self._sizes, self.extras, self.goal = (num_envs, dof, action_size), extras, goal
        width = len(SCALARS) + dof + action_size + sum(extras.values())
        self._places = _places(dof, action_size, extras, goal)
        self.matrix = matrix = np.zeros((num_envs, max(end for _, end in self._places.values())))
        matrix[:, COLUMN["env"]] = np.arange(num_envs)
        matrix[:, COLUMN["episode"]] = -1
        self.record = matrix[:, :width]
        self.env, self.episode, self.step = map(self._column, ("env", "episode", "step"))
        self.begin_distance, self.previous_best = self._column("begin_distance"), self._column("previous_best")
        self.distance, self.delta_distance = self._column("distance"), self._column("delta_distance")
        self.shaped, self.step_price = self._column("reward"), self._column("reward_step")
        self.events, self.flags = self._part("events"), self._part("flags")
        self.target, self.end_effector, self.offset = map(self._part, ("target", "end_effector", "offset"))
        self.qpos, self.action = self._part("qpos"), self._part("action")
        self.qvel, self.qvel_change = self._part("qvel"), self._part("qvel_change")
        self.previous_distance = np.zeros(num_envs)
        self.ground = np.zeros(num_envs, bool)
        self.terminated, self.truncated = self.ended = np.zeros((2, num_envs), bool)
        self._before, self._ground_before = np.zeros_like(matrix), np.zeros(num_envs, bool)
        self.steps = steps_of(self._fields())
        self.numbers, self._set_at = self._part("numbers"), self._part("set_at")
        self._since, self._within = (self._column(name) if goal else np.zeros(0) for name in ("since", "within"))
        situation = (self.qpos, self.end_effector, self.target, self.numbers, self._since, self._within)
        self.situation = Situation(*map(read_only, situation))

    def _fields(self) -> dict[str, Any]:
        """The fields of `harness.reward.steps.ARM`, as views."""
        now = {name: getattr(self, name) for name in dict.fromkeys((*Sample._fields, *ARM_BEFORE, *ENDS))}
        before = {name: self._before[:, slice(*self._places[name])] for name in ARM_BEFORE if name != "ground"}
        before = {**before, "distance": before["distance"][:, 0], "ground": self._ground_before}
        told = steps_of({name: read_only(before[name]) for name in ARM_BEFORE})
        return {**{name: read_only(array) for name, array in now.items()}, BEFORE: told}

    def keep(self) -> None:
        """Note the row as the one before the next step."""
        self._before[...] = self.matrix
        self._ground_before[...] = self.ground

    def keep_starts(self, mask: Mask) -> None:
        """Note the start rows of the envs of `mask` as those before their first steps."""
        self.ground[mask] = False
        self._before[mask], self._ground_before[mask] = self.matrix[mask], False

    def state(self) -> dict[str, Any]:
        """Everything that `restore` needs."""
        return {
            "matrix": self.matrix.copy(),
            "previous_distance": self.previous_distance.copy(),
            "before": self._before.copy(),
            "ground_before": self._ground_before.copy(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, which the method of this name returned."""
        self.matrix[...], self.previous_distance[...] = state["matrix"], state["previous_distance"]
        # A checkpoint of an earlier version does not tell what was before: no reward of its time read that.
        self._before[...] = state.get("before", state["matrix"])
        self._ground_before[...] = state.get("ground_before", False)

    def columns(self, *names: str) -> NDArray[np.intp]:
        """Where in `matrix` the arrays of these names stand, one after the other."""
        return np.concatenate([np.arange(*self._places[name]) for name in names])

    def another(self) -> "Episodes":
        """New episodes of the same sizes."""
        return Episodes(*self._sizes, self.extras, self.goal)

    def extra(self, name: str) -> Float:
        """One of `extras`, (num_envs, its width)."""
        return self._part(name)

    def start(self, mask: Mask, state: State, target: Float, numbers: Float | None = None) -> None:
        """Begin new episodes in the envs of `mask` with `target`, (num_envs, 3), and the `numbers` of a goal."""
        envs = np.flatnonzero(mask)  # of many envs few begin in a step: their numbers are quicker than the mask
        self.matrix[envs, COLUMN["step"] :] = 0.0  # all but the numbers of env and episode
        self.qpos[envs], self.qvel[envs] = state.qpos[envs], state.qvel[envs]
        self.end_effector[envs] = state.end_effector[envs]
        self.set_target(mask, target, numbers)

    def set_target(self, mask: Mask, target: Float, numbers: Float | None = None) -> None:
        """Give the envs of `mask` a target; their distances restart."""
        envs = np.flatnonzero(mask)
        self.target[envs] = target[envs]
        if self.goal and numbers is not None:
            self.numbers[envs], self._set_at[envs] = numbers[envs], target[envs]
            self._since[envs] = self._within[envs] = 0.0
        self.offset[envs] = self.target[envs] - self.end_effector[envs]
        distance = self._errors()[envs]
        for column in (self.begin_distance, self.previous_best, self.distance, self.previous_distance):
            column[envs] = distance
        self.delta_distance[envs] = 0.0

    def measure(self, state: State) -> Float:
        """Update the matrix to the state after a step. `previous_best` is still the value before the step.

        Returns:
            The distances, (num_envs,), a new array.
        """
        self.step[...] = self.step + _ONE  # of one env numpy is half as quick to add a number in place
        if self.goal:
            self._since[...] = self._since + _ONE
            if self.goal.moves:
                self.target[...] = self._set_at + self.goal.displacement(self.numbers, self._since)
        self.end_effector[...] = state.end_effector
        self.qpos[...] = state.qpos
        np.subtract(state.qvel, self.qvel, out=self.qvel_change)
        self.qvel[...] = state.qvel
        np.subtract(self.target, state.end_effector, out=self.offset)
        distance = self._errors()
        self.previous_distance[...] = self.distance
        self.distance[...] = distance
        self.delta_distance[...] = distance - self.previous_best
        return distance

    def count_within(self, far: Mask) -> Mask:
        """Where the error was not within epsilon for as many steps in a row as the goal asks, counting this one.

        Args:
            far: Where it is not within epsilon now, (num_envs,).
        """
        if self.goal is None:
            return far
        self._within[...] = np.where(far, 0.0, self._within + 1.0)
        short: Mask = self._within < self.goal.steps_within
        return short

    def measure_offset(self) -> None:
        """Update offset and distance from target and end effector."""
        np.subtract(self.target, self.end_effector, out=self.offset)
        self.distance[...] = self._errors()

    @property
    def parts(self) -> dict[str, Float]:
        """The matrix in parts by name; first what all others are made of."""
        return {name: self._part(name) for name in ("end_effector", "qpos", "qvel", "target", *self._places)}

    def _errors(self) -> Float:
        return _length(self.offset) if self.goal is None else self.goal.errors(self.situation)

    def _column(self, name: str) -> Float:
        return self.matrix[:, self._places[name][0]]

    def _part(self, name: str) -> Float:
        return self.matrix[:, slice(*self._places[name])]


def _places(dof: int, action_size: int, extras: Mapping[str, int], goal: Goal | None) -> dict[str, tuple[int, int]]:
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
    arm, more = {"qpos": dof, "action": action_size}, {"qvel": dof, "qvel_change": dof, "offset": 3}
    beside = {**arm, **extras, **{name: size for name, size in more.items() if name not in extras}}  # a recorded qvel
    sizes = (goal.numbers, 3, 1, 1) if goal else (0, 0, 0, 0)
    asked = zip(("numbers", "set_at", "since", "within"), sizes, strict=True)
    for name, size in (*beside.items(), *asked):
        places[name] = (at, at + size)
        at += size
    return places


def _length(vectors: Float) -> Float:
    """Euclidean length along the last axis."""
    length: Float = np.sqrt(np.vecdot(vectors, vectors))
    return length


_ONE = np.array(1.0)
"""1 as an array, since numpy would convert a float at every call."""
