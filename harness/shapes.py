"""The collision shapes of a URDF, and how low they reach: ground contact without an engine.

Only shapes with an exact lowest point are read; meshes are skipped. Reference: http://wiki.ros.org/urdf/XML/link
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, cast
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from harness.errors import UsageError
from harness.kinematics import transform

Array = NDArray[np.float64]
ShapeKind = Literal["box", "cylinder", "capsule", "sphere"]
Vector = tuple[float, float, float]

SIZES: Mapping[ShapeKind, tuple[tuple[str, int], ...]] = {
    "box": (("size", 3),),
    "cylinder": (("radius", 1), ("length", 1)),
    "capsule": (("radius", 1), ("length", 1)),
    "sphere": (("radius", 1),),
}
"""The attributes of each kind of shape, and how many numbers each one has."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One solid.

    Attributes:
        kind: Which.
        size: Of a box its edges along x, y and z; of a sphere its radius; of a cylinder or capsule its radius and its
            length along z, a capsule's without its half spheres; all positive [m].
        T_link_shape: The shape's frame, at its centre, in the link's frame, shape (4, 4), translation in [m].
    """

    kind: ShapeKind
    size: tuple[float, ...]
    T_link_shape: Array


def read_shapes(urdf: str) -> dict[str, tuple[Shape, ...]]:
    """The collision shapes of each link, by the link's name; a link without any has an empty tuple.

    Args:
        urdf: Text of a URDF that `harness.urdf.read_chain` accepts.

    Raises:
        UsageError: A collision shape cannot be computed with; the message names its link.
    """
    return {link.get("name", ""): _shapes_of_link(link) for link in ElementTree.fromstring(urdf).findall("link")}


def attach_shapes(urdf: str, joint_names: Sequence[str]) -> tuple[tuple[Shape, ...], ...]:
    """The shapes that move with each joint of a chain, those of links fixed to the joint's child link included.

    What no joint moves is left out, and what a joint beside the chain moves.

    Args:
        urdf: Text of a URDF that `harness.urdf.read_chain` accepts.
        joint_names: The joints of the chain that move, dof of them.

    Returns:
        One tuple per joint, dof entries; `T_link_shape` is in the frame of the joint's child link.

    Raises:
        UsageError: A collision shape or the origin of a fixed joint cannot be computed with.
    """
    carriers = {_carried(joint): joint for joint in ElementTree.fromstring(urdf).findall("joint")}
    attached: dict[str, list[Shape]] = {name: [] for name in joint_names}
    for link, shapes in read_shapes(urdf).items():
        joint, T_child_link = _moving_carrier(link, carriers)
        if joint in attached:
            attached[joint] += [replace(shape, T_link_shape=T_child_link @ shape.T_link_shape) for shape in shapes]
    return tuple(tuple(shapes) for shapes in attached.values())


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
    """

    frames: NDArray[np.intp]
    centers: Array
    axes: Array
    half_edges: Array
    discs: Array
    balls: Array

    @cached_property
    def bounds(self) -> tuple[NDArray[np.intp], Array, Array]:
        """One ball around all shapes of each joint that has any: its joint, centre (count, 3) and radius (count,)."""
        radii = np.hypot(np.linalg.norm(self.half_edges, axis=1), self.discs) + self.balls
        joints = np.unique(self.frames)
        balls = [_ball_around(self.centers[self.frames == joint], radii[self.frames == joint]) for joint in joints]
        return joints, np.array([ball[:3] for ball in balls]), np.array([ball[3] for ball in balls])

    def lowest(self, frames: Array) -> Array:
        """Height of the lowest point of all shapes over the plane z = 0, negative below it.

        Args:
            frames: T_world_child of each joint as `harness.kinematics.link_frames` returns them, (dof, 3, 4, n).

        Returns:
            [m], shape (n,); inf where there is no shape.
        """
        up = frames[self.frames, 2]  # (count, 4, n): the world's z axis in the child frame, and the frame's height
        along = np.abs([_dot(self.axes[:, axis], up) for axis in range(3)])  # (3, count, n)
        depth = _dot(self.half_edges, np.moveaxis(along, 0, 1))
        depth += self.discs[:, None] * np.sqrt(np.maximum(1.0 - along[2] ** 2, 0.0)) + self.balls[:, None]
        heights = _dot(self.centers, up) + up[:, 3] - depth
        lowest: Array = np.min(heights, axis=0, initial=np.inf)
        return lowest

    def touch_ground(self, frames: Array) -> NDArray[np.bool_]:
        """Whether any shape reaches below the plane z = 0, shape (n,); arguments as for `lowest`."""
        contact = np.zeros(frames.shape[-1], bool)
        near = np.flatnonzero(self._bounds_reach_ground(frames))
        if near.size:
            contact[near] = self.lowest(frames[..., near]) < 0.0
        return contact

    def _bounds_reach_ground(self, frames: Array) -> NDArray[np.bool_]:
        joints, centers, radii = self.bounds
        if not joints.size:
            return np.zeros(frames.shape[-1], bool)
        up = frames[joints, 2]
        # The margin is more than rounding: no shape reaches lower than its ball.
        reach: NDArray[np.bool_] = (_dot(centers, up) + up[:, 3] < radii[:, None] + 1e-9).any(axis=0)
        return reach


