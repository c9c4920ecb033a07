"""The end of an arm that does not name it: where the one chain of a URDF stops being one."""

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from harness.errors import UsageError
from harness.robot.urdf import Urdf, linked

FEWEST_BEFORE_A_HAND = 3
"""Joints that move before branches that move are a hand's fingers, and not several arms."""


def find_chain_end(urdf: Urdf) -> str:
    """The last link of the one chain that a URDF describes.

    From the root link the way leads along the joints that move, or that carry what moves. It ends where two or more
    such joints begin, at the palm of a hand; else behind the last joint that moves, at the last link that is fixed to
    it, or at the link where several are. Fixed branches beside the way, such as frames on the base, do not count.

    Args:
        urdf: The URDF.

    Returns:
        The link's name.

    Raises:
        UsageError: The chain branches so early that the branches may be arms.
    """
    joints, lively = urdf.joints, _links_before_motion(urdf.carriers)
    link = next(name for name in urdf.links if name not in urdf.carriers)
    moving = 0
    while onward := [joint for joint in _joints_of(link, joints) if _moves(joint) or linked(joint, "child") in lively]:
        if len(onward) > 1 and moving >= FEWEST_BEFORE_A_HAND:
            return link
        if len(onward) > 1:
            branches = ", ".join(f"'{linked(joint, 'child')}'" for joint in onward)
            raise UsageError(
                f"The arm branches at link '{link}' into {branches}, and nothing says which is its end. "
                "Name it as end_effector in a robot.toml beside the URDF."
            )
        moving += _moves(onward[0])
        link = linked(onward[0], "child")
    return _last_fixed(link, joints)


def _links_before_motion(carrier: Mapping[str, Element]) -> set[str]:
    """Links that carry a joint that moves, at any distance."""
    links: set[str] = set()
    for joint in filter(_moves, carrier.values()):
        link = linked(joint, "parent")
        links.add(link)
        while link in carrier:
            link = linked(carrier[link], "parent")
            links.add(link)
    return links


def _last_fixed(link: str, joints: Sequence[Element]) -> str:
    while len(onward := _joints_of(link, joints)) == 1:
        link = linked(onward[0], "child")
    return link


def _joints_of(link: str, joints: Sequence[Element]) -> list[Element]:
    return [joint for joint in joints if linked(joint, "parent") == link]


def _moves(joint: Element) -> bool:
    return joint.get("type") != "fixed"
