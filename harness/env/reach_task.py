"""The reach task of the FD100, with everything that the project adds to the NOTE's tuple <S, A, T, R>."""

import math
from collections.abc import Mapping
from dataclasses import fields
from functools import lru_cache
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.arrays import Float, Mask
from harness.conditions.clearance import Clearance
from harness.conditions.conditions import Conditions
from harness.conditions.obstacles import distance_from, parse_obstacles
from harness.env.arm_observation import ArmObservation, GoalObservation
from harness.errors import UsageError
from harness.goal import Situation
from harness.motion.modes import build_motion
from harness.motion.motion import Motion, Setting
from harness.reward import Pay
from harness.robot import Robot
from harness.robot.kinematics import end_effector_position, in_mount, reach_position, read_only
from harness.task import LONGEST_EPISODE, Targets, goal_of

Positive = Annotated[float, Field(gt=0)]
Metres3 = tuple[float, float, float]
Extents = tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)]]

FD100_CENTER = np.array([0.85, 0.0, 0.7])
FD100_HALF_EXTENT = np.array([0.2, 0.3, 0.3])
"""Half the edges of the FD100's box of targets, (3,), [m]; its centre stands above."""
FD100_MOUNT = 0.43
"""Height of the FD100's first joint over the world's origin, [m]: its box has that room for an arm's stand."""
BESIDE = 1.0 + 1e-9
"""Up to this slope, 45 degrees, a home is on a side of its mount."""
NOT_BEFORE = 0.1
"""A home that is nearer to its first joint, seen from above the mount, has no side; as a share of the reach."""
ABOVE_GROUND = 0.05
"""How far the lowest targets are above the ground at least, as a share of the reach."""
PROBES, LEAST_REACHED = 64, 0.3
"""Points of a box that tell how much of it an arm reaches, and the share of them that is enough."""
NEAR, PLACES, MOST_OF_THEM = 0.25, 1_024, 0.1
"""Poses near home: within 45 degrees, or a quarter of a slide's range; and the share left out on every side of them."""

START_NOISE = (
    "largest distance of a joint from the robot's home pose at the start, +- [rad]; of a sliding joint as large a "
    "share of its range as that angle is of a full turn"
)
START_TRIES = 100
"""How often a start is drawn until it is clear of the fixed obstacles."""


