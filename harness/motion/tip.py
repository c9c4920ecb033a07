"""Motions of the end effector, NOTE Table II: along straight lines and arcs, and the joints that follow them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, ClassVar, Literal, NamedTuple, TypeAlias

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass as checked_dataclass

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.motion.motion import JointLimits, Move, Setting, stopping_speed
from harness.robot import Robot
from harness.robot.kinematics import child_frames, forward, position_jacobian_of, tip_position

Way: TypeAlias = Callable[[Float], Float]
"""Where the end effector is, from its start, (n, 3), world frame [m], when the shares (n, 1) of a way are gone."""

SLIGHT, STRONG = 1e-3, 0.01
"""Damping of the least squares, [m]: hardly any, to see how hard a direction is; enough to come near in few steps."""

ITERATIONS = 6
"""At most, of damped least squares per piece of a way; two are usual."""

ON_THE_WAY = 1e-7
"""An end effector this close to where it should be is there, [m]."""

REFINEMENTS = 2
"""How often the share of a piece is refined that joints at their limits do."""

MISSED = 0.1
"""A point that they miss by more than this share of the way to it cannot be reached."""

SLOWEST = 0.02
"""Slower than this share of its speed no way gets at singular poses: where that is still too far, it cannot be done."""

STUCK = 1e-3
"""Where the joints' ranges leave less than this share of a way it cannot be done."""

STILL = 1e-4
"""A joint that moves less than this, in units of the one that moves most, sets no pace."""


