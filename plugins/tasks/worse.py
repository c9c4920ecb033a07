"""The FD100's task under conditions in which a reward can fail. Only the defaults of some parameters differ."""

from typing import Annotated, ClassVar

from pydantic import Field, PositiveFloat
from pydantic.dataclasses import dataclass

from harness.conditions.conditions import (
    ActionDelay,
    ActionNoise,
    FrictionVariation,
    JointNoise,
    LengthVariation,
    MassVariation,
    ObservationDelay,
    ObstacleCount,
    SpeedNoise,
    TargetNoise,
    later_than,
)
from harness.task import ReachTask

Epsilon = Annotated[PositiveFloat, Field(description="distance within which the target is reached, NOTE eq. 20 [m]")]


@dataclass(frozen=True)
class NoisyReach(ReachTask):
    """`fd100-reach` with noise on observations and actions. A reward for the best moment then pays for luck."""

    epsilon: Epsilon = 0.02
    joint_noise: JointNoise = 0.03
    speed_noise: SpeedNoise = 0.1
    target_noise: TargetNoise = 0.03
    action_noise: ActionNoise = 0.3

    later: ClassVar[tuple[str, ...]] = later_than("joint_noise", "speed_noise", "target_noise", "action_noise")
    lengths: ClassVar[tuple[str, ...]] = ("epsilon", "target_noise")


@dataclass(frozen=True)
class DelayedReach(ReachTask):
    """`fd100-reach` with old observations and late actions. A reward for speed then pays for overshooting."""

    observation_delay: ObservationDelay = 1
    action_delay: ActionDelay = 1

    later: ClassVar[tuple[str, ...]] = later_than("observation_delay", "action_delay")


@dataclass(frozen=True)
class ClutteredReach(ReachTask):
    """`fd100-reach` around obstacles that each episode draws.

    A reward for getting closer then pays for the way through an obstacle.
    """

    obstacle_count: ObstacleCount = 3

    later: ClassVar[tuple[str, ...]] = later_than("obstacle_count")
    lengths: ClassVar[tuple[str, ...]] = ("epsilon", "obstacle_size", "obstacle_clearance")


@dataclass(frozen=True)
class VariedReach(ReachTask):
    """`fd100-reach` with another arm in every episode, which the learner does not see.

    What it learns about one arm is wrong for another.
    """

    epsilon: Epsilon = 0.03
    mass_variation: MassVariation = 0.3
    length_variation: LengthVariation = 0.15
    friction_variation: FrictionVariation = 0.5

    later: ClassVar[tuple[str, ...]] = later_than("mass_variation", "length_variation", "friction_variation")
