"""A simulator whose arms take much memory."""

from harness.env.vector_env import ARMS_BYTES
from harness_plugins.kit import IdealSimulator


class Heavy(IdealSimulator):
    """Three of its arms are held at once, or the power of two above."""

    arm_bytes = ARMS_BYTES // 3

    def open(self, robot, num_envs, control_period):
        """At most so many."""
        assert num_envs <= 4
        return super().open(robot, num_envs, control_period)
