"""The joints and masses of an arm, and nothing else: a URDF for engines to which shapes are added by hand."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from harness.robot import Robot
from harness.robot.urdf import parse_urdf

OF_LINK, OF_JOINT = {"inertial"}, {"parent", "child", "origin", "axis"}
"""What stays of them."""


def bare_urdf(robot: Robot) -> tuple[str, str]:
    """The robot's URDF with its joints, and the masses of the links that they carry.

    Shapes, friction, damping, transmissions and materials are gone. What collides are the robot's `joint_shapes`.

    Returns:
        The URDF as text, and the name of its root link, which is left without a mass.
    """
    urdf = parse_urdf(robot.urdf)
    (root,) = set(urdf.links) - set(urdf.carriers)
    _keep(urdf.element, {"link", "joint"})
    for name, link in urdf.links.items():
        _keep(link, OF_LINK if name != root else set())
    for joint in urdf.joints:
        # Some readers would take the range of a joint that turns without end for one.
        _keep(joint, OF_JOINT if joint.get("type") == "continuous" else OF_JOINT | {"limit"})
    return ElementTree.tostring(urdf.element, encoding="unicode"), root


def _keep(element: Element, tags: set[str]) -> None:
    for part in [part for part in element if part.tag not in tags]:
        element.remove(part)