@dataclass(frozen=True, eq=False)
class Follower:
    """Moves joints so that the end effector passes along a way.

    The joints keep the ratio of their speeds when one of them is at a limit, so that the end effector slows down and
    stays on its way. It slows down near singular poses too: they are where the arm's reach ends. Where a point cannot
    be reached, or a joint's range is in the way, the arm is held: it brakes and stands.

    Attributes:
        robot: The arm.
        limits: Of a period in which one piece of a way is gone.
        tip_speed: Of the end effector, the largest [m/s].
    """

    robot: Robot
    limits: JointLimits
    tip_speed: float
    _stiff: float = field(init=False)
    """With less end effector motion per joint motion than this, [m/rad], the way is slowed down."""

    def __post_init__(self) -> None:
        # An elbow that stretches to reach L needs the acceleration v^2 L / (4 g^3) at tip speed v and g metres per
        # radian. Here it is to be an eighth of what the joints have: they do other things too, and have to brake.
        turning = ~self.robot.chain.slides
        acceleration = self.limits.max_change[turning].min(initial=np.inf) / self.limits.period
        stiff = (2.0 * self.tip_speed**2 * self.robot.reach / acceleration) ** (1.0 / 3.0)
        object.__setattr__(self, "_stiff", stiff)

    def pass_along(self, qpos: Float, qvel: Float, way: Way, parts: int) -> Move:
        """The move along `way`, in so many equal parts; less of it where the limits ask for that."""
        waypoints = []
        gone, held = np.zeros((len(qpos), 1)), np.zeros(len(qpos), bool)
        for _ in range(parts):
            qpos, qvel, share, stopped = self._approach(qpos, qvel, partial(_section, way, gone, parts))
            gone = gone + share / parts
            waypoints.append(qpos)
            held |= stopped
        return Move(waypoints, qvel, held)

    def turning_speed(self, qpos: Float, u: Float, v: Float, radius: Float) -> Float:
        """Speeds, (n, 1) [m/s], at which half the joints' acceleration keeps the end effector on a circle.

        Args:
            qpos: (n, dof), [rad].
            u: One direction in the circle's plane, unit length, (n, 3).
            v: The other one.
            radius: (n, 1), [m].
        """
        jacobian = self.robot.jacobian(qpos)
        joints = np.hypot(_least_squares(jacobian, u, STRONG), _least_squares(jacobian, v, STRONG))
        acceleration = self.limits.max_change / self.limits.period
        return np.sqrt(0.5 * radius * _smallest(acceleration, joints))

    def _approach(self, qpos: Float, qvel: Float, way: Way) -> tuple[Float, Float, Float, Mask]:
        """Joint targets and speeds for one part of a way, what share of it is done, and where it cannot be done."""
        limits = self.limits
        low, high = limits.bounds(qpos, qvel)
        frames = child_frames(self.robot.chain, qpos)
        jacobian = position_jacobian_of(self.robot.chain, frames)
        goal = way(np.ones((len(qpos), 1)))
        whole, free = self._whole(qpos, jacobian, goal)
        room = _smallest(self._room(qpos, whole), whole)
        ease = self._ease(jacobian, whole)
        later = _least_squares(self.robot.jacobian(qpos + ease * whole) * free[:, None], goal, SLIGHT)
        share = self._share(whole, room, np.minimum(ease, self._bend(ease, whole, later)), low, high)
        part = _Part(qpos, tip_position(self.robot.chain, frames), way, free, low, high)
        share, movement, unreachable = self._fit(part, share, whole)
        held = unreachable | (room[:, 0] < STUCK)
        share = np.where(held[:, None] | ~whole.any(axis=-1, keepdims=True), 0.0, share)
        speed = np.where(share > 0.0, movement / limits.period, self._braked(qvel))
        speed = np.minimum(np.maximum(speed, low), high)
        target = np.minimum(np.maximum(qpos + speed * limits.period, limits.lower), limits.upper)
        return target, speed, share, held

    def _whole(self, qpos: Float, jacobian: Float, way: Float) -> tuple[Float, Mask]:
        """The joint movement for `way`, (n, dof), by joints that do not stand at an end that they would pass; those."""
        free = np.ones(qpos.shape, bool)
        for _ in range(self.robot.dof):
            whole = _least_squares(jacobian * free[:, None], way, SLIGHT)
            stand = free & (self._room(qpos, whole) < STUCK * np.abs(whole))
            if not stand.any():
                break
            free &= ~stand
        return whole, free

    def _fit(self, part: "_Part", share: Float, whole: Float) -> tuple[Float, Float, Mask]:
        """The share of a part that the limits allow, its joint movement, and where there is none."""
        movement, unreachable = self._solve(part, share * whole, share)
        for _ in range(REFINEMENTS):
            # The joints turn as they go: one that was to have its largest speed may need more.
            ahead = np.where(movement > 0.0, part.high, -part.low) * self.limits.period
            fitting = np.minimum(1.0, np.maximum(_smallest(ahead, movement), 0.0))
            tight = fitting < 1.0
            if not tight.any():
                break
            share = fitting * share
            other, missed = self._solve(part, fitting * movement, share)
            movement, unreachable = np.where(tight, other, movement), np.where(tight[:, 0], missed, unreachable)
        return share, movement, unreachable

    def _room(self, qpos: Float, whole: Float) -> Float:
        """From each joint to the end of its range that it moves to, (n, dof)."""
        return np.abs(np.where(whole > 0.0, self.limits.upper, self.limits.lower) - qpos)

    def _ease(self, jacobian: Float, whole: Float) -> Float:
        """The share of a joint movement that is not too fast this close to a singular pose, (n, 1)."""
        moved = np.linalg.norm((jacobian @ whole[..., None])[..., 0], axis=-1, keepdims=True)
        turned = np.linalg.norm(whole, axis=-1, keepdims=True)
        stiffness = self._stiff * turned
        share: Float = np.divide(moved, stiffness, out=np.ones_like(moved), where=moved < stiffness) ** 2
        return np.maximum(share, SLOWEST)

    def _bend(self, share: Float, whole: Float, later: Float) -> Float:
        """The share of a joint movement with half the acceleration for its turn to `later`, after `share`: (n, 1)."""
        turn = (later - whole) / share
        bend: Float = np.sqrt(0.5 * _smallest(self.limits.max_change * self.limits.period, turn))
        return bend

    def _share(self, whole: Float, room: Float, ease: Float, low: Float, high: Float) -> Float:
        """The share of a joint movement to do, (n, 1): at most `ease`, and so that all joints stop together.

        More than that where the joints cannot slow down as fast; 0 where they cannot keep the ratio of their speeds.
        """
        limits, forward = self.limits, whole > 0.0
        # With half the braking there is: the ratio of the joints' speeds changes on the way to the end.
        braking = 0.5 * limits.max_change * limits.period
        stopping = stopping_speed(room, _smallest(braking, whole), 1.0)
        most = _smallest(np.where(forward, high, -low) * limits.period, whole)
        least = -_smallest(np.where(forward, -low, high) * limits.period, whole)
        share = np.minimum(np.minimum(ease, stopping), most)
        return np.where(least <= most, np.maximum(np.maximum(share, least), 0.0), 0.0)

    def _solve(self, part: "_Part", guess: Float, share: Float) -> tuple[Float, Mask]:
        """The joint movement, near `guess`, for a share of a part, (n, dof); and where there is none."""
        chain, qpos, way = self.robot.chain, part.qpos + guess, part.way(share)
        point = part.start + way
        for _ in range(ITERATIONS):
            frames = child_frames(chain, qpos)
            error = point - tip_position(chain, frames)
            # Each arm on its own: what it does must not depend on the arms beside it.
            wrong = np.linalg.norm(error, axis=-1) > ON_THE_WAY
            if not wrong.any():
                return qpos - part.qpos, wrong
            step = _least_squares(position_jacobian_of(chain, frames) * part.free[:, None], error, STRONG)
            qpos = np.where(wrong[:, None], qpos + step, qpos)
        missed = np.linalg.norm(point - self.robot.end_effector(qpos), axis=-1)
        return qpos - part.qpos, missed > MISSED * np.linalg.norm(way, axis=-1) + ON_THE_WAY

    def _braked(self, qvel: Float) -> Float:
        """Speeds after braking in their ratio, which keeps the end effector on its way."""
        share: Float = 1.0 - np.minimum(1.0, _smallest(self.limits.max_change, qvel))
        return share * qvel


