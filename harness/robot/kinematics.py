"""Where a serial chain's tip is, and how it moves with the joints: exact, batched, numpy only.

Frames: `world` is the root link's frame. `T_a_b` (4, 4) turns coordinates in frame b into coordinates in frame a, so
that `T_a_b @ T_b_c` is `T_a_c`. A joint has a frame that stands still in its parent link, and turns (revolute,
continuous) or slides (prismatic) its child link's frame away from it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.robot.urdf import Joint, JointKind


def rotation_between(before: Float, after: Float) -> Float:
    """The turn that leads from one orientation to another, as a rotation vector in the world frame.

    Args:
        before: Rotation matrices R_world_tip, (n, 3, 3).
        after: The same.

    Returns:
        (n, 3), [rad]; the length is the angle between the two, in [0, pi], 0 only where they are alike.
    """
    from scipy.spatial.transform import Rotation  # takes as long to import as all of the core

    turn = after @ np.swapaxes(before, -1, -2)
    vector: Float = Rotation.from_matrix(turn).as_rotvec()
    return vector


def rotation_of_axes(axes: Float) -> Float:
    """Rotation matrices whose x and y axes are given, (n, 3, 3).

    Args:
        axes: The x axis, then the y axis, in the world frame, (n, 6). Where rounding has left them not quite of length
            1 and perpendicular, the nearest of that kind is taken, the x axis first.
    """
    x = axes[:, :3] / np.linalg.norm(axes[:, :3], axis=1, keepdims=True)
    y = axes[:, 3:] - np.vecdot(x, axes[:, 3:])[:, None] * x
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], axis=2)


NOTHING = 1e-15
"""What rounding leaves of a 0 where a URDF turns a frame by 90 degrees."""


class StepTerm(NamedTuple):
    """One number of a T_previous_child: constant + a * first + cos(q) * cosine, a as in `Chain.terms`."""

    row: int
    column: int
    constant: float
    first: float
    cosine: float


@dataclass(frozen=True, eq=False)
class Chain:
    """The joints that move, in order from the root; the fixed ones are folded into the transforms between them.

    All arrays are read-only float64.

    Attributes:
        T_previous_joint: Each joint's frame in the child frame of the joint before it, the first one's in the world;
            translation in [m], shape (dof, 4, 4).
        axes: Unit vector of each joint's motion, in the joint's frame, shape (dof, 3).
        kinds: How each joint moves, dof entries, none of them fixed.
        T_last_tip: The tip link's frame in the last joint's child frame, shape (4, 4).
        T_world_mount: What the arm stands on: the frame of the link that carries the first joint, in the world, if the
            joint's axis is along its z axis; else the world itself. Shape (4, 4).
    """

    T_previous_joint: Float
    axes: Float
    kinds: tuple[JointKind, ...]
    T_last_tip: Float
    T_world_mount: Float = field(default_factory=lambda: read_only(np.eye(4)))

    @cached_property
    def dof(self) -> int:
        """Number of joints that move."""
        return len(self.kinds)

    @cached_property
    def slides(self) -> Mask:
        """Which joints are prismatic, shape (dof,)."""
        return np.equal(self.kinds, "prismatic")

    @cached_property
    def terms(self) -> tuple[Float, Float]:
        """A and B, both (dof, 4, 4), such that T_previous_child = T_previous_joint + a A + b B with two numbers a, b.

        With T = T_previous_joint: a turn by q about an axis with the cross-product matrix K is
        1 + sin(q) K + (1 - cos(q)) K K (Rodrigues), so A = T K, a = sin(q), B = T K K, b = 1 - cos(q). A slide by q is
        1 + q D, where D is zero but for the axis in its last column, so A = T D, a = q, and B = 0.
        """
        generators = np.zeros((self.dof, 4, 4))  # K or D
        generators[:, :3, :3] = np.where(self.slides[:, None, None], 0.0, _cross_product_matrices(self.axes))
        generators[:, :3, 3] = np.where(self.slides[:, None], self.axes, 0.0)
        first = self.T_previous_joint @ generators
        return read_only(first), read_only(first @ generators)  # D D = 0

    @cached_property
    def sparse_steps(self) -> tuple[tuple["StepTerm", ...], ...]:
        """Each joint's T_previous_child as those of its numbers that are not 0, dof entries."""
        first, second = self.terms
        weights = np.stack([self.T_previous_joint + second, first, -second], axis=-1)[:, :3]  # (dof, 3, 4, 3)
        weights[np.abs(weights) < NOTHING] = 0.0
        return tuple(
            tuple(
                StepTerm(int(row), int(column), *joint[row, column].tolist())
                for row, column in np.argwhere(joint.any(axis=-1))
            )
            for joint in weights
        )


