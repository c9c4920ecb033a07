"""What the learner sees: NOTE Table I, and where the target is."""

import numpy as np
from numpy.typing import NDArray

from harness.robot import Robot
from harness.simulator import State

Float = NDArray[np.float64]
Float32 = NDArray[np.float32]


class ArmObservation:
    """NOTE Table I (angle, speed, acceleration per joint), target, end effector, offset and distance.

    Layout of the last axis, for dof joints:

    ============================  =====  ==========================================================
    joint angles                  dof    position in the joint's range, -1 lower end, 1 upper end
    joint speeds                  dof    fraction of the maximum speed, in [-1, 1]
    joint accelerations           dof    fraction of the maximum acceleration, in [-1, 1]
    target                        3      world frame, [m]
    end effector                  3      world frame, [m]
    offset                        3      target - end effector, [m]
    distance                      1      length of the offset, [m]
    ============================  =====  ==========================================================
    """

    def __init__(self, robot: Robot, period: float) -> None:
        dof = robot.dof
        self.size = 3 * dof + 10
        self._dof = dof
        period_speed = robot.max_acceleration * period
        self._middle = (robot.lower + robot.upper) / 2.0
        self._scale = 1.0 / np.concatenate([(robot.upper - robot.lower) / 2.0, robot.max_speed, period_speed])
        # The end effector cannot leave this, whatever the joints do; targets are checked against the arm's reach.
        extent = 2.0 * (robot.reach + float(np.linalg.norm(robot.chain.T_previous_joint[0, :3, 3])))
        self._limit = np.concatenate([np.ones(3 * dof), np.full(10, extent)])

    @property
    def low(self) -> Float32:
        """Lower bounds, (size,)."""
        low = -self._limit
        low[-1] = 0.0
        return low.astype(np.float32)

    @property
    def high(self) -> Float32:
        """Upper bounds, (size,)."""
        return self._limit.astype(np.float32)

    def write_targets(self, target: Float, into: Float) -> None:
        """Write the targets, (num_envs, 3); they hold for an episode."""
        into[:, 3 * self._dof : 3 * self._dof + 3] = target

    def write(self, state: State, previous_qvel: Float, offset: Float, distance: Float, into: Float) -> None:
        """Write what changes at every step.

        Args:
            state: As the simulator reads it.
            previous_qvel: Joint speeds one step earlier, (num_envs, dof).
            offset: Target - end effector, (num_envs, 3).
            distance: Its length, (num_envs,).
            into: (num_envs, size).
        """
        dof = self._dof
        joints = into[:, : 3 * dof]
        np.subtract(state.qpos, self._middle, out=into[:, :dof])
        into[:, dof : 2 * dof] = state.qvel
        np.subtract(state.qvel, previous_qvel, out=into[:, 2 * dof : 3 * dof])
        np.multiply(joints, self._scale, out=joints)
        np.minimum(np.maximum(joints, -1.0, out=joints), 1.0, out=joints)
        into[:, 3 * dof + 3 : 3 * dof + 6] = state.end_effector
        into[:, 3 * dof + 6 : 3 * dof + 9] = offset
        into[:, -1] = distance
