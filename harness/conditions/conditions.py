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
    Field(
        description="standard deviation of noise on observed joint angles [rad], of slides as of start_noise; the end "
        "effector follows from them"
    ),
]
SpeedNoise = Annotated[
    Deviation,
    Field(
        description="standard deviation of noise on observed joint speeds [rad/s], of slides likewise; 1.41 times that "
        "on their changes"
    ),
]
TargetNoise = Annotated[
    Deviation, Field(description="standard deviation of noise on each observed coordinate of the target [m]")
]
ActionNoise = Annotated[Deviation, Field(description="standard deviation of noise on actions; a full action is 1")]
ObservationDelay = Annotated[Periods, Field(description="age of what the learner observes [control periods]")]
ActionDelay = Annotated[Periods, Field(description="delay before an action takes effect [control periods]")]
Obstacles = Annotated[
    str,
    AfterValidator(_checked),
    Field(description="fixed obstacles joined by +: sphere XxYxZxRADIUS, or box XxYxZxAxBxC with edges A, B, C [m]"),
]
ObstacleCount = Annotated[
    int, Field(ge=0, le=20, description="most random obstacles, drawn anew in each episode; 0 to 20")
]
ObstacleSize = Annotated[
    tuple[Size, Size],
    AfterValidator(_ordered),
    Field(description="smallest and largest radius, or half edge, of a random obstacle [m]"),
]
ObstacleClearance = Annotated[
    Metres, Field(description="distance within which the arm counts as touching an obstacle [m]")
]
ObstacleReward = Annotated[float, Field(description="reward for touching an obstacle, which ends the episode")]
ObstaclesSeen = Annotated[
    int, Field(ge=1, le=20, description="obstacles that the learner observes, the nearest first; 1 to 20")
]
MassVariation = Annotated[
    Share, Field(description="largest relative change of the moving links' masses; 0.2 is +- 20 %")
]
LengthVariation = Annotated[
    Share, Field(description="largest relative change of the moving links' sizes, which the learner does not see")
]
FrictionVariation = Annotated[
    Share, Field(description="largest relative change of the drives' friction, if the robot describes its drives")
]
Variants = Annotated[int, Field(ge=1, le=1000, description="number of different arms; each episode draws one of them")]
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