def build_chain(joints: Sequence[Joint]) -> Chain:
    """The chain of `joints`, given in order from the root link to the tip link, at least one of them moving."""
    moving = [joint for joint in joints if joint.kind != "fixed"]
    steps: list[Float] = []
    T_previous_next: Float = np.eye(4)
    for joint in joints:
        T_previous_next = T_previous_next @ _constant_step(joint)
        if joint.kind != "fixed":
            steps.append(T_previous_next)
            T_previous_next = np.eye(4)
    return Chain(
        T_previous_joint=read_only(np.stack(steps)),
        axes=read_only(np.array([joint.axis for joint in moving])),
        kinds=tuple(joint.kind for joint in moving),
        T_last_tip=read_only(T_previous_next),
        T_world_mount=_mount_of(joints),
    )


def in_mount(chain: Chain) -> Chain:
    """The chain as it would be with its mount in the world's origin, upright."""
    mount = chain.T_world_mount
    T_mount_world = np.eye(4)
    T_mount_world[:3, :3], T_mount_world[:3, 3] = mount[:3, :3].T, -mount[:3, :3].T @ mount[:3, 3]
    joints = chain.T_previous_joint.copy()
    joints[0] = T_mount_world @ joints[0]
    return replace(chain, T_previous_joint=read_only(joints), T_world_mount=read_only(np.eye(4)))


UPRIGHT = 1e-3
"""The sine of the angle by which a first joint's axis may lean and is still along the mount's z axis."""


def _mount_of(joints: Sequence[Joint]) -> Float:
    """`Chain.T_world_mount` of the joints of `build_chain`."""
    T_world_parent = np.eye(4)
    for joint in joints:
        if joint.kind != "fixed":
            axis = _constant_step(joint)[:3, :3] @ joint.axis
            is_upright = np.hypot(axis[0], axis[1]) <= UPRIGHT
            # Rounded: of turns by 90 degrees no more is to be left than zeros and ones.
            return read_only(T_world_parent.round(12) if is_upright else np.eye(4))
        T_world_parent = T_world_parent @ _constant_step(joint)
    return read_only(np.eye(4))


def forward(chain: Chain, qpos: ArrayLike) -> Float:
    """T_world_tip, the tip link's pose.

    Args:
        chain: The chain, dof joints.
        qpos: Joint positions, [rad] or, for a prismatic joint, [m], shape (..., dof).

    Returns:
        Homogeneous transforms, translation in [m], shape (..., 4, 4).

    Raises:
        UsageError: The last axis of qpos is not dof long.
    """
    return child_frames(chain, qpos)[-1] @ chain.T_last_tip


def end_effector_position(chain: Chain, qpos: ArrayLike) -> Float:
    """The tip link's origin in the world frame, [m], shape (..., 3); arguments and errors as for `forward`."""
    return tip_position(chain, child_frames(chain, qpos))


def chain_length(chain: Chain, lower: Float, upper: Float) -> float:
    """No tip position is farther than this from the first joint's origin: the chain stretched out, slides too [m].

    Args:
        chain: The chain, dof joints.
        lower: Smallest joint positions, [rad] or [m], shape (dof,).
        upper: Likewise.
    """
    segments = np.vstack([chain.T_previous_joint[1:, :3, 3], chain.T_last_tip[:3, 3]])
    slides = np.where(chain.slides, np.maximum(np.abs(lower), np.abs(upper)), 0.0)
    return float(np.linalg.norm(segments, axis=-1).sum() + slides.sum())


