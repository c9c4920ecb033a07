"""What every simulator is told: poses, motions, and dives that end below the ground."""

from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from harness import Float
from harness.env.solid_probes import Probe, few_points, probes_of
from harness.robot import Robot, build_solids
from harness.robot.ground_clearance import Solids
from harness.robot.kinematics import link_frames, reach_position

from .classes import CONTACT, SMOOTH, class_motions, in_order
from .motions import ACCELERATION, SPEED, Held, draw_start, smooth_motions
from .track import random_poses

DEPTH, SHALLOW = 0.1, 0.01
"""A dive's goal lies so far below the ground, or less where the arm does not get there, [m]."""
NEAREST, FARTHEST = 0.35, 0.75
"""Horizontal distance of the goal from the base, as a share of the arm's reach."""
SIDEWAYS = np.radians(60.0)
"""The goal is at most so far to either side of the x axis."""
GOALS = 32
"""Drawn for each dive, of which the first within reach is taken."""
POSES = 1_024
"""Drawn for each dive of an arm whose tip does not reach a goal."""
ROUNDS, NEARER = 8, 0.6
"""How often poses are drawn, the next time nearer around the lowest one by this factor."""


def dive_motions(robot: Robot, seed: int, episodes: int, period: float) -> Float | None:
    """Joint targets from rest near home straight, in joint space, to a tip `DEPTH` below the ground.

    Where the tip of the arm does not get there, it goes to a pose with a solid `DEPTH` below it, or else `SHALLOW`.

    Speeds rise and fall as half a sine, to no more than `SPEED` and `ACCELERATION` of the maxima. Whoever arrives
    before the slowest one waits there.

    Args:
        robot: The arm.
        seed: Of all that is drawn.
        episodes: How many dives, >= 1.
        period: Control period, [s].

    Returns:
        (rows, episodes, dof), [rad]; row 0 is where the arm starts. None if the arm reaches no such goal.
    """
    solids = _solids_above(robot)
    ways = (
        partial(_draw_ends, robot),
        partial(_draw_solid_ends, robot, solids, DEPTH),
        partial(_draw_solid_ends, robot, solids, SHALLOW),
    )
    for way in ways:
        ends = [way(np.random.default_rng([seed, 1, episode])) for episode in range(episodes)]
        found = [pair for pair in ends if pair is not None]
        if len(found) == episodes:
            break
    else:
        return None
    start, goal = np.array(found).swapaxes(0, 1)  # (episodes, dof)
    periods = _periods(robot, np.abs(goal - start), period)
    done = np.minimum(np.arange(periods.max() + 1)[:, None] / periods, 1.0)  # (rows, episodes)
    return np.asarray(start + (0.5 - 0.5 * np.cos(np.pi * done))[..., None] * (goal - start))


def _draw_ends(robot: Robot, rng: np.random.Generator) -> tuple[Float, Float] | None:
    """Joint positions at start and goal, (dof,) each; None if no drawn goal is within reach."""
    start = draw_start(robot, rng)
    radius = rng.uniform(NEAREST, FARTHEST, GOALS) * robot.reach
    angle = rng.uniform(-SIDEWAYS, SIDEWAYS, GOALS)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(GOALS, -DEPTH)])
    goals, reached = reach_position(robot, points, np.tile(start, (GOALS, 1)))
    return (start, goals[reached.argmax()]) if reached.any() else None


def _solids_above(robot: Robot) -> Solids:
    """The solids that can come into the ground: at home those of their joint are above it."""
    shapes, home = few_points(robot.joint_shapes), link_frames(robot.chain, robot.home[None])
    alone = [[group if number == joint else () for number, group in enumerate(shapes)] for joint in range(robot.dof)]
    high = [bool(build_solids(groups).lowest(home)[0] > 0.0) for groups in alone]
    return build_solids([group if above else () for group, above in zip(shapes, high, strict=True)])


def _draw_solid_ends(
    robot: Robot, solids: Solids, depth: float, rng: np.random.Generator
) -> tuple[Float, Float] | None:
    """The same for the solids: of the drawn poses the nearest with one so deep in the ground, [m]."""
    start, around, spread = draw_start(robot, rng), 0.5 * (robot.lower + robot.upper), 0.5
    for _ in range(ROUNDS):
        drawn = around + spread * (robot.upper - robot.lower) * rng.uniform(-1.0, 1.0, (POSES, robot.dof))
        poses = np.clip(drawn, robot.lower, robot.upper)
        heights = solids.lowest(link_frames(robot.chain, poses))
        inside = poses[heights < -depth]
        if len(inside):
            far = np.linalg.norm((inside - start) / robot.per_radian, axis=1)
            return start, inside[far.argmin()]
        around, spread = poses[heights.argmin()], NEARER * spread
    return None


def _periods(robot: Robot, way: Float, period: float) -> Float:
    """Control periods that a dive takes at least, whole numbers, (episodes,); `way` is (episodes, dof), [rad].

    Half a sine of speed over a way w in a time T has the largest speed w pi / 2T and acceleration w pi^2 / 2T^2.
    """
    for_speed = np.pi * way / (2.0 * SPEED * robot.max_speed)
    for_acceleration = np.pi * np.sqrt(way / (2.0 * ACCELERATION * robot.max_acceleration))
    return np.asarray(np.ceil(np.maximum(for_speed, for_acceleration).max(axis=-1) / period), np.float64)


@dataclass(frozen=True)
class Setting:
    """What orders are drawn from.

    Attributes:
        robot: The arm.
        steps: Control periods of each smooth motion, >= 1.
        episodes: How many smooth motions, and how many dives, >= 1.
        seed: Of all that is drawn, >= 0.
        period: Control period, [s].
    """

    robot: Robot
    steps: int = 200
    episodes: int = 8
    seed: int = 0
    period: float = 0.1


class Orders(NamedTuple):
    """Joint positions to be placed at and driven to, [rad]."""

    poses: Float
    """(rounds, episodes, dof)"""
    motion: Float
    """(steps + 1, episodes, dof)"""
    dives: Float | None
    """(rows, episodes, dof); None if the arm does not reach the ground."""
    others: dict[str, Float]
    """Motions of the other classes, by class, (steps + 1, episodes, dof)."""
    probes: tuple[Probe, ...]
    """Poses that tell which solids a simulator lacks."""
    held: dict[str, Held]
    """What of the arm keeps away from the ground, by class but `CONTACT`."""

    @property
    def classes(self) -> dict[str, Float]:
        """Every class of motions, in the order in which they are shown."""
        dives = {} if self.dives is None else {CONTACT: self.dives}
        return in_order({SMOOTH: self.motion, **dives, **self.others})


def draw_orders(setting: Setting) -> Orders:
    """The same for the same setting."""
    robot, seed, episodes = setting.robot, setting.seed, setting.episodes
    simple = replace(robot, joint_shapes=tuple(map(tuple, few_points(robot.joint_shapes))))  # once, as it takes long
    smooth = smooth_motions(simple, seed, episodes, setting.steps, setting.period)
    drawn = class_motions(simple, seed, episodes, setting.steps, setting.period)
    return Orders(
        random_poses(robot, seed, episodes),
        smooth.motions,
        dive_motions(simple, seed, episodes, setting.period),
        {name: motions for name, (motions, _) in drawn.items()},
        probes_of(robot),
        {name: held for name, (_, held) in in_order({SMOOTH: smooth, **drawn}).items()},
    )
