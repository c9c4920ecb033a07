"""Where a chain ends if nobody says so, and whether that is a tool or the jaw of a gripper."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from harness.arrays import Mask
from harness.errors import UsageError
from harness.robot.kinematics import Chain, build_chain, position_jacobian
from harness.robot.urdf import Joint, Urdf, linked, parse_urdf, read_chain

FEWEST_BEFORE_A_HAND = 3
"""Joints that move before branches that move are a hand's fingers, and not several arms."""


def find_chain_end(urdf: Urdf) -> str:
    """The last link of the one chain that a URDF describes.

    From the root link the way leads along the joints that move, or that carry what moves. It ends where two or more
    such joints begin, at the palm of a hand; else behind the last joint that moves, at the last link that is fixed to
    it, or at the link where several are. Of frames that are fixed there, the one with the name of a tool's is the end.
    Fixed branches beside the way, such as frames on the base, do not count.

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
            return _tool_at(urdf, link) or link
        if len(onward) > 1:
            branches = ", ".join(f"'{linked(joint, 'child')}'" for joint in onward)
            raise UsageError(
                f"The arm branches at link '{link}' into {branches}, and nothing says which is its end. "
                "Name it as end_effector in a robot.toml: beside the URDF, or elsewhere with the URDF's path as urdf."
            )
        moving += _moves(onward[0])
        link = linked(onward[0], "child")
    while len(fixed := _joints_of(link, joints)) == 1:
        link = linked(fixed[0], "child")
    return _tool_at(urdf, link) or link


def _tool_at(urdf: Urdf, end: str) -> str | None:
    """The tool's frame that is fixed to a link; None where there is none, or several that are not at one point."""
    frames = [link for link in _fixed_to(urdf, end) if TOOL.search(link)]
    places = [build_chain(read_chain(urdf, frame)).T_last_tip[:3, 3] for frame in frames]
    if not frames or np.ptp(places, axis=0).max() > AT_ONE_POINT:
        return None
    return min(frames, key=lambda frame: not frame.endswith(TOOL0))


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


def _joints_of(link: str, joints: Sequence[Element]) -> list[Element]:
    return [joint for joint in joints if linked(joint, "parent") == link]


def _moves(joint: Element) -> bool:
    return joint.get("type") != "fixed"


JAW = re.compile(r"grip|jaw|finger|claw|knuckle|pincer", re.IGNORECASE)
"""In the name of a joint: it opens and closes something."""
WRIST = re.compile(r"rot|roll|yaw|pitch|twist|turn|wrist|flex", re.IGNORECASE)
"""In the name of a joint: it turns a gripper as a whole."""
TOOL = re.compile(
    r"tcp|tool[-_]?(0|frame)|grasp|gripper[-_]?frame|end[-_]?effector|attachment|(^|[-_])eef?($|[-_])", re.IGNORECASE
)
"""In the name of a link: the frame that a tool works with."""
TOOL0 = "tool0"
"""What most arms for industry call it; some have an older name for the same point beside it."""
AT_ONE_POINT = 1e-6
"""Frames that are nearer than this to one another are one to a task, whose target is a point, [m]."""
POSES = 5
"""Random ones, in which a joint moves the end effector or never does."""
STILL = 1e-6
"""A tip that is nearer than this to a joint's axis does not move with it, as a share of the chain's length."""


@dataclass(frozen=True)
class Jaw:
    """The last joint of a chain, which looks like the jaw of a gripper.

    Attributes:
        joint: Its name.
        tip: The link at the end of the chain.
        reasons: What it looks like a jaw by, in words.
        palm: The link to name as end effector instead: a tool's frame beside the jaw, else what carries the jaw.
    """

    joint: str
    tip: str
    reasons: tuple[str, ...]
    palm: str

    def warning(self, settings: str) -> str:
        """What a user has to know in one line, and to write into `settings`, the robot.toml, if it is a jaw."""
        return (
            f"the end effector, '{self.tip}', is moved by '{self.joint}', which looks like the jaw of a gripper: "
            f"{', '.join(self.reasons)}. If it is one, write into {settings}: "
            f"end_effector = {json.dumps(self.palm, ensure_ascii=False)}"
        )


def find_jaw(urdf: Urdf, chain: Chain, joints: Sequence[Joint]) -> Jaw | None:
    """The last moving joint, if it looks like a jaw; None where nothing says so.

    It cannot move the chain's end aside, or slides. And its name says that it opens something, or what carries it
    carries the frame of a tool too.

    Args:
        urdf: The URDF.
        chain: Of the arm.
        joints: Those of the chain in order, fixed ones included; two of them move.
    """
    *_, before, last = (joint for joint in joints if joint.kind != "fixed")
    tip, axis = chain.T_last_tip[:3, 3], chain.axes[-1]
    length = np.linalg.norm(chain.T_previous_joint[:, :3, 3], axis=1).sum() + np.linalg.norm(tip)
    if last.kind != "prismatic" and np.linalg.norm(np.cross(axis, tip)) > STILL * length:
        return None
    is_named = bool(JAW.search(last.name)) and not WRIST.search(last.name)
    frames = [link for link in _fixed_to(urdf, before.child) if TOOL.search(link)]
    reasons = [
        *["by its name"] * is_named,
        *[f"it does not move the tool's frame '{frame}'" for frame in frames[:1]],
        "it slides" if last.kind == "prismatic" else "it only turns its link",
    ]
    if not is_named and not frames:
        return None
    return Jaw(last.name, joints[-1].child, tuple(reasons), [*frames, last.parent][0])


def _fixed_to(urdf: Urdf, link: str) -> Iterator[str]:
    """The links that are fixed to a link, directly or by others, farther out, in the order of the text."""
    for joint in urdf.joints:
        if joint.get("type") == "fixed" and linked(joint, "parent") == link:
            child = linked(joint, "child")
            yield child
            yield from _fixed_to(urdf, child)


@dataclass(frozen=True)
class Tip:
    """The end effector of an arm, and what else might be meant by it.

    Attributes:
        still: Joints that do not move it: it lies on the axes of the last ones.
        beside: Other links that the last joint moves as it does, tools' frames first.
        tool: The one with the name of a tool's frame to write as end effector instead; None where the end effector has
            such a name itself, or none has.
    """

    still: tuple[str, ...]
    beside: tuple[str, ...]
    tool: str | None


def tip_of(urdf_text: str, end_effector: str, chain: Chain) -> Tip:
    """What is known of an arm's end effector.

    Args:
        urdf_text: A URDF in which only the arm's joints move.
        end_effector: The link.
        chain: From the root link to it.
    """
    urdf = parse_urdf(urdf_text)
    driven = [joint for joint in read_chain(urdf, end_effector) if joint.kind != "fixed"]
    last = driven[-1].child
    beside = [link for link in (last, *_fixed_to(urdf, last)) if link != end_effector]
    tools = [link for link in beside if TOOL.search(link)]
    is_one = TOOL.search(end_effector) or not tools
    return Tip(
        still=tuple(joint.name for joint, moves in zip(driven, _move_tip(chain), strict=True) if not moves),
        beside=(*tools, *(link for link in beside if link not in tools)),
        tool=None if is_one else tools[0],
    )


def _move_tip(chain: Chain) -> Mask:
    """Which joints move the end effector in some pose, (dof,)."""
    poses = np.random.default_rng(0).uniform(-1.0, 1.0, (POSES, chain.dof))
    moved: Mask = np.linalg.norm(position_jacobian(chain, poses), axis=1).max(axis=0) > STILL
    return moved