def build_solids(shapes: Sequence[Sequence[Shape]]) -> Solids:
    """The shapes that `attach_shapes` returned, as arrays."""
    flat = [(frame, shape) for frame, group in enumerate(shapes) for shape in group]
    poses = np.array([shape.T_link_shape for _, shape in flat]).reshape(-1, 4, 4)
    parts = np.array([_parts(shape) for _, shape in flat]).reshape(-1, 5)
    return Solids(
        frames=np.array([frame for frame, _ in flat], dtype=np.intp),
        centers=poses[:, :3, 3],
        axes=np.swapaxes(poses[:, :3, :3], 1, 2),
        half_edges=parts[:, :3],
        discs=parts[:, 3],
        balls=parts[:, 4],
    )


def _parts(shape: Shape) -> tuple[float, ...]:
    """Half edges along x, y and z, radius of the disc, radius of the ball, [m]."""
    if shape.kind == "box":
        return (*(edge / 2.0 for edge in shape.size), 0.0, 0.0)
    if shape.kind == "sphere":
        return (0.0, 0.0, 0.0, 0.0, shape.size[0])
    radius, length = shape.size
    disc, ball = (radius, 0.0) if shape.kind == "cylinder" else (0.0, radius)
    return (0.0, 0.0, length / 2.0, disc, ball)


def _ball_around(centers: Array, radii: Array) -> Array:
    """Centre and radius of a ball that holds the given ones, shape (4,)."""
    middle = ((centers - radii[:, None]).min(axis=0) + (centers + radii[:, None]).max(axis=0)) / 2.0
    radius: float = (np.linalg.norm(centers - middle, axis=1) + radii).max()
    return np.append(middle, radius)


def _dot(vectors: Array, others: Array) -> Array:
    """Scalar products, (count, n), of vectors (count, 3) and the first three of others (count, 3 or 4, n).

    No matrix product: its rounding would depend on n.
    """
    x, y, z = (vectors[:, axis, None] * others[:, axis] for axis in range(3))
    total: Array = x + y + z
    return total


def _moving_carrier(link: str, carriers: Mapping[str, Element]) -> tuple[str | None, Array]:
    """The joint that moves `link`, None where none does, and T_child_link from the joint's child link."""
    T_child_link: Array = np.eye(4)
    while link in carriers:
        joint = carriers[link]
        if joint.get("type") != "fixed":
            return joint.get("name"), T_child_link
        T_child_link = _origin(joint, f"Joint '{joint.get('name')}'") @ T_child_link
        link = _link_of(joint, "parent")
    return None, T_child_link


def _carried(joint: Element) -> str:
    return _link_of(joint, "child")


def _link_of(joint: Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _shapes_of_link(link: Element) -> tuple[Shape, ...]:
    owner = f"Link '{link.get('name')}'"
    shapes = [_read_shape(collision, owner) for collision in link.findall("collision")]
    return tuple(shape for shape in shapes if shape is not None)


def _read_shape(collision: Element, owner: str) -> Shape | None:
    """None where it is a mesh."""
    geometry = collision.find("geometry")
    if geometry is None or len(geometry) != 1:
        raise UsageError(f"{owner} has a collision without one shape in its <geometry>. Give it one.")
    shape = geometry[0]
    if shape.tag == "mesh":
        return None
    if shape.tag not in SIZES:
        raise UsageError(f"{owner} has a collision <{shape.tag}>; allowed: {', '.join(SIZES)}, mesh. Change it.")
    kind = cast(ShapeKind, shape.tag)
    numbers = [number for name, count in SIZES[kind] for number in _sizes(shape, name, count, owner)]
    return Shape(kind, tuple(numbers), _origin(collision, owner))


def _sizes(shape: Element, name: str, count: int, owner: str) -> list[float]:
    where = f"<{shape.tag} {name}=...>"
    numbers = _numbers(shape.get(name, ""), count, where, owner)
    if min(numbers) <= 0.0:
        raise UsageError(f"{owner} has {shape.get(name)!r} in {where}. Give positive lengths.")
    return numbers


def _origin(element: Element, owner: str) -> Array:
    """The transform of the element's <origin>, (4, 4), [m]; the identity where it has none."""
    origin = element.find("origin")
    texts = ("0 0 0",) * 2 if origin is None else (origin.get("xyz", "0 0 0"), origin.get("rpy", "0 0 0"))
    xyz, rpy = (cast(Vector, tuple(_numbers(text, 3, "<origin>", owner))) for text in texts)
    return transform(xyz, rpy)


def _numbers(text: str, count: int, where: str, owner: str) -> list[float]:
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(math.isfinite(number) for number in numbers):
        raise UsageError(f"{owner} has {text!r} in {where}, where {count} finite numbers belong. Correct it.")
    return numbers
