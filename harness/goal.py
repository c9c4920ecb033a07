"""The interface of a goal: what a task asks for, if that is more than bringing the end effector to a point."""

from abc import ABC, abstractmethod
from typing import Literal, NamedTuple

import numpy as np

from harness.arrays import Float


class Situation(NamedTuple):
    """Where n arms are, and what their targets are. The arrays belong to the environment: do not change them."""

    qpos: Float
    """Joint positions, (n, dof), [rad] or, where a joint slides, [m]."""
    end_effector: Float
    """Its position, (n, 3), world frame, [m], as the simulator reports it."""
    target: Float
    """Where the target is now, (n, 3), world frame, [m]."""
    numbers: Float
    """What `Goal.draw` gave with the target, (n, Goal.numbers)."""
    step: Float
    """Environment steps since the target was set, (n,)."""
    within: Float
    """For how many steps in a row the error has been within the task's epsilon, (n,); of no use to `Goal.errors`."""


class Goal(ABC):
    """What a task asks for, if that is more than bringing the end effector to a point that does not move.

    The goal's error replaces the distance to the target everywhere: rewards use it, the trace records it in the columns
    of distances, and the target is reached when the error is at most the task's ``epsilon``.

    Attributes:
        error: What the error is called, in a few words, such as ``pose error``.
        unit: Unit of the error and of ``epsilon``; empty if they have none.
        numbers: How many numbers belong to a target in addition to its position.
        moves: Whether the target moves, see `displacement`.
        steps_within: The target is reached when the error was within epsilon for this many steps in a row.
        aim: What the algorithm ``ik``, which uses the arm's inverse kinematics, has to reach. ``position``: the
            target's position. ``pose``: its orientation too; the first six numbers of `observe` are then the x and the
            y axis of that orientation, in the world frame. None: ``ik`` cannot do the task.
        observed: What `observe` returns, in one line for ``harness describe``.
    """

    error: str
    unit: str = "m"
    numbers: int = 0
    moves: bool = False
    steps_within: int = 1
    aim: Literal["position", "pose"] | None = None
    observed: str = ""

    @abstractmethod
    def errors(self, now: Situation) -> Float:
        """How far each arm is from what the task asks for, (n,), >= 0, a new array; 0 if it does exactly that."""

    def draw(self, rng: np.random.Generator, position: Float) -> Float:
        """Draw the numbers that belong to targets in addition to their positions, (count, `numbers`).

        Args:
            rng: The generator that the positions were drawn with.
            position: The positions that `Task.draw_targets` returned, (count, 3), [m].
        """
        return np.zeros((len(position), 0))

    def displacement(self, numbers: Float, step: Float) -> Float:
        """How far each target has moved `step` steps after it was set, (n, 3), [m]; zeros at step 0."""
        return np.zeros((len(step), 3))

    def bounds(self) -> tuple[Float, Float]:
        """The smallest and the largest value of each number of `observe`, (size,) each."""
        return np.zeros(0), np.zeros(0)

    def observe(self, now: Situation) -> Float:
        """What the learner sees of the goal besides target, offset and error, (n, size), within `bounds`."""
        return np.zeros((len(now.step), 0))