def position_jacobian(chain: Chain, qpos: ArrayLike) -> Float:
    """How the tip link's origin moves with each joint: d position / d qpos in the world frame.

    The linear half of the geometric Jacobian: column j is axis_j x (tip - origin_j) where joint j turns, and axis_j
    where it slides.

    Args:
        chain: The chain, dof joints.
        qpos: Joint positions, [rad] or, for a prismatic joint, [m], shape (..., dof).

    Returns:
        [m/rad], for a prismatic joint [m/m], shape (..., 3, dof).

    Raises:
        UsageError: The last axis of qpos is not dof long.
    """
    return position_jacobian_of(chain, child_frames(chain, qpos))


def pose_jacobian(chain: Chain, qpos: ArrayLike) -> Float:
    """How the tip link moves and turns with each joint, in the world frame: the geometric Jacobian.

    The upper half is `position_jacobian`. Of the lower half, column j is axis_j where joint j turns, 0 where it slides.

    Args:
        chain: The chain, dof joints.
        qpos: Joint positions, [rad] or, for a prismatic joint, [m], shape (..., dof).

    Returns:
        [m/rad] above and [rad/rad] below, for a prismatic joint [m/m] and 0, shape (..., 6, dof).

    Raises:
        UsageError: The last axis of qpos is not dof long.
    """
    moves, axes = _motions_of_tip(chain, child_frames(chain, qpos))
    turns = np.where(chain.slides[:, None], 0.0, axes)
    return np.swapaxes(np.concatenate([moves, turns], axis=-1), -1, -2)


def tip_position(chain: Chain, frames: Sequence[Float]) -> Float:
    """`end_effector_position` where `child_frames` has been computed, [m], shape (..., 3)."""
    position: Float = (frames[-1] @ chain.T_last_tip)[..., :3, 3]
    return position


def position_jacobian_of(chain: Chain, frames: Sequence[Float]) -> Float:
    """`position_jacobian` where `child_frames` has been computed, shape (..., 3, dof)."""
    moves, _ = _motions_of_tip(chain, frames)
    return np.swapaxes(moves, -1, -2)


def _motions_of_tip(chain: Chain, frames: Sequence[Float]) -> tuple[Float, Float]:
    """How the tip moves per unit of each joint, and the joints' axes in the world frame: (..., dof, 3) both."""
    T_world_child = np.stack(frames, axis=-3)  # (..., dof, 4, 4)
    # A joint's own motion leaves its axis where it is, and a turning joint's origin: the child frame gives both.
    axes = (T_world_child[..., :3, :3] @ chain.axes[..., None])[..., 0]  # (..., dof, 3)
    levers = tip_position(chain, frames)[..., None, :] - T_world_child[..., :3, 3]
    return np.where(chain.slides[:, None], axes, _cross(axes, levers)), axes


def _cross(a: Float, b: Float) -> Float:
    """The cross product along the last axis; numpy's own takes several times as long for a few vectors."""
    x = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    y = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    z = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.stack([x, y, z], axis=-1)


def link_frames(chain: Chain, qpos: ArrayLike) -> Float:
    """T_world_child of each joint, without the last row, as a structure of arrays: quick for many poses.

    Each pose's numbers are, bit for bit, the same whatever the poses beside it.

    Args:
        chain: The chain, dof joints.
        qpos: Joint positions, [rad] or, for a prismatic joint, [m], shape (n, dof).

    Returns:
        Joint, row, column, pose: shape (dof, 3, 4, n), translation in [m].

    Raises:
        UsageError: The last axis of qpos is not dof long.
    """
    positions = np.ascontiguousarray(_checked(chain, qpos).T)  # (dof, n)
    first, cosine = np.sin(positions), np.cos(positions)
    first[chain.slides] = positions[chain.slides]
    frames = np.empty((chain.dof, 3, 4, positions.shape[1]))
    previous = np.eye(3, 4)[..., None]
    for joint, frame in enumerate(frames):
        _take_step(previous, chain.sparse_steps[joint], first[joint], cosine[joint], frame)
        previous = frame
    return frames


