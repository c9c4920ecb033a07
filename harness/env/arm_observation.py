"""What the learner sees: NOTE Table I, and where the target is."""

from typing import cast

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Float32
from harness.conditions.obstacles import NUMBERS, seen_from
from harness.env.episodes import Episodes
from harness.goal import Goal
from harness.motion.motion import MoveJ, MoveJAbsolute, SetJoints
from harness.policy.inverse_kinematics import InverseKinematics
from harness.robot import Robot
from harness.task import Task, goal_of


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
    each obstacle, nearest first  7      its centre - end effector (3), half edges (3), radius, [m];
                                         zeros where there are fewer
    ============================  =====  ==========================================================

    Attributes:
        obstacles: How many are seen.
        arm_columns: Those that say nothing of the target, (3 dof + 3,): the joints' and the end effector's.
    """

    def __init__(self, robot: Robot, period: float, obstacles: int = 0) -> None:
        """Observe an arm whose task shows `obstacles` obstacles."""
        self.obstacles = obstacles
        half_range = (robot.upper - robot.lower) / 2.0
        joints = np.concatenate([half_range, robot.max_speed, robot.max_acceleration * period])
        # Rows, (1, size): of one arm numpy is more than twice as quick with them as with (size,).
        self._scale = 1.0 / np.concatenate([joints, np.ones(10)])[None]
        self._middle = np.concatenate([(robot.lower + robot.upper) / 2.0, np.zeros(2 * robot.dof + 10)])[None]
        # The end effector cannot leave this, whatever the joints do; targets are checked against the arm's reach.
        extent = 2.0 * robot.extent
        self._high = np.concatenate([np.ones(3 * robot.dof), np.full(10 + NUMBERS * obstacles, extent)])[None]
        self._low = -self._high
        self._low[0, 3 * robot.dof + 9] = 0.0
        self._columns: NDArray[np.intp] | None = None
        dof = robot.dof
        self.arm_columns = np.concatenate([np.arange(3 * dof), np.arange(3 * dof + 3, 3 * dof + 6)])

    @property
    def low(self) -> Float32:
        """Lower bounds, (size,)."""
        low: Float32 = self._low[0].astype(np.float32)
        return low

    @property
    def high(self) -> Float32:
        """Upper bounds, (size,)."""
        high: Float32 = self._high[0].astype(np.float32)
        return high

    def observe(self, episodes: Episodes) -> Float32:
        if self._columns is None:
            self._columns = episodes.columns(
                "qpos", "qvel", "qvel_change", "target", "end_effector", "offset", "distance"
            )
        seen = episodes.matrix.take(self._columns, axis=1)
        seen -= self._middle
        seen *= self._scale
        if self.obstacles:
            there = episodes.extra("obstacles").reshape(len(seen), -1, NUMBERS)
            near = seen_from(episodes.end_effector, there, self.obstacles)
            seen = np.concatenate([seen, near.reshape(len(seen), -1)], axis=1)
        np.maximum(seen, self._low, out=seen)
        np.minimum(seen, self._high, out=seen)
        return seen.astype(np.float32)


class GoalObservation(ArmObservation):
    """`ArmObservation` with the goal's error in place of the distance, then what `harness.goal.Goal.observe` tells.

    Obstacles, where they are seen, come after that. The target is where it is now, the offset target - end effector.
    Every number is cut off at its bounds: the error at twice the arm's extent, whatever its unit.
    """

    def __init__(self, robot: Robot, period: float, goal: Goal, obstacles: int = 0) -> None:
        super().__init__(robot, period, obstacles)
        self.goal, self._usual = goal, 3 * robot.dof + 10
        self._least, self._most = goal.bounds()

    @property
    def low(self) -> Float32:
        """Lower bounds, (size,)."""
        return self._with(super().low, self._least)

    @property
    def high(self) -> Float32:
        """Upper bounds, (size,)."""
        return self._with(super().high, self._most)

    def observe(self, episodes: Episodes) -> Float32:
        more = np.clip(self.goal.observe(episodes.situation), self._least, self._most)
        return self._with(super().observe(episodes), more)

    def _with(self, seen: Float32, more: Float) -> Float32:
        """What is seen of arm, target and obstacles, (..., size), with the goal's numbers before the obstacles."""
        parts = (seen[..., : self._usual], more.astype(np.float32), seen[..., self._usual :])
        return np.concatenate(parts, axis=-1)


MODES: dict[type, str] = {MoveJ: "movej", MoveJAbsolute: "movej-absolute", SetJoints: "set-joints"}


def why_not_kinematics(task: Task, robot: Robot) -> str:
    """Why the kinematics of `robot` cannot do `task`; empty if they can."""
    motion = task.motion(robot)
    if type(motion) not in MODES:
        return f"ik knows the action modes {', '.join(MODES.values())}, not that of the task: '{task.action}'"
    if not isinstance(task.observation(robot), ArmObservation):
        return "ik reads joint angles and target from the observation of fd100-reach, and the task has another"
    goal = goal_of(task, robot)
    if goal is not None and goal.aim is None:
        return f"ik goes to a point or to a pose, and neither tells how to make the task's {goal.error} small"
    return ""


def kinematics_policy(task: Task, robot: Robot, algorithm: str = "") -> InverseKinematics:
    """The policy that does `task` by the kinematics of `robot`. `why_not_kinematics` must be empty.

    Args:
        task: The task.
        robot: The arm.
        algorithm: For the reader of the policy's card.
    """
    motion = cast(MoveJ | MoveJAbsolute | SetJoints, task.motion(robot))
    goal, size = goal_of(task, robot), len(task.observation(robot).low)
    more, turns = size - (3 * robot.dof + 10), goal is not None and goal.aim == "pose"
    return InverseKinematics.of(robot, motion.limits, MODES[type(motion)], algorithm, more, turns)
