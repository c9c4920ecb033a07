"""The collision shapes of a URDF, and the joints that move them.

Reference: http://wiki.ros.org/urdf/XML/link
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, cast
from xml.etree.ElementTree import Element

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.kinematics import read_only, transform
from harness.robot.meshes import Mesh, distinct, read_mesh
from harness.robot.urdf import LARGEST, Urdf, Vector, linked, number_of
from harness.text import shortened

ShapeKind = Literal["box", "cylinder", "capsule", "sphere", "mesh"]

SIZES: Mapping[ShapeKind, tuple[tuple[str, int], ...]] = {
    "box": (("size", 3),),
    "cylinder": (("radius", 1), ("length", 1)),
    "capsule": (("radius", 1), ("length", 1)),
    "sphere": (("radius", 1),),
    "mesh": (),
}
"""The attributes of each kind of shape that are lengths, and how many numbers each one has."""

TOO_LONG = 30.0
"""A mesh that is longer than the arm's reach by this factor is in another unit than metres."""
FLAT, SHEET = 1e-6, 1e-3
"""Points that are nearer than this to a plane lie in it, and how thick a hull of such points is made, [m]."""
NO_POINTS = read_only(np.empty((0, 3)))


@dataclass(frozen=True, eq=False)
class Shape:
    """One solid; its arrays are read-only.

    Attributes:
        kind: Which.
        size: Of a box its edges along x, y and z; of a sphere its radius; of a cylinder or capsule its radius and its
            length along z, a capsule's without its half spheres; all positive [m]. Of a mesh nothing.
        T_link_shape: The shape's frame, at its centre, in the link's frame, shape (4, 4), translation in [m].
        points: Of a mesh its points in the shape's frame, scaled, shape (count, 3), [m]: what collides is their
            convex hull. Of another shape none.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    T_link_shape: Float
    points: Float = field(default_factory=lambda: NO_POINTS)


def read_shapes(urdf: Urdf) -> dict[str, tuple[Shape, ...]]:
    """The collision shapes of each link, by the link's name; a link without any has an empty tuple.

    Args:
        urdf: What `harness.robot.normal_urdf.normal_urdf` returned.

    Raises:
        UsageError: A collision shape or its mesh cannot be computed with; the message names the link.
    """
    return {
        name: tuple(_read_shape(collision, f"Link '{name}'") for collision in link.findall("collision"))
        for name, link in urdf.links.items()
    }


def attach_shapes(
    urdf: Urdf, shapes: Mapping[str, Sequence[Shape]], joint_names: Sequence[str | None]
) -> tuple[tuple[Shape, ...], ...]:
    """The shapes that move with each joint of a chain, those of links fixed to the joint's child link included.

    What others move is left out. The frame of the base is the world's.

    Args:
        urdf: What `harness.robot.normal_urdf.normal_urdf` returned.
        shapes: Those of its links, as `read_shapes` returns them.
        joint_names: The joints of the chain that move; None stands for the base.

    Returns:
        One tuple for each of them; `T_link_shape` is in the frame of the joint's child link.

    Raises:
        UsageError: The origin of a fixed joint cannot be computed with.
    """
    attached: dict[str | None, list[Shape]] = {name: [] for name in joint_names}
    for link, group in shapes.items():
        joint, T_child_link = moving_carrier(link, urdf.carriers)
        if joint in attached:
            poses = [read_only(T_child_link @ shape.T_link_shape) for shape in group]
            attached[joint] += [replace(shape, T_link_shape=pose) for shape, pose in zip(group, poses, strict=True)]
    return tuple(tuple(group) for group in attached.values())


def moving_carrier(link: str, carrier: Mapping[str, Element]) -> tuple[str | None, Float]:
    """The joint that moves a link, None where none does, and T_child_link, (4, 4), [m], in its child link's frame.

    Args:
        link: Its name.
        carrier: By name of a link the joint that carries it, `Urdf.carriers`.

    Raises:
        UsageError: An origin on the way has no three finite numbers each.
    """
    T_child_link: Float = np.eye(4)
    while link in carrier:
        joint = carrier[link]
        if joint.get("type") != "fixed":
            return joint.get("name"), T_child_link
        T_child_link = read_origin(joint, f"Joint '{joint.get('name')}'") @ T_child_link
        link = linked(joint, "parent")
    return None, T_child_link


def find_too_long(urdf: Urdf, reach: float) -> dict[str, float]:
    """How long the meshes are that are far too long for the arm, [m], by their link's name.

    Args:
        urdf: What `harness.robot.normal_urdf.normal_urdf` returned.
        reach: Of the arm, [m].

    Raises:
        UsageError: One of them collides and moves: no pose would keep it above the ground.
    """
    found: dict[str, float] = {}
    for name, link in urdf.links.items():
        for part in link:
            for mesh in part.findall("geometry/mesh"):
                points = read_mesh(Path(mesh.get("filename", ""))).vertices * read_scale(mesh, f"Link '{name}'")
                length = float(np.ptp(points, axis=0).max())
                if length <= TOO_LONG * reach:
                    continue
                if part.tag == "collision" and moving_carrier(name, urdf.carriers)[0] is not None:
                    raise UsageError(
                        f"Link '{name}' has a collision mesh {length:.3g} m long, and the arm reaches {reach:.3g} m. "
                        'If the file is in millimetres, give the <mesh> scale="0.001 0.001 0.001".'
                    )
                found[name] = length
    return found


def _read_shape(collision: Element, owner: str) -> Shape:
    geometry = collision.find("geometry")
    if geometry is None or len(geometry) != 1:
        raise UsageError(f"{owner} has a collision without one shape in its <geometry>. Give it one.")
    shape = geometry[0]
    if shape.tag not in SIZES:
        raise UsageError(f"{owner} has a collision <{shape.tag}>; allowed: {', '.join(SIZES)}. Change it.")
    kind = cast(ShapeKind, shape.tag)
    numbers = read_sizes(shape, owner)
    points = read_points(shape, owner) if kind == "mesh" else NO_POINTS
    return Shape(kind, numbers, read_only(read_origin(collision, owner)), points)


def read_points(mesh: Element, owner: str) -> Float:
    """The points of a <mesh> that collides, scaled, (count, 3), [m], read-only; what collides is their convex hull.

    A flat one, such as a marker's plate, gets the thickness `SHEET`: engines need a hull that holds something.

    Args:
        mesh: The element, with the path of its file.
        owner: What an error begins with, as ``Link 'hand'``.

    Raises:
        UsageError: The file cannot be read as a mesh, or the scale is none.
    """
    try:
        points, _ = distinct(read_mesh(Path(mesh.get("filename", ""))).vertices)
    except UsageError as error:
        raise UsageError(f"{owner} has a collision mesh: {error}") from error
    return read_only(_thickened(points * read_scale(mesh, owner)))


def _thickened(points: Float) -> Float:
    """The points, or, where they lie in a plane or on a line, twice as many on both sides of it."""
    centered = points - points.mean(axis=0)
    for normal in np.linalg.eigh(centered.T @ centered)[1].T:
        if np.ptp(centered @ normal) <= FLAT:
            points = np.concatenate([points + SHEET / 2.0 * normal, points - SHEET / 2.0 * normal])
    return points


def read_scale(mesh: Element, owner: str) -> Float:
    """The factors of a <mesh> along x, y and z, (3,), none of them 0; 1 where it has none.

    Args:
        mesh: The element.
        owner: What an error begins with, as ``Link 'hand'``.

    Raises:
        UsageError: They are not three numbers, or one is 0.
    """
    scale = np.array(_numbers(mesh.get("scale", "1 1 1"), 3, "<mesh scale=...>", owner))
    if not scale.all():
        raise UsageError(f"{owner} has {mesh.get('scale')!r} in <mesh scale=...>. Give factors that are not 0.")
    return scale


def read_surface(visual: Element, owner: str) -> tuple[Mesh, Float]:
    """The surface of a <visual> with a <mesh>, scaled, and T_link_mesh, (4, 4); lengths in [m].

    A mirrored mesh has its corners in the other order, so that they stay counter-clockwise.

    Args:
        visual: The element.
        owner: What an error begins with, as ``Link 'hand'``.

    Raises:
        UsageError: The file cannot be read as a mesh, or scale or origin are none.
    """
    element = visual.find("geometry/mesh")
    if element is None:
        raise UsageError(f"{owner} has a visual without a mesh")
    mesh, scale = read_mesh(Path(element.get("filename", ""))), read_scale(element, owner)
    faces = mesh.faces[:, ::-1] if np.prod(scale) < 0 else mesh.faces
    return Mesh(mesh.vertices * scale, faces), read_origin(visual, owner)


def read_sizes(shape: Element, owner: str) -> tuple[float, ...]:
    """The lengths of a shape, as `Shape.size`; of a mesh none.

    Args:
        shape: The element in a <geometry>, one of `SIZES`.
        owner: What an error begins with, as ``Link 'hand'``.

    Raises:
        UsageError: They are not positive numbers.
    """
    sizes: list[float] = []
    for name, count in SIZES[cast(ShapeKind, shape.tag)]:
        where = f"<{shape.tag} {name}=...>"
        sizes += _numbers(shape.get(name, ""), count, where, owner)
        if min(sizes) <= 0.0:
            raise UsageError(f"{owner} has {shape.get(name)!r} in {where}. Give positive lengths.")
    return tuple(sizes)


def read_origin(element: Element, owner: str) -> Float:
    """The transform of the element's <origin>, (4, 4), [m]; the identity where it has none.

    Args:
        element: A <collision>, <visual> or <joint>.
        owner: What an error begins with, as ``Link 'hand'``.

    Raises:
        UsageError: It has no three finite numbers each.
    """
    origin = element.find("origin")
    texts = ("0 0 0",) * 2 if origin is None else (origin.get("xyz", "0 0 0"), origin.get("rpy", "0 0 0"))
    xyz, rpy = (cast(Vector, tuple(_numbers(text, 3, "<origin>", owner))) for text in texts)
    return transform(xyz, rpy)


def _numbers(text: str, count: int, where: str, owner: str) -> list[float]:
    numbers = [number_of(word) for word in text.split(None, count)]
    if len(numbers) != count or any(map(math.isnan, numbers)):
        belongs = f"where {count} finite numbers belong, of at most {LARGEST:g}"
        raise UsageError(f"{owner} has {shortened(repr(text), 60)} in {where}, {belongs}. Correct it.")
    return numbers
