"""Arms that differ from the drawing: the same URDF with other masses and lengths."""

from copy import deepcopy
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from harness.conditions.conditions import Conditions
from harness.robot import Robot
from harness.robot.joint_limits import Servo
from harness.robot.kinematics import build_chain, read_only
from harness.robot.shapes import attach_shapes, read_shapes
from harness.robot.urdf import Urdf, linked, parse_urdf, read_chain

STREAM = 20_251_122
"""Arm n of all arms is the same whatever the seed of a cell; an episode draws n."""


class Factors(NamedTuple):
    """How an arm differs: 1 is as drawn.

    Attributes:
        masses: Of each link that moves, in the order of the URDF.
        lengths: The same.
        friction: Of all drives.
    """

    masses: tuple[float, ...]
    lengths: tuple[float, ...]
    friction: float


def draw_factors(conditions: Conditions, robot: Robot, number: int) -> Factors:
    """Those of arm `number`, each uniform in 1 +- its share."""
    rng = np.random.default_rng([STREAM, number])
    links = len(_moving_links(parse_urdf(robot.urdf)))
    around = rng.uniform(-1.0, 1.0, (2, links))
    masses, lengths = 1.0 + conditions.mass_variation * around[0], 1.0 + conditions.length_variation * around[1]
    friction = 1.0 + conditions.friction_variation * float(rng.uniform(-1.0, 1.0))
    return Factors(tuple(masses.tolist()), tuple(lengths.tolist()), friction)


@lru_cache(maxsize=1000)
def draw_robot(conditions: Conditions, robot: Robot, number: int) -> Robot:
    """Arm `number`; made once for all envs of a process."""
    return vary_robot(robot, draw_factors(conditions, robot, number))


def vary_robot(robot: Robot, factors: Factors) -> Robot:
    """The arm with other masses, sizes and friction; `robot` itself where all factors are 1.

    A link is scaled as a whole: its shapes, its centre of mass, and where the next joints begin. Its moments of inertia
    go with its mass and the square of its length. Joint limits, home and speeds stay.
    """
    if all(factor == 1.0 for factor in (*factors.masses, *factors.lengths, factors.friction)):
        return robot
    given = parse_urdf(robot.urdf)
    element = deepcopy(given.element)
    links = {link.get("name", ""): link for link in element.findall("link")}
    lengths: dict[str, float] = {}
    for name, mass, length in zip(_moving_links(given), factors.masses, factors.lengths, strict=True):
        _scale_link(links[name], mass, length)
        lengths[name] = length
    for joint in element.findall("joint"):
        _scale_origin(joint, lengths.get(linked(joint, "parent"), 1.0))
    urdf = parse_urdf(ElementTree.tostring(element, encoding="unicode"))
    shapes = read_shapes(urdf)
    return replace(
        robot,
        urdf=urdf.text,
        chain=build_chain(read_chain(urdf, robot.end_effector_link)),
        link_shapes=shapes,
        joint_shapes=attach_shapes(urdf, shapes, robot.joint_names),
        servo=_rub(robot.servo, factors.friction),
    )


def _rub(servo: Servo | None, factor: float) -> Servo | None:
    """The drives with more or less friction, of both kinds."""
    if servo is None:
        return None
    viscous, dry = read_only(servo.viscous_friction * factor), read_only(servo.dry_friction * factor)
    return replace(servo, viscous_friction=viscous, dry_friction=dry)


def _moving_links(urdf: Urdf) -> list[str]:
    """Names of the links that a joint carries: all but the root."""
    return [name for name in urdf.links if name in urdf.carriers]


def _scale_link(link: Element, mass: float, length: float) -> None:
    for inertial in link.findall("inertial"):
        _scale(inertial.find("mass"), "value", mass)
        inertia = inertial.find("inertia")
        for name in () if inertia is None else tuple(inertia.keys()):
            _scale(inertia, name, mass * length**2)
        _scale_origin(inertial, length)
    for part in (*link.findall("visual"), *link.findall("collision")):
        _scale_origin(part, length)
        for name in ("size", "radius", "length"):
            for shape in part.iter():
                _scale(shape, name, length)
        for mesh in part.iter("mesh"):
            mesh.set("scale", mesh.get("scale", "1 1 1"))
            _scale(mesh, "scale", length)


def _scale_origin(element: Element, length: float) -> None:
    _scale(element.find("origin"), "xyz", length)


def _scale(element: Element | None, attribute: str, factor: float) -> None:
    """Multiply the numbers of an attribute, where it is there."""
    if element is not None and element.get(attribute) is not None and factor != 1.0:
        numbers = [float(word) * factor for word in element.get(attribute, "").split()]
        element.set(attribute, " ".join(map(repr, numbers)))