@dataclass(frozen=True)
class ReachTask(Conditions):
    """Bring the end effector of an arm within epsilon of a target.

    The defaults are those of the FD100 (`fd100-reach`). For another arm the box of targets is scaled by its reach
    and stands on its mount, see `place_box`; so is what `lengths` names, see `defaults_for`.
    """

    epsilon: Annotated[Positive, Field(description="distance within which the target is reached, NOTE eq. 20 [m]")] = (
        0.05
    )
    horizon: Annotated[
        int, Field(gt=0, le=LONGEST_EPISODE, description="steps after which an episode is truncated")
    ] = 100
    control_period: Annotated[Positive, Field(description="duration of one step [s]")] = 0.1
    action: Annotated[
        str,
        Field(description="action mode: movej, movej-absolute, movel, movea, set-joints or discrete, NOTE Table II"),
    ] = "movej"
    target_center: Annotated[
        Metres3 | None,
        Field(
            description="centre of the targets' box, world frame [m]; None: in fd100-reach 0.85x0x0.7, scaled by "
            "reach, moved with the mount"
        ),
    ] = None
    target_half_extent: Annotated[
        Extents | None,
        Field(description="half the edges of the targets' box [m]; None: in fd100-reach 0.2x0.3x0.3, scaled by reach"),
    ] = None
    start_noise: Annotated[float, Field(ge=0, description=START_NOISE)] = math.radians(6)
    speed: Annotated[
        float, Field(gt=0, le=1, description="fraction of a joint's maximum speed that may be used, NOTE Table I")
    ] = 0.8
    acceleration: Annotated[
        float,
        Field(gt=0, le=1, description="fraction of a joint's maximum acceleration that may be used, NOTE Table I"),
    ] = 0.6
    ground_reward: Annotated[Pay, Field(description="reward for touching the ground, NOTE eq. 18")] = -1.0
    target_reward: Annotated[Pay, Field(description="reward for reaching the target, NOTE eq. 19")] = 1.0
    step_reward: Annotated[Pay, Field(description="reward on every step: the baseline's step penalty")] = -0.0001

    robot: ClassVar[str] = "fd100"
    lengths: ClassVar[tuple[str, ...]] = ("epsilon",)
    ends_at_target: ClassVar[bool] = True
    decision_period: ClassVar[int] = 1

    def defaults_for(self, robot: Robot) -> Mapping[str, Any]:
        """See `harness.task.Task`: what `lengths` names, as large a share of the reach as it is of the FD100's."""
        if self.robot != ReachTask.robot:  # its numbers were chosen for that arm
            return {}
        defaults = {field.name: field.default for field in fields(self)}
        return {name: _scaled(defaults[name], robot) for name in self.lengths}

    def motion(self, robot: Robot) -> Motion:
        return build_motion(self.action, Setting(robot, self.control_period, self.speed, self.acceleration))

    def observation(self, robot: Robot) -> ArmObservation:
        goal, seen = goal_of(self, robot), self.obstacles_seen if self.most_obstacles else 0
        period = self.control_period
        return ArmObservation(robot, period, seen) if goal is None else GoalObservation(robot, period, goal, seen)

    def target_rewards(self, robot: Robot, qpos: Float) -> Float:
        """`target_reward` for each arm, (n,)."""
        return np.full(len(qpos), self.target_reward)

    def target_box(self, robot: Robot) -> tuple[Float, Float]:
        """Centre and half edges of the box of targets, (3,) both, [m]."""
        center, half = default_box(robot)
        center = center if self.target_center is None else np.array(self.target_center)
        half = half if self.target_half_extent is None else np.array(self.target_half_extent)
        return center, half

    def check(self, robot: Robot) -> None:
        """See `harness.task.Task`.

        Raises:
            UsageError: The arm cannot do the task, or epsilon is so large that all episodes start at their targets.
        """
        self.motion(robot)
        if (self._begin_errors(robot, np.random.default_rng(0)) <= self.epsilon).all():
            raise UsageError(f"epsilon={self.epsilon:g} m covers the targets from the start: choose less")

    def draw_start(self, robot: Robot, rng: np.random.Generator) -> Float:
        """The home pose with noise, (dof,), within the joint ranges and away from fixed obstacles.

        Raises:
            UsageError: The arm touches fixed obstacles in all of the 100 starts that were drawn.
        """
        for _ in range(START_TRIES):
            noise = rng.uniform(-self.start_noise, self.start_noise, robot.dof) * robot.per_radian
            start = np.minimum(np.maximum(robot.home + noise, robot.lower), robot.upper)
            if not self.obstacles or not self._touches(robot, start[None])[0]:
                return start
        raise UsageError("The fixed obstacles touch the arm at its start: move them, or make them smaller")

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        """Targets that the arm can reach, uniform in the box.

        Raises:
            UsageError: The arm reaches almost no point of the box, or fixed obstacles leave almost none free.
        """
        center, half = self.target_box(robot)
        found = np.empty((0, 3))
        for _ in range(20):
            drawn = center + rng.uniform(-1.0, 1.0, (count, 3)) * half
            poses, reached = reach_position(robot, drawn, np.tile(robot.home, (count, 1)))
            if self.obstacles:
                reached &= self._are_free(robot, drawn, poses)
            found = np.concatenate([found, drawn[reached]])
            if len(found) >= count:
                return Targets(found[:count], np.zeros(count, bool))
        raise UsageError(
            f"The end effector of {robot.name} reaches next to no target in the box {_text(center)} +- {_text(half)} "
            f"m{' that the fixed obstacles leave free' * bool(self.obstacles)}: choose target_center and "
            "target_half_extent within its reach"
        )

    def _begin_errors(self, robot: Robot, rng: np.random.Generator) -> Float:
        """The errors with which 64 episodes begin, (64,): distances, [m], or the errors of the task's goal."""
        targets, _ = self.draw_targets(robot, rng, 64)
        goal, none = goal_of(self, robot), np.zeros(len(targets))
        numbers = np.zeros((len(targets), 0)) if goal is None else goal.draw(rng, targets)
        starts = np.stack([self.draw_start(robot, rng) for _ in targets])
        tips = robot.end_effector(starts)
        if goal is None:
            return np.asarray(np.linalg.norm(targets - tips, axis=1))
        return goal.errors(Situation(starts, tips, targets, numbers, none, none))

    def _are_free(self, robot: Robot, targets: Float, poses: Float) -> Mask:
        """Whether each target, and the pose in which the arm reaches it, are clear of the fixed obstacles, (count,)."""
        distance = distance_from(targets[:, None], parse_obstacles(self.obstacles)).min(axis=1)
        free: Mask = (distance > self.epsilon + self.obstacle_clearance) & ~self._touches(robot, poses)
        return free

    def _touches(self, robot: Robot, poses: Float) -> Mask:
        fixed = parse_obstacles(self.obstacles)
        return Clearance(robot).touches(poses, np.tile(fixed, (len(poses), 1, 1)), self.obstacle_clearance)

    def start_in_words(self, robot: Robot) -> str:
        slides = f" (a slide +- {self.start_noise / math.tau:.2%} of its range)" * bool(robot.chain.slides.any())
        return f"the home pose, each joint +- {math.degrees(self.start_noise):.3g} deg{slides}, from the seed"

    def target_in_words(self, robot: Robot) -> str:
        center, half = self.target_box(robot)
        return f"uniform in the box {_text(center)} +- {_text(half)} m where the arm reaches"

    def target_reward_in_words(self) -> str:
        return f"{self.target_reward:+g}"


