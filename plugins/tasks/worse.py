"""The FD100's task under conditions in which a reward can fail: other defaults of the same parameters."""

from typing import Annotated, ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.conditions import later_than
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
)
from harness.reach import Positive, ReachTask

Epsilon = Annotated[Positive, Field(description="the target is reached within this distance, NOTE eq. 20 [m]")]


@dataclass(frozen=True)
class NoisyReach(ReachTask):
    """`fd100-reach` with noise on what is seen and done: a reward that pays for the best moment pays for luck."""

    epsilon: Epsilon = 0.02
    joint_noise: JointNoise = 0.03
    speed_noise: SpeedNoise = 0.1
    target_noise: TargetNoise = 0.03
    action_noise: ActionNoise = 0.3

    later: ClassVar[tuple[str, ...]] = later_than("joint_noise", "speed_noise", "target_noise", "action_noise")


@dataclass(frozen=True)
class DelayedReach(ReachTask):
    """`fd100-reach` where what is seen is old and what is done comes late: a reward for speed pays for overshooting."""

    observation_delay: ObservationDelay = 1
    action_delay: ActionDelay = 1

    later: ClassVar[tuple[str, ...]] = later_than("observation_delay", "action_delay")


@dataclass(frozen=True)
class ClutteredReach(ReachTask):
    """`fd100-reach` around obstacles that each episode draws: a reward for getting closer pays for the way through."""

    obstacle_count: ObstacleCount = 3

    later: ClassVar[tuple[str, ...]] = later_than("obstacle_count")


@dataclass(frozen=True)
class VariedReach(ReachTask):
    """`fd100-reach` with another arm in every episode, unseen: what was learnt of one is wrong for another."""

    epsilon: Epsilon = 0.03
    mass_variation: MassVariation = 0.3
    length_variation: LengthVariation = 0.15
    friction_variation: FrictionVariation = 0.5

    later: ClassVar[tuple[str, ...]] = later_than("mass_variation", "length_variation", "friction_variation")
