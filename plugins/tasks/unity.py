"""The baseline's own tasks, as its public Unity project defines them, in this project's right-handed z-up frame.

A point (x, y, z) of Unity's left-handed y-up frame is (z, -x, y) here.
"""

from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field, PositiveFloat
from pydantic.dataclasses import dataclass

from harness import Float, Float32
from harness.errors import UsageError
from harness.reward import Pay
from harness.robot import Robot, forward, reach_position
from harness.task import LONGEST_EPISODE, Motion, Setting, Targets, build_motion

if TYPE_CHECKING:
    from harness.env.episodes import Episodes

Count = Annotated[int, Field(gt=0, le=LONGEST_EPISODE)]
Metres3 = tuple[float, float, float]

FROM_BASE = np.array([[0.3, 0.6], [-0.6, -0.3], [0.1, 0.3]])
"""Box of the targets that are drawn relative to the base: lowest and highest value of each axis, (3, 2), [m]."""

FROM_TIP = np.array([[0.01, 0.15], [-0.15, -0.01], [0.01, 0.15]])
"""The same for the targets that are drawn relative to the end effector."""

FIXED_TARGET = np.array([0.45, -0.45, 0.2])
"""The target of the published experiment, relative to the base, (3,), [m]."""

START_HEIGHT = (0.1, 1.0)
"""Lowest and highest place of the end effector above the ground at a random start, [m]."""

START_TRIES = 100


@dataclass(frozen=True)
class UnityReach:
    """The baseline's task: start and target are random, and a decision every 5 steps sets the joint angles.

    The arm jumps from pose to pose. Touching the target pays 0.5, and up to 1 more for an upright end effector. Then
    the next target is set, and the episode goes on. Touching the ground ends the episode. The observation is that of
    the baseline: 14 numbers, and one per joint.
    """

    epsilon: Annotated[
        PositiveFloat,
        Field(description="distance within which the target counts as touched; the sources do not state it [m]"),
    ] = 0.05
    horizon: Annotated[Count, Field(description="environment steps after which an episode is truncated")] = 5000
    decision_period: Annotated[Count, Field(description="environment steps per decision; each step pays a reward")] = 5
    control_period: Annotated[
        PositiveFloat,
        Field(description="duration of an environment step, Unity's default; no effect on set-joints, which jumps [s]"),
    ] = 0.02
    action: Annotated[
        str, Field(description="action mode: set-joints as published, or movej, movej-absolute, movel, movea, discrete")
    ] = "set-joints"
    speed: Annotated[
        float,
        Field(gt=0, le=1, description="fraction of a joint's maximum speed that may be used; set-joints ignores it"),
    ] = 0.8
    acceleration: Annotated[
        float,
        Field(
            gt=0, le=1, description="fraction of a joint's maximum acceleration that may be used; set-joints ignores it"
        ),
    ] = 0.6
    base_position: Annotated[
        Metres3, Field(description="position of the base in the scene; it turns the observed unit vectors [m]")
    ] = (0.0, 0.0, 0.0)
    ground_reward: Annotated[Pay, Field(description="reward for touching the ground, which ends the episode")] = -1.0
    target_reward: Annotated[Pay, Field(description="reward for touching the target")] = 0.5
    upright_reward: Annotated[Pay, Field(description="extra target reward for an end effector that points up")] = 1.0
    step_reward: Annotated[Pay, Field(description="reward on every environment step")] = -0.0001

    robot: ClassVar[str] = "unity-arm"
    ends_at_target: ClassVar[bool] = False

    def motion(self, robot: Robot) -> Motion:
        return build_motion(self.action, Setting(robot, self.control_period, self.speed, self.acceleration))

    def observation(self, robot: Robot) -> "UnityObservation":
        return UnityObservation(robot, np.array(self.base_position))

    def target_rewards(self, robot: Robot, qpos: Float) -> Float:
        """What each arm is paid for its target, (n,).

        It is `target_reward`, and `upright_reward` times the cosine between the end effector's z axis and up, if that
        is positive.
        """
        upright = np.clip(forward(robot.chain, qpos)[:, 2, 2], 0.0, 1.0)
        rewards: Float = self.target_reward + self.upright_reward * upright
        return rewards

    def check(self, robot: Robot) -> None:
        self.motion(robot)

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Float:
        """A start uniform in the joint ranges, (dof,).

        It is drawn again until the end effector is at a height of 0.1 to 1 m, at most 100 times.
        """
        low, high = START_HEIGHT
        for _ in range(START_TRIES):
            qpos = rng.uniform(robot.lower, robot.upper)
            if low <= robot.end_effector(qpos)[2] <= high:
                break
        return qpos

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        """Targets, each with probability 1/2 in a box beside the base, else near the end effector."""
        relative = rng.random(count) < 0.5
        low, high = np.where(relative[:, None, None], FROM_TIP, FROM_BASE).transpose(2, 0, 1)
        return Targets(rng.uniform(low, high), relative)

    def start_in_words(self, robot: Robot) -> str:
        return "uniform in the joint ranges, the end effector 0.1 to 1 m above the ground"

    def target_in_words(self, robot: Robot) -> str:
        return "half of the times uniform in a box beside the base, else within 0.01 to 0.15 m of the end effector"

    def target_reward_in_words(self) -> str:
        return f"{self.target_reward:+g}, and up to {self.upright_reward:+g} for an end effector that points up"


