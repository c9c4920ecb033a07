"""URDFs of arms that are drawn, and where their end effector is, by matrices that are written out here."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.linalg import norm
from numpy.random import default_rng

from harness import load_robot
from tests.oracles.trial import Trial, call

POSES = 3


@dataclass(frozen=True)
class Joint:
    """A joint of a chain; link i carries joint i, which moves link i + 1."""

    name: str
    kind: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    axis: tuple[float, ...]
    lower: float
    upper: float

    @property
    def is_driven(self):
        """Whether it moves."""
        return self.kind != "fixed"


def draw_arm(rng):
    """A chain of three to seven joints that move, with fixed ones between them."""
    driven = rng.randrange(3, 8)
    kinds = [rng.choice(("revolute", "revolute", "revolute", "continuous", "prismatic")) for _ in range(driven)]
    kinds[0] = "revolute"
    for _ in range(rng.randrange(3)):
        kinds.insert(rng.randrange(1, len(kinds) + 1), "fixed")
    first, *others = (_draw_joint(rng, f"joint_{place}", kind) for place, kind in enumerate(kinds))
    high = replace(first, xyz=(0.0, 0.0, 5.0))  # a resting pose clear of the ground is found
    return [high, *others]


def _draw_joint(rng, name, kind):
    axis = np.array([rng.gauss(0, 1) for _ in range(3)])
    axis = axis / norm(axis) if rng.random() < 0.3 else np.eye(3)[rng.randrange(3)] * rng.choice((-1, 1))
    upper = 0.1 if kind == "prismatic" else 2.0
    return Joint(
        name,
        kind,
        (rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(0.1, 0.4)),
        tuple(rng.choice((0.0, math.pi / 2, -0.5, rng.uniform(-3, 3))) for _ in range(3)),
        tuple(axis.tolist()),
        -upper * rng.choice((1.0, 0.5)),
        upper,
    )


def tip_of(arm, values):
    """Where the last link's origin is, [m], with these values of the joints that move, in their order."""
    place, left = np.eye(4), list(values)
    for joint in arm:
        place = place @ _origin(joint)
        if joint.is_driven:
            place = place @ _motion(joint, left.pop(0))
    return [float(number) for number in place[:3, 3]]