def _take_step(previous: Float, terms: Sequence[StepTerm], first: Float, cosine: Float, frame: Float) -> None:
    """Write the next child frame, `previous` times the matrix of `terms`, into `frame`, (3, 4, n)."""
    sums: list[Float | None] = [None, None, None, previous[:, 3]]
    for row, column, constant, by_first, by_cosine in terms:
        number = _weighted(by_cosine, cosine, _weighted(by_first, first, constant))
        product = previous[:, row] if isinstance(number, float) and number == 1.0 else previous[:, row] * number
        total = sums[column]
        sums[column] = product if total is None else total + product
    for column, total in enumerate(sums):
        frame[:, column] = total


def _weighted(weight: float, values: Float, start: Float | float) -> Float | float:
    """The sum of start and weight * values, (n,), without the operations that change nothing."""
    if weight == 0.0:
        return start
    product = values if weight == 1.0 else weight * values
    return product if isinstance(start, float) and start == 0.0 else start + product


def child_frames(chain: Chain, qpos: ArrayLike) -> list[Float]:
    """T_world_child of each joint, dof arrays of shape (..., 4, 4); arguments and errors as for `forward`."""
    steps = _steps(chain, qpos)
    frames = [steps[..., 0, :, :]]
    for joint in range(1, chain.dof):
        frames.append(frames[-1] @ steps[..., joint, :, :])
    return frames


def _steps(chain: Chain, qpos: ArrayLike) -> Float:
    """T_previous_child of each joint, shape (..., dof, 4, 4): from its child frame to the child frame before it."""
    positions = _checked(chain, qpos)
    first, second = chain.terms
    a = np.where(chain.slides, positions, np.sin(positions))
    b = 1.0 - np.cos(positions)  # unused where the joint slides: `second` is 0 there
    steps: Float = a[..., None, None] * first
    steps += chain.T_previous_joint  # in place: for hundreds of arms new arrays take longer than sums
    steps += b[..., None, None] * second
    return steps


def _checked(chain: Chain, qpos: ArrayLike) -> Float:
    """Joint positions as numbers, shape (..., dof)."""
    positions = np.asarray(qpos, dtype=np.float64)
    if positions.shape[-1:] != (chain.dof,):
        raise UsageError(f"qpos has shape {positions.shape}, allowed is (..., {chain.dof}). Give one value per joint.")
    return positions


def read_only(array: Float) -> Float:
    """The array itself, which nobody can write to any more."""
    array.flags.writeable = False
    return array


def _constant_step(joint: Joint) -> Float:
    """T_parent_joint, the joint's frame in its parent link's frame, shape (4, 4)."""
    return transform(joint.xyz, joint.rpy)


