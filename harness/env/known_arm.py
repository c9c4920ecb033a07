"""Inverse kinematics as a policy, and the tasks that it can do. A learner that knew the arm could do as much."""

from typing import cast

from harness.env.arm_observation import ArmObservation
from harness.motion import MoveJ, MoveJAbsolute, SetJoints
from harness.policy import InverseKinematics
from harness.robot import Robot
from harness.task import Task, goal_of

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