def _origin(joint):
    """Roll, then pitch, then yaw about fixed axes: Rz(y) Ry(p) Rx(r)."""
    (cr, cp, cy), (sr, sp, sy) = ([one(angle) for angle in joint.rpy] for one in (math.cos, math.sin))
    made = np.eye(4)
    made[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    made[:3, 3] = joint.xyz
    return made


def _motion(joint, value):
    """Along the axis, or about it by Rodrigues' formula."""
    made, axis = np.eye(4), np.array(joint.axis)
    if joint.kind == "prismatic":
        made[:3, 3] = value * axis
        return made
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    made[:3, :3] = np.eye(3) + math.sin(value) * cross + (1 - math.cos(value)) * cross @ cross
    return made


@dataclass
class Style:
    """How the file is written: all that must not matter."""

    spell: Callable[[float], str] = repr
    shuffle: bool = False
    turned: bool = False
    newline: str = "\n"
    head: str = '<?xml version="1.0"?>\n'
    spaces: str = ""
    beside: str = ""
    in_link: str = ""


STYLES = (
    Style(),
    Style(spell=lambda value: f"{value:.17e}"),
    Style(shuffle=True),
    Style(turned=True, newline="\r\n"),
    Style(head='<?xml version="1.0" encoding="utf-8"?>\n<!-- an arm -->\n'),
    Style(spaces=' xmlns:xacro="http://www.ros.org/wiki/xacro"'),
    Style(spaces=' xmlns="http://www.ros.org"'),
    Style(beside='<material name="red"><color rgba="1 0 0 1"/></material><gazebo reference="link_1"/>'),
    Style(beside='<transmission name="t"><type>simple</type><joint name="joint_0"/></transmission>'),
    Style(in_link='<visual><geometry><box size="9 9 9"/></geometry></visual>'),
    Style(in_link='<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'),
)


def text_of(arm, style, rng):
    """The file."""
    parts = [f'<link name="link_{place}">{style.in_link}</link>' for place in range(len(arm) + 1)]
    parts += [_element(place, joint, style) for place, joint in enumerate(arm)]
    if style.shuffle:
        rng.shuffle(parts)
    inside = style.newline.join([*parts, style.beside])
    return f'{style.head}<robot{style.spaces} name="arm">{style.newline}{inside}{style.newline}</robot>{style.newline}'


def _element(place, joint, style):
    def vector(values):
        return " ".join(map(style.spell, values))

    attributes = [f'name="{joint.name}"', f'type="{joint.kind}"']
    inside = [
        f'<parent link="link_{place}"/>',
        f'<child link="link_{place + 1}"/>',
        f'<origin xyz="{vector(joint.xyz)}" rpy="{vector(joint.rpy)}"/>',
    ]
    if joint.is_driven:
        bounds = f'lower="{style.spell(joint.lower)}" upper="{style.spell(joint.upper)}" '
        bounds = "" if joint.kind == "continuous" else bounds
        inside += [f'<axis xyz="{vector(joint.axis)}"/>', f'<limit {bounds}velocity="1.5" effort="10"/>']
    if style.turned:
        attributes.reverse()
        inside.reverse()
    return f"<joint {' '.join(attributes)}>{''.join(inside)}</joint>"


def poses_of(arm):
    """Values of the joints that move, within their limits."""
    driven = [joint for joint in arm if joint.is_driven]
    draw = default_rng(len(arm))
    return [[float(draw.uniform(joint.lower, joint.upper)) for joint in driven] for _ in range(POSES)]


def answer_of(arm):
    """What has to be read."""
    driven = [joint for joint in arm if joint.is_driven]
    turns = [joint.kind == "continuous" for joint in driven]
    return {
        "joints": [joint.name for joint in driven],
        "lower": [-math.pi if turn else joint.lower for joint, turn in zip(driven, turns, strict=True)],
        "upper": [math.pi if turn else joint.upper for joint, turn in zip(driven, turns, strict=True)],
        "tips": [tip_of(arm, pose) for pose in poses_of(arm)],
    }


def ask(path, poses):
    """What is read of it; `harness describe` refuses what it does not read."""
    said = call("describe", path)
    robot = load_robot(path)
    fitting = [pose for pose in poses if len(pose) == robot.dof]
    return {
        "joints": list(robot.joint_names),
        "lower": robot.lower.tolist(),
        "upper": robot.upper.tolist(),
        "tips": robot.end_effector(fitting).tolist() if fitting else [],
    }, "\n".join(said)


def _trial(change, arm, text, folder, **right):
    path = folder / "arm.urdf"
    path.write_text(text, newline="")
    return Trial(change, lambda: ask(path, poses_of(arm)), **{"right": [answer_of(arm)], **right})


def no_matter(rng, folder):
    """The same arm, written otherwise."""
    arm, style = draw_arm(rng), rng.choice(STYLES)
    return _trial(f"written as {style}", arm, text_of(arm, style, rng), folder)


def split_origin(rng, folder):
    """An origin in two parts, with a link between them that does not move: the same arm."""
    arm = draw_arm(rng)
    place = rng.randrange(len(arm))
    moved = arm[place]
    before = Joint("mount", "fixed", moved.xyz, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 0.0)
    after = replace(moved, xyz=(0.0, 0.0, 0.0))
    longer = [*arm[:place], before, after, *arm[place + 1 :]]
    return _trial("an origin in two parts", arm, text_of(longer, rng.choice(STYLES), rng), folder)


def matters(rng, folder):
    """Another arm."""
    arm = draw_arm(rng)
    place = rng.randrange(len(arm))
    one = arm[place]
    changes = {
        "xyz": replace(one, xyz=(one.xyz[0] + 0.05, *one.xyz[1:])),
        "rpy": replace(one, rpy=(one.rpy[0], one.rpy[1] + 0.3, one.rpy[2])),
        "axis": replace(one, axis=tuple(-number for number in one.axis)),
        "limits": replace(one, lower=one.lower / 2, upper=one.upper / 4),
        "names": replace(one, name="shoulder"),
        "order": replace(one, rpy=(one.rpy[2], one.rpy[0], one.rpy[1])),
    }
    change = rng.choice(list(changes))
    arm[place] = changes[change]
    return _trial(f"other {change}", arm, text_of(arm, rng.choice(STYLES), rng), folder)


def in_folder(rng, folder):
    """A robot.toml names the end effector, which stands in the middle of the chain."""
    arm = draw_arm(rng)
    end = rng.randrange([place for place, joint in enumerate(arm) if joint.is_driven][2], len(arm))
    (folder / "arm.urdf").write_text(text_of(arm, rng.choice(STYLES), rng), newline="")
    lines = ['name = "mine"', 'urdf = "arm.urdf"', f'end_effector = "link_{end + 1}"']
    rng.shuffle(lines)
    (folder / "robot.toml").write_text(rng.choice(("\n", "\r\n")).join([*lines, ""]), newline="")
    shorter = arm[: end + 1]
    right = [answer_of(shorter)]
    return Trial("the end effector is named", lambda: ask(folder, poses_of(shorter)), right)


def damaged(rng, folder):
    """No arm follows from it."""
    arm = draw_arm(rng)
    text = text_of(arm, STYLES[0], rng)
    change = rng.choice(list(DAMAGES))
    return _trial(change, arm, DAMAGES[change](text, rng), folder, right=[])


def _swap(old, new):
    def change(text, rng):
        assert old in text
        return text.replace(old, new, 1)

    return change


def _in_first(name, value):
    """An attribute of the first joint has another value."""

    def change(text, rng):
        begin = text.index(f'{name}="', text.index("<joint")) + len(name) + 2
        return text[:begin] + value + text[text.index('"', begin) :]

    return change


DAMAGES = {
    "two links of one name": _swap('<link name="link_1">', '<link name="link_0">'),
    "a link that is missing": _swap('<link name="link_1"></link>', ""),
    "two joints of one name": _swap('name="joint_1"', 'name="joint_0"'),
    "a loop": _swap(
        "</robot>", '<joint name="l" type="fixed"><parent link="link_2"/><child link="link_0"/></joint></robot>'
    ),
    "two carriers of a link": _swap(
        "</robot>", '<joint name="l" type="fixed"><parent link="link_0"/><child link="link_2"/></joint></robot>'
    ),
    "two roots": _swap("</robot>", '<link name="alone"/></robot>'),
    "an odd kind": _in_first("type", "hinge"),
    "no number": _in_first("xyz", "0 x 0"),
    "NaN": _in_first("xyz", "0 nan 0"),
    "two numbers of three": _in_first("xyz", "0 0"),
    "four numbers of three": _in_first("rpy", "0 0 0 0"),
    "an axis of 0": _swap('<axis xyz="', '<axis xyz="0 0 0" was="'),
    "limits turned": _in_first("lower", "7"),
    "infinite limits": _in_first("upper", "inf"),
    "decimal comma": _in_first("xyz", "0,1 0 0"),
    "cut off": lambda text, rng: text[: rng.randrange(len(text) // 2, len(text) - 12)],
    "no joints": lambda text, rng: '<robot name="a"><link name="b"/></robot>',
    "another format": lambda text, rng: "<mujoco><worldbody/></mujoco>",
    "no limits": lambda text, rng: text.replace("<limit", "<limited"),
}
ORACLES = {
    "arm, written otherwise": no_matter,
    "arm, an origin in two parts": split_origin,
    "arm, another one": matters,
    "arm, in a folder": in_folder,
    "arm, damaged": damaged,
}