def _section(way: Way, gone: Float, parts: int, share: Float) -> Float:
    """The way from where it is `gone` to, on to a share of one of its parts, (n, 3) [m]."""
    return way(gone + share / parts) - way(gone)


class _Part(NamedTuple):
    """One part of a way, from joint positions `qpos`, with what the joints can do in it, (n, dof) each.

    `start` is where the end effector is then, (n, 3), [m].
    """

    qpos: Float
    start: Float
    way: Way
    free: Mask
    low: Float
    high: Float


def _least_squares(jacobian: Float, error: Float, damping: float) -> Float:
    """Joint movements, (n, dof), that move the end effector by `error`, (n, 3) [m], damped by `damping` [m]."""
    transposed = np.swapaxes(jacobian, -1, -2)
    damped = jacobian @ transposed + damping**2 * np.eye(3)
    movement: Float = (transposed @ np.linalg.solve(damped, error[..., None]))[..., 0]
    return movement


def _smallest(limit: Float, movement: Float) -> Float:
    """The smallest of `limit`, (dof,) or (n, dof), in units of `movement`, (n, dof): (n, 1); what stands has none."""
    size = np.abs(movement)
    moves = size > STILL * size.max(axis=-1, keepdims=True)
    quotients = np.divide(np.broadcast_to(limit, size.shape), size, out=np.full_like(size, HUGE), where=moves)
    smallest: Float = quotients.min(axis=-1, keepdims=True)
    return smallest


HUGE = 1e9
"""A number that is as good as no limit, and whose square is a number."""


Metres3 = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0)]


TIP_SPEED = 0.5
"""The tip speed of the FD100 where nothing else is said, [m/s]."""


