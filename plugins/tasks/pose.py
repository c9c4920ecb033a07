"""The reach task with a target that has an orientation."""

import math
from dataclasses import dataclass as plain_dataclass
from typing import Annotated

import numpy as np
from pydantic import Field, PositiveFloat
from pydantic.dataclasses import dataclass

from harness import Float
from harness.robot import (
    Robot,
    forward,
    reach_position,
    rotation_of_axes,
)
from harness.task import Goal, ReachTask, Situation


@dataclass(frozen=True)
class Pose(ReachTask):
    """Bring the end effector to a target and into the target's orientation: within `epsilon` and within `angle`.

    The error, in metres, is the larger of two numbers: the distance d, and L times the angle that is left, with
    L = epsilon / angle. It is at most epsilon if both conditions hold. The arm can take a target's orientation at the
    target: it is that of a pose which inverse kinematics find there. They start from the home pose, with each joint
    turned by up to `turn`.
    """

    epsilon: Annotated[PositiveFloat, Field(description="pose error within which the target is reached [m]")] = 0.02
    angle: Annotated[
        float, Field(gt=0, le=math.pi, description="angle that counts as much as a distance of epsilon [rad]")
    ] = math.radians(10)
    turn: Annotated[
        float, Field(ge=0, description="largest random turn of joints from home, to vary the target orientation [rad]")
    ] = math.radians(30)

    def goal(self, robot: Robot) -> "PoseGoal":
        """See `harness.task.Task`."""
        return PoseGoal(robot, self.epsilon / self.angle, self.turn)

    def target_in_words(self, robot: Robot) -> str:
        return f"{super().target_in_words(robot)}, in an orientation that it can take there"


@plain_dataclass(frozen=True)
class PoseGoal(Goal):
    """The end effector at the target, in its orientation.

    Attributes:
        robot: The arm.
        lever: The error that an angle of 1 rad counts, [m/rad].
        turn: See `Pose`.
    """

    robot: Robot
    lever: float
    turn: float

    error = "pose error"
    numbers = 6
    aim = "pose"
    observed = "the target's x and y axis (6, world frame), and the turn that is left (3, rotation vector over pi)"

    def draw(self, rng: np.random.Generator, position: Float) -> Float:
        """The x and y axis of each target's orientation, (count, 6)."""
        home, shape = self.robot.home, (len(position), self.robot.dof)
        start = np.clip(
            home + rng.uniform(-self.turn, self.turn, shape) * self.robot.per_radian, self.robot.lower, self.robot.upper
        )
        turned, reached = reach_position(self.robot, position, start)
        usual, _ = reach_position(self.robot, position, np.broadcast_to(home, shape))
        pose = forward(self.robot.chain, np.where(reached[:, None], turned, usual))
        return np.concatenate([pose[:, :3, 0], pose[:, :3, 1]], axis=1)

    def errors(self, now: Situation) -> Float:
        """The larger of distance and lever times angle, (n,), [m]."""
        distance = np.linalg.norm(now.target - now.end_effector, axis=1)
        angle = np.linalg.norm(self._turn_left(now), axis=1)
        return np.asarray(np.maximum(distance, self.lever * angle))

    def bounds(self) -> tuple[Float, Float]:
        """Bounds of what `observe` returns, both (9,): all numbers are in [-1, 1]."""
        return -np.ones(9), np.ones(9)

    def observe(self, now: Situation) -> Float:
        """The numbers that `observed` names, (n, 9)."""
        return np.concatenate([now.numbers, self._turn_left(now) / math.pi], axis=1)

    def _turn_left(self, now: Situation) -> Float:
        from scipy.spatial.transform import Rotation  # takes as long to import as all of the core

        pose = forward(self.robot.chain, now.qpos)
        turn = rotation_of_axes(now.numbers) @ np.swapaxes(pose[:, :3, :3], -1, -2)
        return np.asarray(Rotation.from_matrix(turn).as_rotvec())
