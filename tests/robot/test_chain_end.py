"""Where the chain of an arm ends that does not name its end effector."""

import pytest

from harness.errors import UsageError
from harness.robot.chain_end import find_chain_end
from harness.robot.urdf import Urdf, parse_urdf


def arm(*joints: str) -> Urdf:
    """A URDF of joints written as ``parent-child``, or ``parent>child`` where the joint moves."""
    links, text = set(), ""
    for joint in joints:
        kind = "revolute" if ">" in joint else "fixed"
        parent, child = joint.replace(">", "-").split("-")
        links |= {parent, child}
        text += f'<joint name="{parent}-{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        text += '<limit lower="0" upper="1"/></joint>'
    named = "".join(f'<link name="{link}"/>' for link in sorted(links))
    return parse_urdf(f'<robot name="r">{named}{text}</robot>')


def test_tip_is_where_one_chain_ends(subtests: pytest.Subtests):
    """The last link of a single chain, the palm of a hand; frames fixed beside the way do not count."""
    rows = [
        (("a>b", "b>c", "c>d"), "d"),
        (("a>b", "b>c", "c>d", "d-e", "e-f"), "f"),
        (("a-world", "a>b", "b>c", "c>d", "d-e"), "e"),
        (("a>b", "b-camera", "b>c", "c>d"), "d"),
        (("a>b", "b>c", "c>d", "d-flange", "d-camera"), "d"),
        (("a>b", "b>c", "c>d", "d-hand", "hand>left", "hand>right", "hand-grasp"), "hand"),
        (("a>b", "b>c", "c>d", "d-hand", "hand-palm", "palm>one", "one>two", "palm>three"), "palm"),
        (("a>b", "b>c", "c>d", "d-left", "left>x", "d-right", "right>y"), "d"),
    ]
    for joints, tip in rows:
        with subtests.test(joints=joints, tip=tip):
            assert find_chain_end(arm(*joints)) == tip
            assert find_chain_end(arm(*reversed(joints))) == tip


def test_early_branches_may_be_arms():
    """A body with two arms has no end; the answer names the branches and what to do."""
    two_arms = arm("a>body", "body>b", "b>c", "c>d", "body>x", "x>y", "y>z")
    message = r"branches at link 'body' into 'b', 'x'.*end_effector in a robot\.toml"
    with pytest.raises(UsageError, match=message) as caught:
        find_chain_end(two_arms)
    assert "\n" not in str(caught.value)
