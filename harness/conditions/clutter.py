"""Obstacles drawn for one episode, such that it can still be done."""

import numpy as np

from harness.arrays import Float, Mask
from harness.conditions.clearance import Clearance
from harness.conditions.conditions import Conditions
from harness.conditions.obstacles import CENTER, EDGES, NUMBERS, RADIUS, distance_from, parse_obstacles
from harness.robot import Robot
from harness.robot.inverse_kinematics import reach_position

MARGIN = 0.03
"""More than the clearance, from the arm at its start and from the target, [m]."""
TRIES = 20
"""How often a place for an obstacle is tried; an obstacle that finds none is left out."""
WAYS, POSES = 12, 12
"""Ways from start to target that are tried, and poses looked at on each half of one."""
SPREAD = 0.15
"""How far an obstacle lies from the line between end effector and target, along each axis, as a share of the arm's
reach."""


def draw_clutter(
    conditions: Conditions,
    robot: Robot,
    clearance: Clearance,
    start: Float,
    target: Float,
    epsilon: float,
    rng: np.random.Generator,
) -> Float:
    """The fixed obstacles, then the drawn ones.

    A drawn one is a sphere or a box, somewhere between the end effector and the target. It stays away from the arm at
    its start, from the target, and from one pose in which the arm reaches it; and one of `WAYS` ways to that pose stays
    free: straight in joint space, or by way of one other pose.

    Args:
        conditions: How many, how large.
        robot: The arm of the episode.
        clearance: Its shapes.
        start: Joint positions at the start, (dof,).
        target: (3,), world frame, [m].
        epsilon: The target is reached within this distance, [m].
        rng: The episode's.

    Returns:
        (conditions.most_obstacles, 7); zeros where an obstacle found no place.
    """
    fixed = parse_obstacles(conditions.obstacles)
    clutter = np.zeros((conditions.most_obstacles, NUMBERS))
    clutter[: len(fixed)] = fixed
    ways = _ways(robot, clearance, start, target, rng)
    tip = robot.end_effector(start)
    apart = conditions.obstacle_clearance + MARGIN
    for number in range(len(fixed), len(clutter)):
        for candidate in _candidates(conditions, robot, tip, target, rng):
            if distance_from(target, candidate) <= epsilon + apart:
                continue
            if clearance.touches(start[None], candidate[None, None], apart)[0]:
                continue
            free = _free(ways, clearance, candidate, conditions.obstacle_clearance)
            if free.any():
                clutter[number], ways = candidate, ways[free]
                break
    return clutter


def _candidates(conditions: Conditions, robot: Robot, tip: Float, target: Float, rng: np.random.Generator) -> Float:
    """(TRIES, 7)."""
    low, high = conditions.obstacle_size
    along = rng.uniform(0.2, 0.8, (TRIES, 1))
    aside = rng.uniform(-1.0, 1.0, (TRIES, 3)) * SPREAD * robot.reach
    sizes, is_box = rng.uniform(low, high, (TRIES, 4)), rng.random(TRIES) < 0.5
    drawn = np.zeros((TRIES, NUMBERS))
    drawn[:, CENTER] = tip + along * (target - tip) + aside
    drawn[is_box, EDGES] = sizes[is_box, :3]
    drawn[~is_box, RADIUS] = sizes[~is_box, 3]
    return drawn


def _ways(robot: Robot, clearance: Clearance, start: Float, target: Float, rng: np.random.Generator) -> Float:
    """Joint positions on the way, (ways, poses, dof), without those that lead through the ground; maybe none."""
    goals, reached = reach_position(robot, target[None], start[None])
    if not reached[0]:
        return np.empty((0, 2 * POSES, robot.dof))
    middle = (start + goals[0]) / 2.0
    by = middle + rng.normal(0.0, 0.5, (WAYS, robot.dof)) * (np.arange(WAYS) > 0)[:, None]
    by = np.minimum(np.maximum(by, robot.lower), robot.upper)[:, None]
    share = np.linspace(0.0, 1.0, POSES)[None, :, None]
    ways = np.concatenate([start + share * (by - start), by + share * (goals[0] - by)], axis=1)
    low = clearance.touches_ground(ways.reshape(-1, robot.dof)).reshape(ways.shape[:2]).any(axis=1)
    free: Float = ways[~low]
    return free


def _free(ways: Float, clearance: Clearance, obstacle: Float, apart: float) -> Mask:
    """Which ways an obstacle leaves free, (ways,)."""
    poses = ways.reshape(-1, ways.shape[-1])
    touched = clearance.touches(poses, np.broadcast_to(obstacle, (len(poses), 1, NUMBERS)), apart)
    free: Mask = np.logical_not(touched.reshape(ways.shape[:2]).max(axis=1))
    return free
