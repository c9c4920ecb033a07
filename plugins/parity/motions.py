"""Smooth motions through the air, the same for every simulator, whose solids keep away from the ground."""

from collections.abc import Callable
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from harness import Float, Mask
from harness.env.solid_probes import few_points
from harness.robot import Robot, build_solids
from harness.robot.ground_clearance import Solids
from harness.robot.kinematics import link_frames

CLEARANCE = 0.1
"""Height that the tip and each joint keep above the ground, as a share of the arm's reach."""
STILL, POSES = 1e-6, 64
"""A point stands still whose height differs by no more in so many poses, [m]; so many starts are tried as well."""
MARGIN = 0.02
"""Height that the solids of each joint keep above it, [m]; half of that at home where it is less, as in a turret."""
SPEED, ACCELERATION = 0.8, 0.6
"""Shares of a joint's maxima that may be used, NOTE Table I."""
START_NOISE = np.radians(6.0)
"""A joint starts within this of home, [rad]; a slide within that share of it, see `Robot.per_radian`."""
SLOWEST, FASTEST = 8.0, 2.0
"""Longest and shortest period of the sines that a motion is made of, [s]."""
SINES = 3
RUN_UP = 1.0
"""From rest to full swing, [s]."""
TRIES = 200
FARTHEST = (np.pi, np.pi / 4.0, np.pi / 12.0, np.pi / 36.0)
"""No joint goes farther from its start than this, [rad]; the next where `TRIES` motions all come near the ground."""
NOTHING = 1e-9
"""A joint that swings less than this, [rad], is not at any limit."""
Held = Literal["whole", "solids", "nothing"]
"""What keeps away from the ground: tip, joints and solids; the solids alone; nothing, where all that is in vain."""
HELD: tuple[Held, ...] = ("whole", "solids", "nothing")


class Drawn(NamedTuple):
    """Motions of a class."""

    motions: Float
    """Joint targets, (rows, episodes, dof), [rad]."""
    held: Held = "whole"
    """What of the arm keeps away from the ground in them."""


class GroundClearance:
    """What of an arm keeps away from the ground, ready to be held against it.

    Attributes:
        held: What that is. Of the solids alone each joint's keep `MARGIN`, or half of what they have at home where that
            is less, and those that stand in the ground at home need not keep anything: a part that cannot rise holds
            nothing up. Without any solids the same is asked of the points.
    """

    def __init__(self, robot: Robot, held: Held = "whole") -> None:
        """Prepare the solids, once for any number of poses."""
        self._robot, self.held = robot, held
        shapes = few_points(robot.joint_shapes)
        self._solids: list[Solids] = [
            build_solids([group if number == joint else () for number, group in enumerate(shapes)])
            for joint in range(robot.dof)
        ]

    def is_clear(self, qpos: Float) -> Mask:
        """Whether all keep their heights at each of the joint positions, (n, dof): (n,)."""
        clear = np.asarray((self._heights(qpos) >= self._needed).all(axis=0))
        if self.held == "whole":
            points = point_heights(self._robot, qpos)[self._rises]
            clear &= (points >= CLEARANCE * self._robot.reach).all(axis=0)
        return clear

    @cached_property
    def _rises(self) -> Mask:
        """Which of the points can change their heights, (dof,): a turret's next joint cannot meet the ground."""
        rng, robot = np.random.default_rng(0), self._robot
        heights = point_heights(robot, rng.uniform(robot.lower, robot.upper, (POSES, robot.dof)))
        return np.asarray(np.ptp(heights, axis=1) > STILL)

    @cached_property
    def _needed(self) -> Float:
        """How high the solids of each joint have to be, (dof, 1), [m]."""
        heights = self._heights(self._robot.home[None])
        needed = np.minimum(0.5 * heights, MARGIN)
        free = heights <= 0.0 if self.held == "solids" else np.full(heights.shape, self.held == "nothing")
        return np.where(free, -np.inf, needed)

    def _heights(self, qpos: Float) -> Float:
        """The lowest point of the solids of each joint, (dof, n), [m]; inf where there is none."""
        if self.held != "whole" and not any(self._robot.joint_shapes):
            return point_heights(self._robot, qpos)
        frames = link_frames(self._robot.chain, qpos)
        heights: Float = np.stack([solids.lowest(frames) for solids in self._solids])
        return heights


def first_drawn(robot: Robot, draw: Callable[[GroundClearance], Float | None], last: Held = "nothing") -> Drawn | None:
    """The motions that `draw` finds with the most of the arm held away from the ground; None if none even at `last`."""
    rng, grounds = np.random.default_rng(0), (GroundClearance(robot, held) for held in HELD[: HELD.index(last) + 1])
    starts = np.array([draw_start(robot, rng) for _ in range(POSES)])  # without a clear one a search would be in vain
    drawn = ((draw(ground), ground.held) for ground in grounds if ground.is_clear(starts).any())
    return next((Drawn(motions, held) for motions, held in drawn if motions is not None), None)