def transform(xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> Float:
    """T_parent_child of a URDF's <origin>.

    Args:
        xyz: The child frame's origin in the parent's frame [m].
        rpy: Its orientation: turns about the parent's fixed x, then y, then z axis [rad].

    Returns:
        Shape (4, 4), translation in [m].
    """
    T_parent_child = np.eye(4)
    T_parent_child[:3, :3] = _rotation_from_rpy(rpy)
    T_parent_child[:3, 3] = xyz
    return T_parent_child


def _rotation_from_rpy(rpy: tuple[float, float, float]) -> Float:
    """R_z(yaw) R_y(pitch) R_x(roll), shape (3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _cross_product_matrices(axes: Float) -> Float:
    """K with K v = axis x v, shape (n, 3, 3) for axes of shape (n, 3)."""
    x, y, z = axes.T
    zero = np.zeros_like(x)
    return np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), -1, 0)


DAMPING = 0.05
"""The damping of the least squares, [m]: small beside an arm's reach, large enough to pass a singular pose."""

POSE_DAMPING = 0.02
"""The same where the orientation counts too: a turn's lever is shorter."""

STRIDE = 0.15
"""The most of one step, as a share of the arm's reach: the Jacobian says nothing about far away, and arms overshoot."""


LEVER = 0.1
"""What a turn counts beside a way, [m/rad]: about as long as a hand."""


class Arm(Protocol):
    """What the search has to know; `harness.robot.robot.Robot` says what each means."""

    @property
    def chain(self) -> Chain:
        """The joints."""

    @property
    def lower(self) -> Float:
        """Smallest joint positions, (dof,)."""

    @property
    def upper(self) -> Float:
        """Largest joint positions, (dof,)."""

    @property
    def reach(self) -> float:
        """No end effector position is farther from the first joint's origin [m]."""


def reach_position(
    robot: Arm, position: Float, start: Float, tolerance: float = 1e-3, iterations: int = 60
) -> tuple[Float, Mask]:
    """Joint positions within the ranges whose end effector is at `position`, by damped least squares.

    Args:
        robot: The arm.
        position: World frame, (n, 3), [m].
        start: Where the search begins, (n, dof).
        tolerance: How close is there, [m].
        iterations: How many steps the search may take.

    Returns:
        Joint positions (n, dof), and whether each one is there, (n,). A False is no proof that none exists.
    """
    chain, qpos = robot.chain, np.array(start, dtype=np.float64)
    damping = DAMPING**2 * np.eye(3)
    for left in range(iterations, -1, -1):
        frames = child_frames(chain, qpos)
        error = position - tip_position(chain, frames)
        distance = np.linalg.norm(error, axis=-1, keepdims=True)
        if not left or (distance <= tolerance).all():
            break
        error *= np.minimum(1.0, STRIDE * robot.reach / np.maximum(distance, tolerance))
        jacobian = position_jacobian_of(chain, frames)
        transposed = np.swapaxes(jacobian, -1, -2)
        step = (transposed @ np.linalg.solve(jacobian @ transposed + damping, error[..., None]))[..., 0]
        qpos = np.minimum(np.maximum(qpos + step, robot.lower), robot.upper)
    return qpos, distance[..., 0] <= tolerance


def reach_pose(
    robot: Arm,
    position: Float,
    rotation: Float,
    start: Float,
    tolerance: float = 1e-3,
    angle_tolerance: float = 1e-2,
    iterations: int = 60,
) -> tuple[Float, Mask]:
    """The same as `reach_position`, with the orientation: a turn of 1 rad counts as much as a way of `LEVER`.

    Args:
        robot: The arm.
        position: World frame, (n, 3), [m].
        rotation: Of the end effector's link in the world frame, (n, 3, 3).
        start: Where the search begins, (n, dof).
        tolerance: How close is there, [m].
        angle_tolerance: How small an angle is there, [rad].
        iterations: How many steps the search may take.

    Returns:
        Joint positions (n, dof), and whether each one is there, (n,). A False is no proof that none exists.
    """
    qpos, weights = np.array(start, dtype=np.float64), np.repeat([1.0, LEVER], 3)
    for _ in range(iterations):
        error = _pose_error(robot, position, rotation, qpos)
        if _is_there(error, tolerance, angle_tolerance).all():
            break
        error *= weights
        size = np.linalg.norm(error, axis=-1, keepdims=True)
        error *= np.minimum(1.0, STRIDE * robot.reach / np.maximum(size, tolerance))
        jacobian = weights[:, None] * pose_jacobian(robot.chain, qpos)
        transposed = np.swapaxes(jacobian, -1, -2)
        damped = jacobian @ transposed + POSE_DAMPING**2 * np.eye(6)
        step = (transposed @ np.linalg.solve(damped, error[..., None]))[..., 0]
        qpos = np.minimum(np.maximum(qpos + step, robot.lower), robot.upper)
    return qpos, _is_there(_pose_error(robot, position, rotation, qpos), tolerance, angle_tolerance)


def _pose_error(robot: Arm, position: Float, rotation: Float, qpos: Float) -> Float:
    """Way and turn that are left, (n, 6), [m] and [rad]."""
    pose = forward(robot.chain, qpos)
    return np.concatenate([position - pose[:, :3, 3], rotation_between(pose[:, :3, :3], rotation)], axis=1)


def _is_there(error: Float, tolerance: float, angle_tolerance: float) -> Mask:
    way, turn = (np.linalg.norm(part, axis=-1) for part in (error[:, :3], error[:, 3:]))
    there: Mask = (way <= tolerance) & (turn <= angle_tolerance)
    return there