def _scaled(length: Any, robot: Robot) -> Any:
    """A length, or several, that were chosen for the FD100, for another arm."""
    return tuple(map(robot.scaled, length)) if isinstance(length, tuple) else robot.scaled(length)


@lru_cache(maxsize=16)
def default_box(robot: Robot) -> tuple[Float, Float]:
    """The FD100's box for another arm, or a box of its own where it reaches next to nothing of that.

    Returns:
        Centre and half edges in the world, (3,) both, read-only, [m].
    """
    center, half = place_box(robot, FD100_CENTER, FD100_HALF_EXTENT)
    center[2] = max(center[2], half[2] + ABOVE_GROUND * robot.reach)
    drawn = center + np.random.default_rng(0).uniform(-1.0, 1.0, (PROBES, 3)) * half
    _, reached = reach_position(robot, drawn, np.tile(robot.home, (PROBES, 1)))
    center, half = (center, half) if reached.mean() >= LEAST_REACHED else _box_around_home(robot)
    return read_only(center), read_only(half)


def _box_around_home(robot: Robot) -> tuple[Float, Float]:
    """The box of most places of the end effector over the ground near home; see `NEAR`."""
    near = np.where(robot.chain.slides, NEAR * (robot.upper - robot.lower), NEAR * math.pi)
    poses = robot.home + np.random.default_rng(0).uniform(-1.0, 1.0, (PLACES, robot.dof)) * near
    tips = robot.end_effector(np.clip(poses, robot.lower, robot.upper))
    low, high = np.quantile(tips[tips[:, 2] > ABOVE_GROUND * robot.reach], (MOST_OF_THEM, 1.0 - MOST_OF_THEM), axis=0)
    return (low + high) / 2.0, (high - low) / 2.0


def place_box(robot: Robot, center: Float, half_extent: Float) -> tuple[Float, Float]:
    """A box that was chosen for the FD100, for another arm: scaled by its reach, on its mount, turned to its front.

    The front is the side of the mount, of its four, on which the end effector is at home: +x but for an arm that
    cannot work there.

    Args:
        robot: The arm.
        center: Of the FD100's box, (3,), [m].
        half_extent: Half its edges, (3,), [m].

    Returns:
        Centre and half edges in the world, (3,) both, new arrays, [m]. Of an arm that leans, its edges are those of the
        smallest box around the one that leans with it.
    """
    scale = robot.scale
    mount = robot.chain.T_world_mount
    turned = mount[:3, :3] @ _front(robot)
    from_mount = turned @ (scale * center) + mount[:3, :3] @ way_to_mount(robot)
    return mount[:3, 3] + from_mount, np.abs(turned) @ (scale * half_extent)


def _front(robot: Robot) -> Float:
    """R_mount_front: the turn about the mount's z axis, by whole quarters, that leads from its x axis to the front."""
    mounted = in_mount(robot.chain)
    x, y, _ = end_effector_position(mounted, robot.home) - mounted.T_previous_joint[0, :3, 3]
    if abs(y) <= x * BESIDE or math.hypot(x, y) < NOT_BEFORE * robot.reach:
        return np.eye(3)
    cos, sin = (-1.0, 0.0) if abs(y) <= -x * BESIDE else (0.0, math.copysign(1.0, y))
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def way_to_mount(robot: Robot) -> Float:
    """By how much a box of targets, scaled by the arm's reach, moves with the first joint, (3,), the mount's frame [m].

    It is 0 for an arm whose first joint is no farther from the mount's origin, up and aside, than the FD100's, scaled
    likewise: how far along its axis a first joint stands is the choice of who wrote the URDF. For one that is farther
    away, on a table or beside the origin, it is the rest of the way.
    """
    first = in_mount(robot.chain).T_previous_joint[0, :3, 3]
    aside, room = np.array([first[0], first[1], 0.0]), FD100_MOUNT * robot.scale
    distance = float(np.linalg.norm(aside))
    beyond = max(distance - room, 0.0) / distance if distance else 0.0
    up = max(float(first[2]) - room, 0.0)
    way: Float = beyond * aside + np.array([0.0, 0.0, up])
    return way


def _text(vector: Float) -> str:
    return f"({', '.join(f'{number:.3g}' for number in vector)})"