def point_heights(robot: Robot, qpos: Float) -> Float:
    """Heights of the origins of all joints but the first, which stands still, and of the tip, [m].

    Args:
        robot: The arm.
        qpos: Joint positions, (n, dof), [rad].

    Returns:
        Shape (dof, n). The links reach lower, by their thickness.
    """
    return np.vstack([link_frames(robot.chain, qpos)[1:, 2, 3], robot.end_effector(qpos)[:, 2]])


class Pace(NamedTuple):
    """How fast a swing may be: shares of each joint's maxima."""

    speed: float
    acceleration: float


SMOOTH = Pace(SPEED, ACCELERATION)


def smooth_motions(robot: Robot, seed: int, episodes: int, steps: int, period: float, pace: Pace = SMOOTH) -> Drawn:
    """Joint targets that start at rest near home and swing as sums of sines, clear of the ground.

    Each joint swings as far as its range and `pace` allow, whichever is met first; less far where such motions come
    near the ground, see `FARTHEST`. Where all of these do, less of the arm keeps away from it, see `Held`. Episode n of
    a seed is the same whatever the number of episodes, unless one of them needs that.

    Args:
        robot: The arm.
        seed: Of all that is drawn.
        episodes: How many motions, >= 1.
        steps: Control periods of each, >= 1.
        period: Control period, [s].
        pace: How fast the joints may be.

    Returns:
        Motions of (steps + 1, episodes, dof), [rad]; row 0 is where the arm starts.
    """

    def draw(ground: GroundClearance) -> Float | None:
        found = []
        for n in range(episodes):
            rng = np.random.default_rng([seed, 0, n])
            ways = (
                draw_clear(ground, lambda: draw_swinging(robot, rng, draw_start(robot, rng), steps, period, pace, far))  # noqa: B023
                for far in FARTHEST
            )
            motion = next((way for way in ways if way is not None), None)
            if motion is None:
                return None
            found.append(motion)
        return np.stack(found, axis=1)

    drawn = first_drawn(robot, draw)
    assert drawn is not None  # what keeps nothing away from the ground is always found
    return drawn


def draw_start(robot: Robot, rng: np.random.Generator) -> Float:
    """Joint positions near home and within the ranges, (dof,), [rad]."""
    noise = rng.uniform(-START_NOISE, START_NOISE, robot.dof) * robot.per_radian
    return np.minimum(np.maximum(robot.home + noise, robot.lower), robot.upper)


def draw_clear(ground: GroundClearance, draw: Callable[[], Float]) -> Float | None:
    """The first of `TRIES` drawn motions, (steps + 1, dof), that is clear of the ground; None if none is."""
    motions = (draw() for _ in range(TRIES))
    return next((motion for motion in motions if ground.is_clear(motion).all()), None)


def draw_swinging(
    robot: Robot,
    rng: np.random.Generator,
    start: Float,
    steps: int,
    period: float,
    pace: Pace = SMOOTH,
    farthest: float = np.pi,
) -> Float:
    """One motion from rest at `start`, (steps + 1, dof), [rad]; no joint goes farther away than `farthest`, [rad].

    A slide goes no farther than that share of its range, see `Robot.per_radian`.
    """
    swing = _draw_swing(rng, robot.dof, np.arange(steps + 1, dtype=np.float64) * period)
    return start + _largest_scale(robot, start, swing, period, pace, farthest) * swing


def _draw_swing(rng: np.random.Generator, dof: int, time: Float) -> Float:
    """Sums of sines that set in slowly, at most 1 rad, (len(time), dof)."""
    frequency = 2.0 * np.pi / rng.uniform(FASTEST, SLOWEST, (SINES, dof))
    phase = rng.uniform(0.0, 2.0 * np.pi, (SINES, dof))
    weight = rng.dirichlet(np.ones(SINES), dof).T
    sines = (weight * np.sin(frequency * time[:, None, None] + phase)).sum(axis=1)
    share = np.minimum(time / RUN_UP, 1.0)
    return np.asarray((share**2 * (3.0 - 2.0 * share))[:, None] * sines)


def _largest_scale(robot: Robot, start: Float, swing: Float, period: float, pace: Pace, farthest: float) -> Float:
    """By what each joint's swing may be multiplied to keep its range, speed and acceleration, (dof,)."""
    speed = np.diff(swing, axis=0, prepend=swing[:1]) / period  # the first row: at rest
    change = np.diff(speed, axis=0) / period
    limits = [
        (robot.upper - start, swing.max(axis=0)),
        (start - robot.lower, -swing.min(axis=0)),
        (pace.speed * robot.max_speed, np.abs(speed).max(axis=0)),
        (pace.acceleration * robot.max_acceleration, np.abs(change).max(axis=0)),
    ]
    scales = [limit / np.maximum(reached, NOTHING) for limit, reached in limits]
    return np.asarray(np.minimum(np.min(scales, axis=0), farthest * robot.per_radian))
