"""Linear movement of the end effector."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic.dataclasses import dataclass as checked_dataclass

from harness.arrays import Float
from harness.motion.follow import Follower
from harness.motion.frames import Axes, CartesianMode
from harness.motion.limits import require_numbers
from harness.motion.motion import Move, Setting


@checked_dataclass(frozen=True)
class MoveLMode(CartesianMode):
    """MoveL: the end effector moves on a straight line; the action is its velocity as a fraction of tip_speed.

    An action that is longer than 1 is one of length 1. The orientation of the end effector is free.
    """

    def motion(self, setting: Setting) -> "MoveL":
        """The motion of one arm."""
        follower = Follower(setting.robot, setting.limits(self.parts), self.tip_speed)
        return MoveL(follower, self.axes(setting.robot), self.tip_speed * setting.period, self.parts)


@dataclass(frozen=True, eq=False)
class MoveL:
    """See `MoveLMode`.

    Attributes:
        follower: Keeps the end effector on the line.
        axes: Of the action.
        length: Of the line under a full action, [m].
        parts: Points on it.
    """

    follower: Follower
    axes: Axes
    length: float
    parts: int
    action_size: ClassVar[int] = 3
    jumps: ClassVar[bool] = False

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        """See `harness.motion.motion.Motion`."""
        require_numbers(action)
        clipped = np.minimum(np.maximum(action, -1.0), 1.0)
        fraction = clipped / np.maximum(1.0, np.linalg.norm(clipped, axis=-1, keepdims=True))
        way = self.axes.to_world(qpos, self.length * fraction[:, None])[:, 0]
        return self.follower.pass_along(qpos, qvel, lambda gone: gone * way, self.parts)

    def stay(self, qpos: Float) -> Float:
        """No velocity."""
        return np.zeros((len(qpos), 3))

    def increments(self) -> Float:
        """Full speed along each axis."""
        return np.eye(3)