@checked_dataclass(frozen=True)
class CartesianMode:
    """What `movel` and `movea` have in common."""

    frame: Annotated[
        Literal["wcs", "ucs", "tcs"],
        Field(description="axes of the action: the world's (wcs), the user's (ucs), or the tool's at each step (tcs)"),
    ] = "wcs"
    tip_speed: Annotated[
        Positive | None,
        Field(
            description="speed of the end effector under a full action [m/s]; None: of the FD100 0.5, scaled by reach"
        ),
    ] = None
    parts: Annotated[int, Field(gt=0, description="pieces into which the path of a control period is cut")] = 4
    ucs_origin: Annotated[Metres3, Field(description="origin of the user's frame, world frame [m]")] = (
        0.0,
        0.0,
        0.0,
    )
    ucs_x: Annotated[Metres3, Field(description="a point on the user's +x axis, world frame [m]")] = (
        1.0,
        0.0,
        0.0,
    )
    ucs_xy: Annotated[
        Metres3, Field(description="a point in the first quadrant of the user's xy plane, world frame [m]")
    ] = (
        0.0,
        1.0,
        0.0,
    )

    def speed(self, robot: Robot) -> float:
        """The tip speed for an arm, [m/s]."""
        return robot.scaled(TIP_SPEED) if self.tip_speed is None else self.tip_speed

    def axes(self, robot: Robot) -> "Axes":
        """The axes of `frame`.

        Raises:
            UsageError: The user's three points lie on one line.
        """
        if self.frame == "tcs":
            return ToolAxes(robot)
        return FixedAxes(np.eye(3) if self.frame == "wcs" else self._user_axes())

    def _user_axes(self) -> Float:
        """The user's axes as columns, (3, 3)."""
        origin = np.array(self.ucs_origin)
        x, towards_y = np.array(self.ucs_x) - origin, np.array(self.ucs_xy) - origin
        z = np.cross(x, towards_y)
        if np.linalg.norm(z) < 1e-9:
            raise UsageError(
                f"ucs_origin={self.ucs_origin}, ucs_x={self.ucs_x} and ucs_xy={self.ucs_xy} lie on one line: "
                "give three points that span a plane"
            )
        return np.stack([x / np.linalg.norm(x), _unit(np.cross(z, x)), _unit(z)], axis=1)


@dataclass(frozen=True, eq=False)
class FixedAxes:
    """Axes that stand still, (3, 3), a column each."""

    columns: Float

    def to_world(self, qpos: Float, vectors: Float) -> Float:
        """Vectors, (num_envs, count, 3), turned into the world frame."""
        turned: Float = vectors @ self.columns.T
        return turned


@dataclass(frozen=True, eq=False)
class ToolAxes:
    """The end effector link's axes at joint positions `qpos`."""

    robot: Robot

    def to_world(self, qpos: Float, vectors: Float) -> Float:
        """Vectors, (num_envs, count, 3), turned into the world frame."""
        turned: Float = vectors @ np.swapaxes(forward(self.robot.chain, qpos)[:, :3, :3], -1, -2)
        return turned


Axes = FixedAxes | ToolAxes


def _unit(vector: Float) -> Float:
    unit: Float = vector / np.linalg.norm(vector)
    return unit


@checked_dataclass(frozen=True)
class MoveLMode(CartesianMode):
    """MoveL: the end effector moves on a straight line; the action is its velocity as a fraction of tip_speed.

    An action that is longer than 1 is one of length 1. The orientation of the end effector is free.
    """

    def motion(self, setting: Setting) -> "MoveL":
        """The motion of one arm."""
        follower = Follower(setting.robot, setting.limits(self.parts), self.speed(setting.robot))
        return MoveL(follower, self.axes(setting.robot), follower.tip_speed * setting.period, self.parts)


@dataclass(frozen=True, eq=False)
class MoveL:
    """See `MoveLMode`.

    Attributes:
        follower: Keeps the end effector on the line.
        axes: Of the action.
        length: Of the line under a full action, [m].
        parts: Points on it.
    """

    follower: Follower
    axes: Axes
    length: float
    parts: int
    action_size: ClassVar[int] = 3
    jumps: ClassVar[bool] = False

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        clipped = np.minimum(np.maximum(action, -1.0), 1.0)
        fraction = clipped / np.maximum(1.0, np.linalg.norm(clipped, axis=-1, keepdims=True))
        way = self.axes.to_world(qpos, self.length * fraction[:, None])[:, 0]
        return self.follower.pass_along(qpos, qvel, lambda gone: gone * way, self.parts)

    def stay(self, qpos: Float) -> Float:
        """No velocity."""
        return np.zeros((len(qpos), 3))

    def increments(self) -> Float:
        """Full speed along each axis."""
        return np.eye(3)


STRAIGHT = 1e-6
"""Three points whose triangle's area is below this share of its sides' product lie on a line."""