@dataclass(frozen=True)
class Arp2021(UnityReach):
    """The published experiment: the task `unity-reach` from the robot's home pose to one fixed target.

    The home pose of `unity-arm` is the experiment's start, (-18, 9, -18, 9, 9) degrees.
    """

    varies: ClassVar[bool] = False

    def check(self, robot: Robot) -> None:
        self.motion(robot)
        _, reached = reach_position(robot, FIXED_TARGET[None], robot.home[None], tolerance=self.epsilon)
        if not reached.all():
            raise UsageError(
                f"The end effector of {robot.name} does not reach the fixed target {tuple(FIXED_TARGET.tolist())} m: "
                "take its own robot, unity-arm, or the task unity-reach"
            )

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Float:
        """The home pose."""
        return robot.home

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        """The fixed target, each time."""
        return Targets(np.tile(FIXED_TARGET, (count, 1)), np.zeros(count, bool))

    def start_in_words(self, robot: Robot) -> str:
        return "the home pose"

    def target_in_words(self, robot: Robot) -> str:
        return f"{tuple(FIXED_TARGET.tolist())} m"


class UnityObservation:
    """The baseline's observation, dof + 14 numbers.

    ============================  =====  ========================================================================
    joint angles                  dof    scaled like the action that sets them, in [-1, 1]
    base, target, end effector,   3 x 4  unit vectors in the scene's frame, each axis in [-1, 1]; a zero vector
    target - end effector                stays zero
    distance                      1      end effector to target, [m]
    step                          1      always 0: the original divides the step by 5000 in whole numbers
    ============================  =====  ========================================================================
    """

    def __init__(self, robot: Robot, base_position: Float) -> None:
        self._middle, self._half = (robot.lower + robot.upper) / 2.0, (robot.upper - robot.lower) / 2.0
        self._base = base_position
        extent = 2.0 * robot.extent + 1.0
        # The step is always 0, but the bounds of a space must differ.
        self._high = np.concatenate([np.ones(robot.dof + 12), [extent, 1.0]])
        self._low = np.concatenate([-np.ones(robot.dof + 12), [0.0, 0.0]])

    @property
    def low(self) -> Float32:
        """Lower bounds, (dof + 14,)."""
        return self._low.astype(np.float32)

    @property
    def high(self) -> Float32:
        """Upper bounds, (dof + 14,)."""
        return self._high.astype(np.float32)

    def observe(self, episodes: "Episodes") -> Float32:
        base = np.broadcast_to(self._base, episodes.target.shape)
        vectors = (base, base + episodes.target, base + episodes.end_effector, episodes.offset)
        joints = (episodes.qpos - self._middle) / self._half
        last = np.stack([episodes.distance, np.zeros_like(episodes.distance)], axis=1)
        seen = np.concatenate([joints, *map(_unit, vectors), last], axis=1)
        shown: Float32 = np.minimum(np.maximum(seen, self._low), self._high).astype(np.float32)
        return shown


def _unit(vectors: Float) -> Float:
    """Each vector, (n, 3), with length 1; a zero vector stays zero."""
    length = np.sqrt(np.vecdot(vectors, vectors))[:, None]
    unit: Float = vectors / np.where(length > 0.0, length, 1.0)
    return unit
