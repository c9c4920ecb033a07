"""A URDF with only the joints and masses of an arm, for engines to which shapes are added by hand."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from harness.robot import Robot, parse_urdf

OF_LINK, OF_JOINT = {"inertial"}, {"parent", "child", "origin", "axis"}
"""The tags that are kept in a link and in a joint."""


def bare_urdf(robot: Robot) -> tuple[str, str]:
    """The robot's URDF with only its joints, and the masses of the links that they carry.

    Shapes, friction, damping, transmissions and materials are left out. The shapes that collide are added later, from
    the robot's `joint_shapes`.

    Returns:
        The URDF as text, and the name of its root link, which is left without a mass.
    """
    urdf = parse_urdf(robot.urdf)
    (root,) = set(urdf.links) - set(urdf.carriers)
    _keep(urdf.element, {"link", "joint"})
    for name, link in urdf.links.items():
        _keep(link, OF_LINK if name != root else set())
    for joint in urdf.joints:
        # A continuous joint has no range, but some engines would use one that its URDF gives.
        _keep(joint, OF_JOINT if joint.get("type") == "continuous" else OF_JOINT | {"limit"})
    return ElementTree.tostring(urdf.element, encoding="unicode"), root


def _keep(element: Element, tags: set[str]) -> None:
    for part in [part for part in element if part.tag not in tags]:
        element.remove(part)