@dataclass(frozen=True, eq=False)
class Arc:
    """Ways from the origin along circles, or straight, for n arms at once.

    Attributes:
        forward: Unit vector in which a way begins; 0 where it is none, (n, 3).
        inward: Unit vector from the origin to the circle's centre; 0 where the way is straight, (n, 3).
        radius: (n, 1), [m]; 1 where the way is straight.
        length: Of the way, (n, 1), [m].
    """

    forward: Float
    inward: Float
    radius: Float
    length: Float

    def point(self, distance: Float) -> Float:
        """Where the ways are after `distance`, (n, 1) [m]: (n, 3), [m]."""
        angle = distance / self.radius
        straight = ~self.inward.any(axis=-1, keepdims=True)
        along = np.where(straight, distance, self.radius * np.sin(angle))
        # 1 - cos, exact also where the angle is small.
        point: Float = along * self.forward + 2.0 * self.radius * np.sin(0.5 * angle) ** 2 * self.inward
        return point


def arc_through(via: Float, end: Float) -> Arc:
    """The arcs from the origin through `via` to `end`, (n, 3) both, [m].

    Where the three lie on one line, or two of them coincide, the way is the straight line to `end`.
    """
    normal = np.cross(via, end)  # as long as the triangle's area, twice
    area, via_length, end_length = (np.linalg.norm(vector, axis=-1, keepdims=True) for vector in (normal, via, end))
    straight = area <= STRAIGHT * via_length * end_length
    area = np.where(straight, 1.0, area)
    center = np.cross(via_length**2 * end - end_length**2 * via, normal) / (2.0 * area**2)
    radius = np.where(straight, 1.0, np.linalg.norm(center, axis=-1, keepdims=True))
    inward = np.where(straight, 0.0, center / radius)
    line = end / np.where(end_length > 0.0, end_length, 1.0)
    forward = np.where(straight, line, np.cross(inward, normal / area))
    angle = np.arctan2(_dot(end, forward), radius - _dot(end, inward)) % (2.0 * np.pi)
    return Arc(forward, inward, radius, np.where(straight, end_length, radius * angle))


def _dot(first: Float, second: Float) -> Float:
    dot: Float = np.vecdot(first, second)[..., None]
    return dot


@checked_dataclass(frozen=True)
class MoveAMode(CartesianMode):
    """MoveA: the end effector moves on an arc through a via point; the action is the via point and the end point.

    Both are given from where the end effector is, as fractions of the way that it does at tip_speed; an arc that is
    longer is gone only so far, and a tight one slowly. Three points on one line make a straight line. The orientation
    of the end effector is free.
    """

    def motion(self, setting: Setting) -> "MoveA":
        """The motion of one arm."""
        follower = Follower(setting.robot, setting.limits(self.parts), self.speed(setting.robot))
        return MoveA(follower, self.axes(setting.robot), setting.period, self.parts)


@dataclass(frozen=True, eq=False)
class MoveA:
    """See `MoveAMode`.

    Attributes:
        follower: Keeps the end effector on the arc.
        axes: Of the action.
        period: Control period, [s].
        parts: Pieces of the way within it.
    """

    follower: Follower
    axes: Axes
    period: float
    parts: int
    action_size: ClassVar[int] = 6
    jumps: ClassVar[bool] = False

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        follower = self.follower
        clipped = np.minimum(np.maximum(action, -1.0), 1.0).reshape(-1, 2, 3)
        points = self.axes.to_world(qpos, follower.tip_speed * self.period * clipped)
        arc = arc_through(points[:, 0], points[:, 1])
        turning = follower.turning_speed(qpos, arc.forward, arc.inward, arc.radius)
        length = np.minimum(arc.length, self.period * np.minimum(turning, follower.tip_speed))
        return follower.pass_along(qpos, qvel, lambda gone: arc.point(gone * length), self.parts)

    def stay(self, qpos: Float) -> Float:
        """Via and end point where the end effector is."""
        return np.zeros((len(qpos), 6))

    def increments(self) -> Float:
        """Along each axis, with a bulge of a quarter towards the next one."""
        ends = np.eye(3)
        return np.concatenate([0.5 * ends + 0.25 * np.roll(ends, 1, axis=1), ends], axis=1)
