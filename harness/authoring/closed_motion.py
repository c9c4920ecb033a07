"""A small motion for every arm of a batch, to drive a simulator along while it is timed."""

import numpy as np

from harness.arrays import Float
from harness.robot import Robot

LONGEST_MOTION = 64
"""Control periods."""


def closed_motion(robot: Robot, num_envs: int, periods: int = LONGEST_MOTION) -> Float:
    """Joint targets, (periods, num_envs, dof), that end where they begin: small swings around home, out of step."""
    phase = np.linspace(0.0, 2 * np.pi, num_envs, endpoint=False)[:, None]
    along = 2 * np.pi * np.arange(periods)[:, None, None] / periods + phase
    swing = np.minimum(0.1, 0.1 * (robot.upper - robot.lower))
    targets: Float = np.clip(robot.home + swing * np.sin(along), robot.lower, robot.upper)
    return targets
