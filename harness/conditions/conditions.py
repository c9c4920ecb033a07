"""The parameters of noise, delays, obstacles and varied arms. Tasks inherit them."""

from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field
from pydantic.dataclasses import dataclass

from harness.conditions.obstacles import parse_obstacles

Deviation = Annotated[float, Field(ge=0)]
Periods = Annotated[int, Field(ge=0, le=100)]
Share = Annotated[float, Field(ge=0, le=0.9)]
Metres = Annotated[float, Field(ge=0)]
Size = Annotated[float, Field(gt=0)]


def _checked(text: str) -> str:
    parse_obstacles(text)
    return text


def _ordered(sizes: tuple[float, float]) -> tuple[float, float]:
    if sizes[0] > sizes[1]:
        raise ValueError("the smallest size comes first")
    return sizes


JointNoise = Annotated[
    Deviation,
    Field(description="standard deviation of the joint angles that are seen, and so of the end effector [rad]"),
]
SpeedNoise = Annotated[
    Deviation, Field(description="the same of the joint speeds [rad/s]; of their changes 1.41 times as much")
]
TargetNoise = Annotated[Deviation, Field(description="the same of each coordinate of the target [m]")]
ActionNoise = Annotated[
    Deviation, Field(description="standard deviation of what is added to actions; a full action is 1")
]
ObservationDelay = Annotated[Periods, Field(description="what is seen is so many control periods old")]
ActionDelay = Annotated[Periods, Field(description="an action works so many control periods later")]
Obstacles = Annotated[
    str,
    AfterValidator(_checked),
    Field(description="fixed ones, joined by +: XxYxZxRADIUS is a sphere, XxYxZxAxBxC a box with these edges [m]"),
]
ObstacleCount = Annotated[int, Field(ge=0, le=20, description="drawn anew for each episode, at most so many")]
ObstacleSize = Annotated[
    tuple[Size, Size],
    AfterValidator(_ordered),
    Field(description="smallest and largest radius, or half edge, of those that are drawn [m]"),
]
ObstacleClearance = Annotated[Metres, Field(description="an arm that comes so near to an obstacle has touched it [m]")]
ObstacleReward = Annotated[float, Field(description="paid when the arm touches an obstacle, which ends it")]
ObstaclesSeen = Annotated[int, Field(ge=1, le=20, description="the learner sees so many obstacles, the nearest first")]
MassVariation = Annotated[
    Share, Field(description="masses of the moving links differ by up to this share; 0.2 is +- 20 %")
]
LengthVariation = Annotated[
    Share, Field(description="sizes of the moving links differ by up to this share; the learner does not see it")
]
FrictionVariation = Annotated[
    Share, Field(description="friction of the drives differs by up to this share, where the robot describes them")
]
Variants = Annotated[
    int, Field(ge=1, le=1000, description="so many different arms there are; each episode draws one of them")
]
"""This and the types above are those of the fields of `Conditions`.

A task that gives a field another default repeats its type.
"""


@dataclass(frozen=True)
class Conditions:
    """The conditions of a task's episodes: noise, delays, obstacles and varied arms. The defaults change nothing.

    A task has these parameters if it inherits this class. `conditions_of` returns the defaults for other tasks.

    `later` names the parameters that are left out of the task's identity while they have their defaults. A subclass
    may have a `later` of its own. It then repeats the names that stand here, adds its own, and leaves out the fields to
    which it gives another default; see `later_than`.
    """

    joint_noise: JointNoise = 0.0
    speed_noise: SpeedNoise = 0.0
    target_noise: TargetNoise = 0.0
    action_noise: ActionNoise = 0.0
    observation_delay: ObservationDelay = 0
    action_delay: ActionDelay = 0
    obstacles: Obstacles = ""
    obstacle_count: ObstacleCount = 0
    obstacle_size: ObstacleSize = (0.04, 0.1)
    obstacle_clearance: ObstacleClearance = 0.01
    obstacle_reward: ObstacleReward = -1.0
    obstacles_seen: ObstaclesSeen = 3
    mass_variation: MassVariation = 0.0
    length_variation: LengthVariation = 0.0
    friction_variation: FrictionVariation = 0.0
    variants: Variants = 16

    later: ClassVar[tuple[str, ...]] = (
        "joint_noise",
        "speed_noise",
        "target_noise",
        "action_noise",
        "observation_delay",
        "action_delay",
        "obstacles",
        "obstacle_count",
        "obstacle_size",
        "obstacle_clearance",
        "obstacle_reward",
        "obstacles_seen",
        "mass_variation",
        "length_variation",
        "friction_variation",
        "variants",
    )

    @property
    def is_noisy(self) -> bool:
        """Whether observations or actions are noisy."""
        return any((self.joint_noise, self.speed_noise, self.target_noise, self.action_noise))

    @property
    def is_varied(self) -> bool:
        """Whether the arm differs from episode to episode."""
        return any((self.mass_variation, self.length_variation, self.friction_variation))

    @property
    def are_plain(self) -> bool:
        """Whether the conditions change nothing."""
        delayed = self.observation_delay or self.action_delay
        return not (self.is_noisy or delayed or self.most_obstacles or self.is_varied)

    @property
    def most_obstacles(self) -> int:
        """The largest number of obstacles that an episode can have."""
        return len(parse_obstacles(self.obstacles)) + self.obstacle_count


PLAIN = Conditions()
"""The conditions of a task without such parameters."""


def later_than(*own: str) -> tuple[str, ...]:
    """The `later` of a task that gives the fields `own` other defaults. These fields then belong to its identity."""
    return tuple(name for name in Conditions.later if name not in own)


def conditions_of(task: object) -> Conditions:
    """The conditions of a task; `PLAIN` if it does not inherit `Conditions`."""
    return task if isinstance(task, Conditions) else PLAIN
