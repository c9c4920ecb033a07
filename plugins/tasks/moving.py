"""The reach task with a target that moves."""

from dataclasses import dataclass as plain_dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness import Float
from harness.robot import Robot
from harness.task import Goal, ReachTask, Situation


@dataclass(frozen=True)
class Moving(ReachTask):
    """Follow a moving target: stay within epsilon of it for `steps_within` steps in a row, which counts as reaching it.

    The target moves at constant speed on a straight line between two places, there and back again. Both places are
    drawn like the targets of `fd100-reach`.
    """

    target_speed: Annotated[float, Field(ge=0, description="speed of the target [m/s]")] = 0.25
    steps_within: Annotated[
        int, Field(gt=0, description="steps in a row for which the end effector has to be within epsilon")
    ] = 10

    lengths: ClassVar[tuple[str, ...]] = ("epsilon", "target_speed")

    def goal(self, robot: Robot) -> "MovingGoal":
        """See `harness.task.Task`."""
        return MovingGoal(self, robot, self.target_speed, self.control_period, self.steps_within)

    def target_in_words(self, robot: Robot) -> str:
        speed = f"{self.target_speed:g} m/s"
        return f"{super().target_in_words(robot)}; it moves at {speed} to another place there, and back again"


@plain_dataclass(frozen=True)
class MovingGoal(Goal):
    """The end effector near a point that moves back and forth between two places.

    Attributes:
        task: The task, which draws the other place.
        robot: The arm.
        speed: Speed of the target, [m/s].
        period: Duration of an environment step, [s].
        steps_within: See `harness.goal.Goal`.
    """

    task: ReachTask
    robot: Robot
    speed: float
    period: float
    steps_within: int

    error = "distance"
    numbers = 3
    moves = True
    aim = "position"
    observed = (
        "the target's velocity (3, m/s), and the steps in a row within epsilon, as a share of those that are needed"
    )

    def draw(self, rng: np.random.Generator, position: Float) -> Float:
        """Draw the other place of each target: the vectors that lead to it from `position`, (count, 3), [m]."""
        ends = self.task.draw_targets(self.robot, rng, len(position)).position
        return np.asarray(ends - position)

    def displacement(self, numbers: Float, step: Float) -> Float:
        length = np.linalg.norm(numbers, axis=1)
        gone = self.speed * self.period * step
        along = length - np.abs(np.mod(gone, 2.0 * np.maximum(length, SHORTEST)) - length)
        moved: Float = along[:, None] * _unit(numbers, length)
        return moved

    def errors(self, now: Situation) -> Float:
        """The distance from the end effector to where the target is now, (n,), [m]."""
        return np.asarray(np.linalg.norm(now.target - now.end_effector, axis=1))

    def bounds(self) -> tuple[Float, Float]:
        """Bounds of what `observe` returns, both (4,): velocities, [m/s], and a share in [0, 1]."""
        speed = max(self.speed, SHORTEST)
        return np.array([-speed] * 3 + [0.0]), np.array([speed] * 3 + [1.0])

    def observe(self, now: Situation) -> Float:
        """The numbers that `observed` names, (n, 4). The velocity is that of the next step."""
        length = np.linalg.norm(now.numbers, axis=1)
        gone = self.speed * self.period * now.step
        returns = np.mod(gone, 2.0 * np.maximum(length, SHORTEST)) >= length
        velocity = np.where(returns, -self.speed, self.speed)[:, None] * _unit(now.numbers, length)
        return np.concatenate([velocity, now.within[:, None] / self.steps_within], axis=1)


SHORTEST = 1e-9
"""Two places that are nearer to each other than this count as one place, [m]."""


def _unit(ways: Float, length: Float) -> Float:
    """Each vector, (n, 3), scaled to length 1; a vector of length 0 stays zero. `length` is (n,)."""
    unit: Float = ways / np.where(length > 0.0, length, 1.0)[:, None]
    return unit
