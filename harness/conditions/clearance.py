"""How far an arm's shapes are from obstacles: exact, in batches, numpy only, the same under every simulator.

A shape and an obstacle are each a convex core and a ball around every point of it. The distance of two cores is found
by projecting back and forth, with Nesterov's momentum; each round also gives a bound from below, by the plane between
the two points, so that most pairs are decided after one.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.conditions.conditions import Conditions
from harness.conditions.obstacles import CENTER, EDGES, NUMBERS, RADIUS, distance_from, parse_obstacles, there
from harness.robot import Robot
from harness.robot.ground_clearance import build_solids
from harness.robot.kinematics import link_frames, reach_position, read_only
from harness.robot.shapes import Shape

ROUNDS = 200
"""The most projections; what is not decided by then is closer to the clearance than `EXACT`."""
EXACT = 1e-6
"""[m]."""


class Clearance:
    """The shapes that an arm's joints move, ready to be held against obstacles.

    A mesh counts as the box around its points in its own frame: it may touch a little too early, never too late.
    """

    def __init__(self, robot: Robot) -> None:
        self._chain = robot.chain
        boxed = [[_boxed(shape) for shape in group] for group in robot.joint_shapes]
        self._solids = solids = build_solids(boxed)
        self._radii = np.hypot(np.linalg.norm(solids.half_edges, axis=1), solids.discs) + solids.balls

    def touches(self, qpos: Float, obstacles: Float, clearance: float) -> Mask:
        """Whether an arm is no farther from one of its obstacles than `clearance`.

        Args:
            qpos: Joint positions, (n, dof).
            obstacles: (n, count, 7), see `harness.conditions.obstacles`.
            clearance: [m].

        Returns:
            (n,).
        """
        struck = np.zeros(len(qpos), bool)
        pairs = self._pairs(qpos, obstacles, clearance)
        if pairs.pose.size:
            struck[pairs.pose[pairs.distance(clearance) <= clearance]] = True
        return struck

    def distance(self, qpos: Float, obstacles: Float) -> Float:
        """From an arm to the nearest of its obstacles, [m], (n,); arguments as for `touches`.

        Where a box or a cylinder is inside a box it is 0; inf where there is no obstacle.
        """
        pairs = self._pairs(qpos, obstacles, np.inf)
        nearest: Float = np.full(len(qpos), np.inf)
        np.minimum.at(nearest, pairs.pose, pairs.distance(None))
        return nearest

    def touches_ground(self, qpos: Float) -> Mask:
        """Whether a shape reaches below z = 0, (n,)."""
        return self._solids.touch_ground(link_frames(self._chain, qpos))

    def _pairs(self, qpos: Float, obstacles: Float, clearance: float) -> "_Pairs":
        """Those of a shape and an obstacle that may be within the clearance, by balls around the shapes."""
        solids = self._solids
        frames = link_frames(self._chain, qpos)[solids.frames]  # (shapes, 3, 4, n)
        centers = _turned(frames, solids.centers[..., None]) + frames[:, :, 3]  # (shapes, 3, n)
        gaps = distance_from(np.moveaxis(centers, 1, 2)[:, :, None], obstacles) - self._radii[:, None, None]
        near = (gaps <= clearance) & there(obstacles)
        shape, pose, obstacle = np.nonzero(near)
        turns = frames[shape, :, :, pose]  # (pairs, 3, 4)
        axes = np.stack([_turned(turns, solids.axes[shape, axis]) for axis in range(3)], axis=1)
        return _Pairs(
            pose,
            centers[shape, :, pose],
            axes,
            solids.half_edges[shape],
            solids.discs[shape],
            solids.balls[shape],
            obstacles[pose, obstacle],
        )


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Shapes and obstacles, one of each, (count, ...).

    Attributes:
        pose: Number of the pose that the shape is in.
        center: Of the shape, world frame, (count, 3), [m].
        axes: Its unit vectors, world frame, one per row, (count, 3, 3).
        half_edges: Along these axes, (count, 3), [m].
        disc: Radius about the third of them, (count,).
        ball: Radius, (count,).
        obstacle: (count, 7).
    """

    pose: NDArray[np.intp]
    center: Float
    axes: Float
    half_edges: Float
    disc: Float
    ball: Float
    obstacle: Float

    def distance(self, clearance: float | None) -> Float:
        """Between shape and obstacle, [m], (count,): never too small; beyond `clearance`, if given, too large."""
        radii = self.ball + self.obstacle[:, RADIUS]
        found = np.full(len(self.pose), np.inf)
        left = np.arange(len(self.pose))
        point = before = np.zeros_like(self.center)  # in the shape's frame
        momentum = 1.0
        for _ in range(ROUNDS):
            if not left.size:
                break
            part = self._take(left)
            nearest, distance, least = part._project(point)
            found[left] = np.minimum(found[left], distance)
            reach = 0.0 if clearance is None else clearance + radii[left]
            decided = distance - least <= EXACT
            if clearance is not None:
                decided |= (distance <= reach) | (least > reach)
            faster = (1.0 + np.sqrt(1.0 + 4.0 * momentum**2)) / 2.0
            ahead = nearest + (momentum - 1.0) / faster * (nearest - before)
            left, point, before, momentum = left[~decided], ahead[~decided], nearest[~decided], faster
        return found - radii

    def _project(self, point: Float) -> tuple[Float, Float, Float]:
        """One round: the next point of each shape's core, its distance from the obstacle's core, and a lower bound."""
        low, high = (self.obstacle[:, CENTER] + side * self.obstacle[:, EDGES] for side in (-1.0, 1.0))
        other = np.minimum(np.maximum(self._in_world(point), low), high)
        nearest = self._into_core(_inner(self.axes, (other - self.center)[:, None]))
        world = self._in_world(nearest)
        other = np.minimum(np.maximum(world, low), high)
        between = world - other
        distance = np.sqrt(_inner(between, between))
        toward = between / np.where(distance > 0.0, distance, 1.0)[:, None]
        along = _inner(self.axes, toward[:, None])
        depth = _inner(self.half_edges, np.abs(along))
        depth += self.disc * np.sqrt(np.maximum(1.0 - along[:, 2] ** 2, 0.0))
        middles = _inner(toward, self.center - self.obstacle[:, CENTER])
        least = middles - depth - _inner(np.abs(toward), self.obstacle[:, EDGES])
        return nearest, distance, least

    def _into_core(self, point: Float) -> Float:
        """The nearest points of the cores, in their frames, (count, 3)."""
        inside = np.minimum(np.maximum(point, -self.half_edges), self.half_edges)
        out = np.hypot(point[:, 0], point[:, 1])
        share = np.minimum(1.0, self.disc / np.where(out > 0.0, out, 1.0))
        round_ = self.disc > 0.0
        inside[round_, :2] = point[round_, :2] * share[round_, None]
        return inside

    def _in_world(self, point: Float) -> Float:
        x, y, z = (point[:, axis, None] * self.axes[:, axis] for axis in range(3))
        return self.center + (x + y + z)

    def _take(self, rows: NDArray[np.intp]) -> "_Pairs":
        if len(rows) == len(self.pose):
            return self
        return _Pairs(
            self.pose[rows],
            self.center[rows],
            self.axes[rows],
            self.half_edges[rows],
            self.disc[rows],
            self.ball[rows],
            self.obstacle[rows],
        )


def _boxed(shape: Shape) -> Shape:
    """A mesh as the box around its points; another shape as it is."""
    if shape.kind != "mesh":
        return shape
    low, high = shape.points.min(axis=0), shape.points.max(axis=0)
    moved = shape.T_link_shape.copy()
    moved[:3, 3] += moved[:3, :3] @ ((low + high) / 2.0)
    edges = np.maximum(high - low, 1e-9)
    return replace(
        shape, kind="box", size=tuple(edges.tolist()), T_link_shape=read_only(moved), points=shape.points[:0]
    )


def _turned(frames: Float, vectors: Float) -> Float:
    """R v for frames (count, 3, 4, ...) and vectors (count, 3, ...). No matrix product: its rounding depends on n."""
    x, y, z = (frames[:, :, axis] * vectors[:, axis, None] for axis in range(3))
    turned: Float = x + y + z
    return turned


def _inner(a: Float, b: Float) -> Float:
    """Scalar products along the last axis of 3, rounded the same whatever the batch."""
    product = a * b
    total: Float = product[..., 0] + product[..., 1] + product[..., 2]
    return total


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
