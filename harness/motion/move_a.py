"""Arc movement of the end effector."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic.dataclasses import dataclass as checked_dataclass

from harness.arrays import Float
from harness.motion.arc import arc_through
from harness.motion.follow import Follower
from harness.motion.frames import Axes, CartesianMode
from harness.motion.limits import require_numbers
from harness.motion.motion import Move, Setting


@checked_dataclass(frozen=True)
class MoveAMode(CartesianMode):
    """MoveA: the end effector moves on an arc through a via point; the action is the via point and the end point.

    Both are given from where the end effector is, as fractions of the way that it does at tip_speed; an arc that is
    longer is gone only so far, and a tight one slowly. Three points on one line make a straight line. The orientation
    of the end effector is free.
    """

    def motion(self, setting: Setting) -> "MoveA":
        """The motion of one arm."""
        follower = Follower(setting.robot, setting.limits(self.parts), self.tip_speed)
        return MoveA(follower, self.axes(setting.robot), setting.period, self.parts)


@dataclass(frozen=True, eq=False)
class MoveA:
    """See `MoveAMode`.

    Attributes:
        follower: Keeps the end effector on the arc.
        axes: Of the action.
        period: Control period, [s].
        parts: Pieces of the way within it.
    """

    follower: Follower
    axes: Axes
    period: float
    parts: int
    action_size: ClassVar[int] = 6
    jumps: ClassVar[bool] = False

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        """See `harness.motion.motion.Motion`."""
        require_numbers(action)
        follower = self.follower
        clipped = np.minimum(np.maximum(action, -1.0), 1.0).reshape(-1, 2, 3)
        points = self.axes.to_world(qpos, follower.tip_speed * self.period * clipped)
        arc = arc_through(points[:, 0], points[:, 1])
        turning = follower.turning_speed(qpos, arc.forward, arc.inward, arc.radius)
        length = np.minimum(arc.length, self.period * np.minimum(turning, follower.tip_speed))
        return follower.pass_along(qpos, qvel, lambda gone: arc.point(gone * length), self.parts)

    def stay(self, qpos: Float) -> Float:
        """Via and end point where the end effector is."""
        return np.zeros((len(qpos), 6))

    def increments(self) -> Float:
        """Along each axis, with a bulge of a quarter towards the next one."""
        ends = np.eye(3)
        return np.concatenate([0.5 * ends + 0.25 * np.roll(ends, 1, axis=1), ends], axis=1)
