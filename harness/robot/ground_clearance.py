"""How low the collision shapes of a chain reach: ground contact without an engine, exact against the plane z = 0."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.robot.shapes import Shape

MARGIN = 1e-9
"""The margin of a ball around shapes, [m]: more than rounding, so that no shape reaches lower than its ball."""
AT_ONCE = 256
"""Points whose heights are computed at once: as many as fit into the processor's cache for a few hundred arms."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """The points of all meshes that one joint moves; no mesh reaches lower than its lowest point.

    Attributes:
        joint: The joint's number in the chain.
        points: In the joint's child frame, [m], shape (count, 3), count >= 1.
    """

    joint: int
    points: Float

    @cached_property
    def ball(self) -> Float:
        """Centre and radius of a ball that holds the points, shape (4,), [m]."""
        return _ball_around(self.points, np.zeros(len(self.points)))

    def lowest(self, frames: Float) -> Float:
        """Height of the lowest point, [m], shape (n,); arguments as for `Solids.lowest`."""
        up = frames[self.joint, 2]
        lowest: Float = np.full(frames.shape[-1], np.inf)
        for start in range(0, len(self.points), AT_ONCE):
            heights = _dot(self.points[start : start + AT_ONCE], up[None])
            np.minimum(lowest, heights.min(axis=0), out=lowest)
        lowest += up[3]
        return lowest

    def ball_reaches_ground(self, upward: Float) -> Mask:
        """Whether the ball does, shape (n,); arguments as for `Solids.is_near_ground`."""
        up = upward[self.joint]
        reaches: Mask = _dot(self.ball[None, :3], up[None])[0] + up[3] < self.ball[3] + MARGIN
        return reaches


@dataclass(frozen=True, eq=False)
class Solids:
    """All shapes of a chain as arrays, ready to be asked how low they reach.

    Each one is a sum of solids: half edges along its axes, a disc about its z axis, a ball. How low a sum reaches is
    the sum of how low its parts reach, which is exact.

    Attributes:
        frames: Which joint moves each shape, shape (count,).
        centers: Of the shapes, in the joint's child frame, [m], shape (count, 3).
        axes: Unit vectors x, y, z of the shapes, in the joint's child frame, shape (count, 3, 3), one per row.
        half_edges: Along these axes, [m], shape (count, 3).
        discs: Radii of the discs, [m], shape (count,).
        balls: Radii of the balls, [m], shape (count,).
        clouds: The meshes, which are none of the sums above.
    """

    frames: NDArray[np.intp]
    centers: Float
    axes: Float
    half_edges: Float
    discs: Float
    balls: Float
    clouds: tuple[Cloud, ...] = ()

    @cached_property
    def bounds(self) -> tuple[NDArray[np.intp], Float, Float]:
        """One ball around all shapes of each joint that has any: its joint, centre (count, 3) and radius (count,)."""
        radii = np.hypot(np.linalg.norm(self.half_edges, axis=1), self.discs) + self.balls
        joints = np.unique(self.frames)
        balls = [_ball_around(self.centers[self.frames == joint], radii[self.frames == joint]) for joint in joints]
        return joints, np.array([ball[:3] for ball in balls]), np.array([ball[3] for ball in balls])

    def lowest(self, frames: Float) -> Float:
        """Height of the lowest point of all shapes over the plane z = 0, negative below it.

        Args:
            frames: T_world_child of each joint as `harness.robot.kinematics.link_frames` returns them, (dof, 3, 4, n).

        Returns:
            [m], shape (n,); inf where there is no shape.
        """
        lowest = self._lowest_of_sums(frames[:, 2])
        for cloud in self.clouds:
            np.minimum(lowest, cloud.lowest(frames), out=lowest)
        return lowest

    def is_near_ground(self, upward: Float) -> Mask:
        """Whether a ball around shapes reaches below the plane z = 0, shape (n,); where none does, no shape does.

        Args:
            upward: The z axis and the height of each joint's frame, [m], shape (dof, 4, n): the third row of what
                `lowest` is given. Numbers that differ from those by rounding alone do as well.
        """
        near = self._bounds_reach_ground(upward)
        for cloud in self.clouds:
            near |= cloud.ball_reaches_ground(upward)
        return near

    def touch_ground(self, frames: Float) -> Mask:
        """Whether any shape reaches below the plane z = 0, shape (n,); arguments as for `lowest`."""
        contact, upward = np.zeros(frames.shape[-1], bool), frames[:, 2]
        near = np.flatnonzero(self._bounds_reach_ground(upward))
        if near.size:
            contact[near] = self._lowest_of_sums(upward[..., near]) < 0.0
        for cloud in self.clouds:
            near = np.flatnonzero(cloud.ball_reaches_ground(upward) & ~contact)
            if near.size:
                contact[near] = cloud.lowest(frames[..., near]) < 0.0
        return contact

    def _lowest_of_sums(self, upward: Float) -> Float:
        """The same as `lowest`, without meshes, from the last row of each frame, (dof, 4, n): z axis and height."""
        up = upward[self.frames]
        along = np.abs([_dot(self.axes[:, axis], up) for axis in range(3)])  # (3, count, n)
        depth = _dot(self.half_edges, np.moveaxis(along, 0, 1))
        depth += self.discs[:, None] * np.sqrt(np.maximum(1.0 - along[2] ** 2, 0.0)) + self.balls[:, None]
        heights = _dot(self.centers, up) + up[:, 3] - depth
        lowest: Float = np.min(heights, axis=0, initial=np.inf)
        return lowest

    def _bounds_reach_ground(self, upward: Float) -> Mask:
        joints, centers, radii = self.bounds
        if not joints.size:
            return np.zeros(upward.shape[-1], bool)
        up = upward[joints]
        reach: Mask = np.asarray((_dot(centers, up) + up[:, 3] < radii[:, None] + MARGIN).any(axis=0))
        return reach


def build_solids(shapes: Sequence[Sequence[Shape]]) -> Solids:
    """The collision shapes of an arm as arrays, for many poses at once.

    Args:
        shapes: Those that each joint moves, in the frame of its child link: `Robot.joint_shapes`, or some of them.
    """
    flat = [(frame, shape) for frame, group in enumerate(shapes) for shape in group if shape.kind != "mesh"]
    poses = np.array([shape.T_link_shape for _, shape in flat]).reshape(-1, 4, 4)
    parts = np.array([_parts(shape) for _, shape in flat]).reshape(-1, 5)
    return Solids(
        frames=np.array([frame for frame, _ in flat], dtype=np.intp),
        centers=poses[:, :3, 3],
        axes=np.swapaxes(poses[:, :3, :3], 1, 2),
        half_edges=parts[:, :3],
        discs=parts[:, 3],
        balls=parts[:, 4],
        clouds=tuple(cloud for joint, group in enumerate(shapes) for cloud in _cloud(joint, group)),
    )


def _cloud(joint: int, shapes: Sequence[Shape]) -> list[Cloud]:
    """The meshes of one joint, if it has any."""
    poses = [(shape.T_link_shape, shape.points) for shape in shapes if shape.kind == "mesh"]
    clouds = [points @ pose[:3, :3].T + pose[:3, 3] for pose, points in poses]
    return [Cloud(joint, np.concatenate(clouds))] if clouds else []


def _parts(shape: Shape) -> tuple[float, ...]:
    """Half edges along x, y and z, radius of the disc, radius of the ball, [m]."""
    if shape.kind == "box":
        return (*(edge / 2.0 for edge in shape.size), 0.0, 0.0)
    if shape.kind == "sphere":
        return (0.0, 0.0, 0.0, 0.0, shape.size[0])
    radius, length = shape.size
    disc, ball = (radius, 0.0) if shape.kind == "cylinder" else (0.0, radius)
    return (0.0, 0.0, length / 2.0, disc, ball)


def _ball_around(centers: Float, radii: Float) -> Float:
    """Centre and radius of a ball that holds the given ones, shape (4,)."""
    middle = ((centers - radii[:, None]).min(axis=0) + (centers + radii[:, None]).max(axis=0)) / 2.0
    radius: float = (np.linalg.norm(centers - middle, axis=1) + radii).max()
    return np.append(middle, radius)


def _dot(vectors: Float, others: Float) -> Float:
    """Scalar products, (count, n), of vectors (count, 3) and the first three of others (count, 3 or 4, n).

    No matrix product: its rounding would depend on n.
    """
    x, y, z = (vectors[:, axis, None] * others[:, axis] for axis in range(3))
    total: Float = x + y + z
    return total
