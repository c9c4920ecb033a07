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
STILL, POSES = 1e-6, 64
"""A point stands still whose height differs by no more in so many poses, [m]."""
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
        points = point_heights(self._robot, qpos)[self._rises]
        high = (points >= CLEARANCE * self._robot.reach).all(axis=0)
        return np.asarray(high & (self._heights(qpos) >= self._needed).all(axis=0))

    @cached_property
    def _rises(self) -> Mask:
        """Which of the points can change their heights, (dof,): a turret's next joint cannot meet the ground."""
        rng, robot = np.random.default_rng(0), self._robot
        heights = point_heights(robot, rng.uniform(robot.lower, robot.upper, (POSES, robot.dof)))
        return np.asarray(np.ptp(heights, axis=1) > STILL)

    @cached_property
    def _needed(self) -> Float:
        """How high the solids of each joint have to be, (dof, 1), [m]."""
        return np.minimum(0.5 * self._heights(self._robot.home[None]), MARGIN)

    def _heights(self, qpos: Float) -> Float:
        """The lowest point of the solids of each joint, (dof, n), [m]; inf where there is none."""
        frames = link_frames(self._robot.chain, qpos)
        heights: Float = np.stack([solids.lowest(frames) for solids in self._solids])
        return heights


def point_heights(robot: Robot, qpos: Float) -> Float:
    """Heights of the origins of all joints but the first, which stands still, and of the tip, [m].

    Args:
        robot: The arm.
        qpos: Joint positions, (n, dof), [rad].

    Returns:
        Shape (dof, n). The links reach lower, by their thickness.
    """
    return np.vstack([link_frames(robot.chain, qpos)[1:, 2, 3], robot.end_effector(qpos)[:, 2]])


def lowest_points(robot: Robot, qpos: Float) -> Float:
    """The lowest of the `point_heights`, (n,), [m]."""
    return np.asarray(point_heights(robot, qpos).min(axis=0))
