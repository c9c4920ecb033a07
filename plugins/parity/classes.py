"""Motions of several classes: slow, smooth, fast, near singular poses, and into the ground. The same for everyone."""

from collections.abc import Mapping
from typing import NamedTuple, TypeVar

import numpy as np

from harness import Float
from harness.motion.motion import JointLimits
from harness.robot import Robot

from .motions import (
    HELD,
    Drawn,
    GroundClearance,
    Held,
    Pace,
    draw_clear,
    draw_start,
    draw_swinging,
    first_drawn,
    smooth_motions,
)

Motions = TypeVar("Motions")
SLOW, SMOOTH, FAST, SINGULAR, CONTACT = "slow", "smooth", "fast", "singular", "contact"
CREEP = Pace(0.2, 0.1)
"""The pace of slow motions."""
SHORTEST, LONGEST = 0.3, 1.0
"""A fast joint keeps its direction so long, [s]."""
STEPS: dict[Held, list[float]] = {"whole": [-1.0, 1.0], "solids": [-1.0, 0.0, 1.0], "nothing": [-1.0, 1.0]}
"""What a fast joint chooses from: near the ground it may also stand, since some joint cannot move without touching."""
CHOICES = 32
"""Ways to go on, of which a fast motion takes the first that stays clear of the ground."""
POSES = 1_024
"""Drawn, of which the most singular one is taken."""
NEAR = 0.15
"""No joint goes farther from that pose than this, [rad]."""


class Told(NamedTuple):
    """What a class asks of the joints at most, over all its motions."""

    speed: float
    """The speed as a share of a joint's largest speed."""
    acceleration: float
    """The same of accelerations."""
    singular_value: float
    """The smallest one of the Jacobian of the tip's position, as a share of the arm's reach."""


def told_by(robot: Robot, motion: Float, period: float) -> Told:
    """What a motion, (rows, episodes, dof), asks of the joints."""
    speed, acceleration = shares_told(robot, motion, period)
    values = np.linalg.svd(robot.jacobian(motion), compute_uv=False)[..., -1]
    return Told(float(speed.max()), float(acceleration.max()), float(values.min()) / robot.reach)


def shares_told(robot: Robot, motion: Float, period: float) -> tuple[Float, Float]:
    """Speed in each control period and change of speed at its start, as shares of the joints' maxima.

    Args:
        robot: The arm.
        motion: Joint targets, (rows, episodes, dof), [rad].
        period: Control period, [s].

    Returns:
        Both (rows, episodes, dof); the first row, where nobody has moved yet, is 0.
    """
    speed = np.diff(motion, axis=0, prepend=motion[:1]) / period
    change = np.diff(speed, axis=0, prepend=speed[:1]) / period
    return np.abs(speed) / robot.max_speed, np.abs(change) / robot.max_acceleration


def class_motions(robot: Robot, seed: int, episodes: int, steps: int, period: float) -> dict[str, Drawn]:
    """The slow, the fast and the singular class, motions of (steps + 1, episodes, dof), [rad].

    Less of the arm keeps away from the ground where no motion of a class would be one otherwise, see `Held`: never
    less than in slow motions. A class that still has none is left out.

    Args:
        robot: The arm.
        seed: Of all that is drawn.
        episodes: How many motions of each, >= 1.
        steps: Control periods of each, >= 1.
        period: Control period, [s].
    """
    slow = smooth_motions(robot, seed, episodes, steps, period, CREEP)
    last = max(slow.held, "solids", key=HELD.index)

    def fast(ground: GroundClearance) -> Float | None:
        rngs = [np.random.default_rng([seed, 3, n]) for n in range(episodes)]
        drawn = np.stack([draw_fast(robot, rng, steps, period, ground) for rng in rngs], axis=1)
        return drawn if (drawn != drawn[0]).any() else None

    def singular(ground: GroundClearance) -> Float | None:
        rngs = [np.random.default_rng([seed, 4, n]) for n in range(episodes)]
        drawn = [draw_singular(robot, rng, steps, period, ground) for rng in rngs]
        found = [motion for motion in drawn if motion is not None]
        return np.stack(found, axis=1) if len(found) == episodes else None

    found = {SLOW: slow, FAST: first_drawn(robot, fast, last), SINGULAR: first_drawn(robot, singular, last)}
    return {name: drawn for name, drawn in found.items() if drawn is not None}


def draw_fast(robot: Robot, rng: np.random.Generator, steps: int, period: float, ground: GroundClearance) -> Float:
    """From rest near home as fast as the joints can: each at its largest speed, up or down, turning as fast as it can.

    All joints choose anew where to go, again and again; of the drawn choices the first is taken after which the arm can
    still stop clear of the ground. Where none is, it stops.

    Returns:
        (steps + 1, dof), [rad].
    """
    limits = JointLimits(robot.lower, robot.upper, robot.max_speed, robot.max_acceleration * period, period)
    to_stop = int(np.ceil(limits.max_speed / limits.max_change).max()) + 1
    rows, speed = [draw_start(robot, rng)], np.zeros(robot.dof)
    while len(rows) <= steps:
        count = max(1, round(rng.uniform(SHORTEST, LONGEST) / period))
        wanted = rng.choice(STEPS[ground.held], (CHOICES, robot.dof)) * robot.max_speed
        wanted[-1] = 0.0
        ways, speeds = _go_on(limits, rows[-1], speed, [*[wanted] * count, *[0.0 * wanted] * to_stop])
        clear = ground.is_clear(ways.reshape(-1, robot.dof)).reshape(ways.shape[:2]).all(axis=0)
        chosen = int(clear.argmax()) if clear.any() else CHOICES - 1
        rows += list(ways[:count, chosen])
        speed = speeds[count - 1, chosen]
    return np.array(rows[: steps + 1])


def _go_on(limits: JointLimits, qpos: Float, qvel: Float, wanted: list[Float]) -> tuple[Float, Float]:
    """Joint targets and speeds after each control period, (periods, CHOICES, dof) both, one way for each choice."""
    rows, speeds = [], []
    now, speed = np.tile(qpos, (CHOICES, 1)), np.tile(qvel, (CHOICES, 1))
    for choice in wanted:
        now, speed = limits.advance(now, speed, choice)
        rows.append(now)
        speeds.append(speed)
    return np.array(rows), np.array(speeds)


def draw_singular(
    robot: Robot, rng: np.random.Generator, steps: int, period: float, ground: GroundClearance
) -> Float | None:
    """A swing around a pose near which the tip can hardly move in some direction, as where the arm is stretched.

    Of `POSES` drawn poses that are clear of the ground it is the one whose Jacobian has the smallest singular value.

    Returns:
        (steps + 1, dof), [rad]; None where every such motion meets the ground.
    """

    def draw() -> Float:
        poses = rng.uniform(robot.lower, robot.upper, (POSES, robot.dof))
        high = ground.is_clear(poses)
        values = np.linalg.svd(robot.jacobian(poses), compute_uv=False)[:, -1]
        start = poses[np.where(high, values, np.inf).argmin()]
        return draw_swinging(robot, rng, start, steps, period, farthest=NEAR)

    return draw_clear(ground, draw)


def in_order(motions: Mapping[str, Motions]) -> dict[str, Motions]:
    """The classes in the order in which they are shown."""
    return {name: motions[name] for name in (SLOW, SMOOTH, FAST, SINGULAR, CONTACT) if name in motions}
