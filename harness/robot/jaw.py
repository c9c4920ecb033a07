"""The last joint of an arm may be the jaw of its gripper, which a URDF does not say."""

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.robot.kinematics import Chain
from harness.robot.urdf import Joint, Urdf, linked

JAW = re.compile(r"grip|jaw|finger|claw|knuckle|pincer", re.IGNORECASE)
"""In the name of a joint: it opens and closes something."""
WRIST = re.compile(r"rot|roll|yaw|pitch|twist|turn|wrist|flex", re.IGNORECASE)
"""In the name of a joint: it turns a gripper as a whole."""
TOOL = re.compile(
    r"tcp|tool[-_]?(0|frame)|grasp|gripper[-_]?frame|end[-_]?effector|(^|[-_])eef?($|[-_])", re.IGNORECASE
)
"""In the name of a link: the frame that a tool works with."""
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

    def warning(self, settings: Path) -> str:
        """What a user has to know, and to write into the robot.toml `settings` if it is a jaw, in one line."""
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
    if not (last.kind == "prismatic" or _is_still(chain)):
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


def _is_still(chain: Chain) -> bool:
    """Whether the chain's end lies on the axis of its last joint."""
    tip, axis = chain.T_last_tip[:3, 3], chain.axes[-1]
    length = np.linalg.norm(chain.T_previous_joint[:, :3, 3], axis=1).sum() + np.linalg.norm(tip)
    return bool(np.linalg.norm(np.cross(axis, tip)) <= STILL * length)


def _fixed_to(urdf: Urdf, link: str) -> Iterator[str]:
    """The links that are fixed to a link, directly or by others, farther out, in the order of the text."""
    for joint in urdf.joints:
        if joint.get("type") == "fixed" and linked(joint, "parent") == link:
            child = linked(joint, "child")
            yield child
            yield from _fixed_to(urdf, child)
