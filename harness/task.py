"""The reach task: where it starts, what the target is, what the learner sees and does, when an episode ends."""

import math
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.errors import UsageError
from harness.inverse import reach_position
from harness.motion import MoveJ
from harness.observation import ArmObservation
from harness.robot import Robot

Float = NDArray[np.float64]
Positive = Annotated[float, Field(gt=0)]
Metres3 = tuple[float, float, float]


@dataclass(frozen=True)
class ReachTask:
    """Bring the end effector of an arm within epsilon of a target, as the NOTE's tuple <S, A, T, R>.

    The defaults are those of the FD100 (`fd100-reach`).
    """

    epsilon: Annotated[Positive, Field(description="the target is reached within this distance, NOTE eq. 20 [m]")] = (
        0.05
    )
    horizon: Annotated[int, Field(gt=0, description="an episode is truncated after so many steps")] = 100
    control_period: Annotated[Positive, Field(description="duration of one step [s]")] = 0.1
    target_center: Annotated[Metres3, Field(description="centre of the box of targets, world frame [m]")] = (
        0.85,
        0.0,
        0.7,
    )
    target_half_extent: Annotated[
        tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)]],
        Field(description="half the edges of that box [m]"),
    ] = (0.2, 0.3, 0.3)
    start_noise: Annotated[
        float, Field(ge=0, description="a joint starts within +- this of the robot's home pose [rad]")
    ] = math.radians(6)
    speed: Annotated[
        float, Field(gt=0, le=1, description="fraction of a joint's maximum speed that may be used, NOTE Table I")
    ] = 0.8
    acceleration: Annotated[float, Field(gt=0, le=1, description="the same for the acceleration, NOTE Table I")] = 0.6
    ground_reward: Annotated[float, Field(description="paid when the arm touches the ground, NOTE eq. 18")] = -1.0
    target_reward: Annotated[float, Field(description="paid when the target is reached, NOTE eq. 19")] = 1.0
    step_reward: Annotated[float, Field(description="paid on every step, the baseline's step penalty")] = -0.0001

    def motion(self, robot: Robot) -> MoveJ:
        """How actions move `robot`: the A of the tuple."""
        return MoveJ.within_limits(robot, self.speed, self.acceleration, self.control_period)

    def observation(self, robot: Robot) -> ArmObservation:
        """What the learner sees of `robot`: the S of the tuple."""
        return ArmObservation(robot, self.control_period)

    def check(self, robot: Robot) -> None:
        """See whether episodes can be drawn for `robot`.

        Raises:
            UsageError: It reaches none of the targets, or starts at all of them.
        """
        rng = np.random.default_rng(0)
        targets = self.draw_targets(robot, rng, 64)
        tips = robot.end_effector(np.stack([self.draw_start(robot, rng) for _ in targets]))
        if (np.linalg.norm(targets - tips, axis=1) <= self.epsilon).all():
            raise UsageError(f"epsilon={self.epsilon:g} m covers the box of targets from the start: choose less")

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Float:
        """Joint positions at the start of an episode, (dof,), within the joint ranges."""
        noise = rng.uniform(-self.start_noise, self.start_noise, robot.dof)
        return np.minimum(np.maximum(robot.home + noise, robot.lower), robot.upper)

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Float:
        """Targets that the arm can reach, uniform in the box, (count, 3), world frame, [m].

        Raises:
            UsageError: The arm reaches next to none of the box.
        """
        center, half = np.array(self.target_center), np.array(self.target_half_extent)
        found = np.empty((0, 3))
        for _ in range(20):
            drawn = center + rng.uniform(-1.0, 1.0, (count, 3)) * half
            _, reached = reach_position(robot, drawn, np.tile(robot.home, (count, 1)))
            found = np.concatenate([found, drawn[reached]])
            if len(found) >= count:
                return found[:count]
        raise UsageError(
            f"The end effector of {robot.name} reaches next to no target in the box {self.target_center} +- "
            f"{self.target_half_extent} m: choose target_center and target_half_extent within its reach"
        )
