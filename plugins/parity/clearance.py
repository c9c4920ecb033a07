"""How far an arm's solids keep away from the ground in motions through the air."""

from functools import cached_property

import numpy as np

from harness.arrays import Float, Mask
from harness.env.solid_probes import few_points
from harness.robot import Robot
from harness.robot.ground_clearance import Solids, build_solids
from harness.robot.kinematics import link_frames

CLEARANCE = 0.1
"""Height that the tip and each joint keep above the ground, as a share of the arm's reach."""
MARGIN = 0.02
"""Height that the solids of each joint keep above it, [m]; half of that at home where it is less, as in a turret."""


class GroundClearance:
    """An arm's tip, joints and solids, ready to be held against the ground."""

    def __init__(self, robot: Robot) -> None:
        """Prepare the solids, once for any number of poses."""
        self._robot = robot
        shapes = few_points(robot.joint_shapes)
        self._solids: list[Solids] = [
            build_solids([group if number == joint else () for number, group in enumerate(shapes)])
            for joint in range(robot.dof)
        ]

    def is_clear(self, qpos: Float) -> Mask:
        """Whether all keep their heights at each of the joint positions, (n, dof): (n,)."""
        clear: Mask = lowest_points(self._robot, qpos) >= CLEARANCE * self._robot.reach
        return clear & (self._heights(qpos) >= self._needed).all(axis=0)

    @cached_property
    def _needed(self) -> Float:
        """How high the solids of each joint have to be, (dof, 1), [m]."""
        return np.minimum(0.5 * self._heights(self._robot.home[None]), MARGIN)

    def _heights(self, qpos: Float) -> Float:
        """The lowest point of the solids of each joint, (dof, n), [m]; inf where there is none."""
        frames = link_frames(self._robot.chain, qpos)
        heights: Float = np.stack([solids.lowest(frames) for solids in self._solids])
        return heights


def lowest_points(robot: Robot, qpos: Float) -> Float:
    """Height of the lowest of the tip and the origins of the joints that move, [m].

    Args:
        robot: The arm.
        qpos: Joint positions, (n, dof), [rad].

    Returns:
        Shape (n,). The links reach lower, by their thickness.
    """
    joints = link_frames(robot.chain, qpos)[1:, 2, 3]  # the first joint's origin stands still
    return np.asarray(np.vstack([joints, robot.end_effector(qpos)[:, 2]]).min(axis=0))
