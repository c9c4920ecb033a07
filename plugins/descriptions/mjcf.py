"""MJCF, the format of MuJoCo: its own parser reads it, and the compiled model becomes the text of a URDF.

Classes, angles in degrees, frames, included files and inertias of shapes are solved in the compiled model. A body
becomes a link of its name, whose frame is the body's; a site becomes a link without mass that is fixed to it.
"""

import math
import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from harness import Float
from harness.errors import UsageError
from harness.files import run_apart
from harness.robot import Description, read_mesh
from harness.robot.chain_end import TOOL

from .mjcf_bounds import require_bounded

MOST_REF = 1e6
"""The largest `ref` of a joint, [rad] or [m]: of a larger one no digits are left that say where its link turns to."""
FASTEST = 100.0
"""The speed of every joint in the URDF, [rad/s] or [m/s]: more than any arm has, as MJCF names none."""
SPEEDS = (
    "an MJCF has no place for the largest speeds of joints: 180 deg/s is taken, and half its range a second for a "
    "slide. Write the arm's own into a robot.toml: max_speed_deg_s, max_speed_m_s"
)
SITE = re.compile(r"attachment|" + TOOL.pattern, re.IGNORECASE)
"""In the name of a site: it is where a tool is held, or works."""
MESH = 7
"""MuJoCo's number for meshes among the types of shapes; its numbers for types never change."""
DRAWN_GROUPS = 3
"""Shapes of the groups below this one are drawn by MuJoCo's viewer."""
JOINTS, TENDONS, JOINT_WRAP = 2, 3, 1
"""MuJoCo's numbers for equalities of joints and of tendons, and for a joint among the parts of a tendon."""
NAMED = 3
"""Names in a message."""
EXAMPLE = """<mujoco model="example">
  <compiler angle="degree"/>
  <default><joint axis="0 1 0" range="-100 100"/><geom type="capsule" size="0.03"/></default>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="base" pos="0 0 0.1">
      <geom type="cylinder" size="0.06 0.05"/>
      <body name="turret" pos="0 0 0.1">
        <joint name="turn" axis="0 0 1"/><geom fromto="0 0 0 0 0 0.2"/>
        <body name="upper" pos="0 0 0.2">
          <joint name="lift"/><geom fromto="0 0 0 0 0 0.3"/>
          <body name="fore" pos="0 0 0.3" euler="0 90 0">
            <joint name="bend" ref="20"/><geom fromto="0 0 0 0 0 0.3"/>
            <site name="tool_frame" pos="0 0 0.35"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <keyframe><key name="home" qpos="0 0.1 0.9"/></keyframe>
</mujoco>
"""


@dataclass(frozen=True)
class Mjcf:
    """Reads MJCF with MuJoCo."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By the outermost element."""
        first = re.search(rb"<([A-Za-z_]+)", re.sub(rb"<!--.*?-->", b"", head, flags=re.DOTALL))
        return first is not None and first[1] == b"mujoco"

    def read(self, path: Path, arguments: Mapping[str, str], packages: Mapping[str, Path]) -> Description:
        """The arms of the file, without what stands around them."""
        if arguments:
            raise UsageError(f"{path}: an MJCF takes no arguments, {', '.join(arguments)} are given. Leave them out.")
        try:
            require_bounded(path.absolute())
            told = run_apart(__name__, "compiled", str(path.absolute()))
            return Description(**{**told, "warnings": tuple(told["warnings"])})
        except UsageError as error:
            raise UsageError(f"{path}: {str(error).rstrip('.')}.") from error

    def write_example(self, folder: Path) -> Path:
        """An arm of three joints."""
        path = folder / "example.xml"
        path.write_text(EXAMPLE, encoding="utf-8")
        return path


def compiled(path: str) -> dict[str, Any]:
    """What MuJoCo makes of a file, by the names of a `Description`.

    Args:
        path: Absolute, or MuJoCo looks for meshes in the folder of the file within that folder.

    Raises:
        UsageError: MuJoCo refuses it, or it has no arm.
    """
    import mujoco

    try:
        with warnings.catch_warnings(action="ignore"):  # of attributes that are deprecated, and still read
            spec = mujoco.MjSpec.from_file(path)
            model = spec.compile()
    except (ValueError, TypeError, RuntimeError) as error:
        said = " ".join(str(error).split()).removeprefix("XML ").removeprefix("Error: ")
        raise UsageError(f"MuJoCo cannot read it: {said}. Correct it") from error
    placed = {mesh.id: (mesh.refpos, mesh.refquat) for mesh in spec.meshes}
    return _Reading(model, placed).described()


@dataclass(frozen=True)
class _Reading:
    """A compiled model on its way to a URDF.

    Attributes:
        model: A `mujoco.MjModel`.
        placed: Of each mesh, how its file is moved and turned before all else: refpos, refquat.
        warnings: What was left out, a line each.
    """

    model: Any
    placed: Mapping[int, tuple[Float, Float]]
    warnings: list[str] = field(default_factory=list)

    def described(self) -> dict[str, Any]:
        """All of it, by the names of a `Description`.

        Raises:
            UsageError: Nothing in the model moves by a joint.
        """
        robot = Element("robot", name="mjcf")
        SubElement(robot, "link", name=self.links[0])
        for body in self.kept:
            self._add_body(robot, body)
        home = self._home()
        self._tell_what_is_left_out()
        return {
            "urdf": ElementTree.tostring(robot, encoding="unicode"),
            "tip": self._tip(),
            "home": home,
            "home_origin": "the keyframe 'home'" if home else "",
            "speeds": SPEEDS,
            "warnings": tuple(self.warnings),
        }

    @cached_property
    def links(self) -> list[str]:
        """The links' names, by number of the body."""
        names = [self.model.body(number).name or f"body{number}" for number in range(self.model.nbody)]
        return _distinct(names, set())

    @cached_property
    def sites(self) -> list[str]:
        """The names of the links of sites, by number of the site; empty for one without a name."""
        given = [self.model.site(number).name for number in range(self.model.nsite)]
        names = iter(_distinct([name for name in given if name], set(self.links), "_site"))
        return [next(names) if name else "" for name in given]

    @cached_property
    def joints(self) -> list[str]:
        """The joints' names, by number."""
        names = [self.model.joint(number).name or f"joint{number}" for number in range(self.model.njnt)]
        return _distinct(names, set())

    @cached_property
    def kept(self) -> tuple[int, ...]:
        """The bodies of the arms, by number, parents first.

        They hang on a child of the world that holds a joint which turns or slides. Of those that float, objects mostly,
        some are taken only if nothing else moves.

        Raises:
            UsageError: Nothing moves by a joint.
        """
        roots, kinds = self.model.body_rootid, self.model.jnt_type
        movers = {int(roots[self.model.jnt_bodyid[number]]) for number in np.flatnonzero(kinds >= 2)}
        floating = {int(roots[self.model.jnt_bodyid[number]]) for number in np.flatnonzero(kinds == 0)}
        chosen = movers - floating or movers
        if not chosen:
            raise UsageError("Nothing in it turns or slides by a joint. Give the MJCF of an arm.")
        return tuple(number for number in range(1, self.model.nbody) if int(roots[number]) in chosen)

    def _add_body(self, robot: Element, body: int) -> None:
        """The joints between a body's parent and itself, and its link."""
        model = self.model
        link = self.links[body]
        parent, offset = self.links[model.body_parentid[body]], np.zeros(3)
        xyz, rotation = model.body_pos[body], _rotation(model.body_quat[body])
        first, count = model.body_jntadr[body], model.body_jntnum[body]
        moving = [number for number in range(first, first + count) if model.jnt_type[number] != 0]
        if count > len(moving):
            self.warnings.append(f"'{link}' floats in the MJCF; here it is fixed where it begins")
        for number in moving:
            # The link behind a joint that turns has its origin on the axis; all of them are turned as the body is.
            anchor = model.jnt_pos[number] if model.jnt_type[number] != 2 else offset
            is_last = number == moving[-1] and not anchor.any()
            child = link if is_last else f"{link}_behind_{self.joints[number]}"
            step = xyz + rotation @ (anchor - offset)
            robot.append(self._joint(number, parent, child, step, rotation))
            if not is_last:
                SubElement(robot, "link", name=child)
            parent, offset, xyz, rotation = child, anchor, np.zeros(3), np.eye(3)
        if not moving or offset.any():
            _fix(robot, f"{link}_fixed", parent, link, xyz - rotation @ offset, rotation)
        robot.append(self._link(body))
        for site in np.flatnonzero(model.site_bodyid == body):
            if self.sites[site]:
                SubElement(robot, "link", name=self.sites[site])
                pose = model.site_pos[site], _rotation(model.site_quat[site])
                _fix(robot, f"{self.sites[site]}_fixed", link, self.sites[site], *pose)

    def _joint(self, number: int, parent: str, child: str, xyz: Float, rotation: Float) -> Element:
        """One joint: its position counts as MuJoCo's does, which is `ref` where the file has the body."""
        model, axis = self.model, self.model.jnt_axis[number]
        slides = model.jnt_type[number] == 2
        ref = float(model.qpos0[model.jnt_qposadr[number]]) if model.jnt_type[number] >= 2 else 0.0
        if abs(ref) > MOST_REF:
            raise UsageError(
                f"Joint '{self.joints[number]}' has the ref {ref:.3g}, {MOST_REF:g} at most: write a smaller one."
            )
        limited = bool(model.jnt_limited[number])
        kind = {1: "floating", 2: "prismatic", 3: "revolute" if limited else "continuous"}[int(model.jnt_type[number])]
        if slides:
            xyz = xyz - rotation @ axis * ref
        elif ref:
            rotation = rotation @ _turn(axis, -ref)
        joint = Element("joint", name=self.joints[number], type=kind)
        SubElement(joint, "origin", xyz=_text(xyz), rpy=_text(_rpy(rotation)))
        SubElement(joint, "parent", link=parent)
        SubElement(joint, "child", link=child)
        SubElement(joint, "axis", xyz=_text(axis))
        limit = SubElement(joint, "limit", effort="0", velocity=repr(self._speed(number)))
        if limited and kind != "floating":
            lower, upper = model.jnt_range[number]
            limit.attrib |= {"lower": repr(float(lower)), "upper": repr(float(upper))}
        return joint

    def _speed(self, number: int) -> float:
        """The largest speed: that of the command of a motor that is told speeds, if there is one."""
        model = self.model
        for motor in np.flatnonzero(model.actuator_trnid[:, 0] == number):
            told, gear = model.actuator_biasprm[motor], abs(float(model.actuator_gear[motor][0]))
            is_joint, is_speed = model.actuator_trntype[motor] == 0, told[1] == 0.0 and told[2] < 0.0
            if is_joint and is_speed and model.actuator_ctrllimited[motor] and gear:
                return float(np.abs(model.actuator_ctrlrange[motor]).max()) / gear
        return FASTEST

    def _link(self, body: int) -> Element:
        """A body's mass and shapes, in its own frame."""
        model, link = self.model, Element("link", name=self.links[body])
        if model.body_mass[body] > 0.0:
            inertial = SubElement(link, "inertial")
            rotation = _rotation(model.body_iquat[body])
            SubElement(inertial, "origin", xyz=_text(model.body_ipos[body]), rpy=_text(_rpy(rotation)))
            SubElement(inertial, "mass", value=repr(float(model.body_mass[body])))
            ixx, iyy, izz = (repr(float(moment)) for moment in model.body_inertia[body])
            SubElement(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
        for geom in np.flatnonzero(model.geom_bodyid == body).tolist():
            for tag in self._uses(geom):
                shape = self._shape(geom)
                if shape is not None:
                    SubElement(link, tag).extend(shape)
        return link

    def _uses(self, geom: int) -> Iterator[str]:
        """What a shape is for: others can touch it, or it is drawn; a mesh that is touched as its hull is drawn too."""
        model = self.model
        touches = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
        if touches:
            yield "collision"
        if not touches or (model.geom_type[geom] == MESH and model.geom_group[geom] < DRAWN_GROUPS):
            yield "visual"

    def _shape(self, geom: int) -> tuple[Element, Element] | None:
        """The origin and the geometry of a shape; None where a URDF has no such shape, which is told."""
        model, size = self.model, [float(number) for number in self.model.geom_size[geom]]
        xyz, rotation = model.geom_pos[geom], _rotation(model.geom_quat[geom])
        kind, geometry = int(model.geom_type[geom]), Element("geometry")
        if kind == 2:
            SubElement(geometry, "sphere", radius=repr(size[0]))
        elif kind in {3, 5}:
            tag = "capsule" if kind == 3 else "cylinder"
            SubElement(geometry, tag, radius=repr(size[0]), length=repr(2.0 * size[1]))
        elif kind == 6:
            SubElement(geometry, "box", size=_text(2.0 * model.geom_size[geom]))
        elif kind == MESH:
            placed = self._mesh(geom, geometry)
            if placed is None:
                return None
            # The compiled mesh was moved and turned to its own centre; the file was not.
            xyz, rotation = xyz + rotation @ placed[0], rotation @ placed[1]
        else:
            name = {0: "plane", 1: "height field", 4: "ellipsoid", 8: "distance field"}.get(
                kind, "shape of another kind"
            )
            self._leave_out(geom, f"{'an' if name[0] in 'aeiou' else 'a'} {name}")
            return None
        return Element("origin", xyz=_text(xyz), rpy=_text(_rpy(rotation))), geometry

    def _mesh(self, geom: int, geometry: Element) -> tuple[Float, Float] | None:
        """Writes which file a mesh comes from; where and how that lies in the frame of the compiled mesh."""
        model, number = self.model, int(self.model.geom_dataid[geom])
        start, scale = int(model.mesh_pathadr[number]), model.mesh_scale[number]
        path = Path(model.paths[start : model.paths.index(b"\0", start)].decode()) if start >= 0 else None
        moved, turned = self.placed.get(number, (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])))
        first = _rotation(turned).T
        if path is None:
            self._leave_out(geom, "a mesh without a file")
            return None
        try:
            read_mesh(path)
        except UsageError:  # of a format that MuJoCo alone reads
            self._leave_out(geom, f"the mesh {path.name}")
            return None
        if np.ptp(scale) > 0.0 and not np.allclose(first, np.eye(3)):
            self._leave_out(geom, "a mesh that is turned, then scaled unevenly")
            return None
        SubElement(geometry, "mesh", filename=str(path), scale=_text(scale))
        # A point p of the file is the point centre^T (scale first (p - moved) - middle) of the compiled mesh.
        centre, middle = _rotation(model.mesh_quat[number]), model.mesh_pos[number]
        return centre.T @ (-scale * (first @ moved) - middle), centre.T @ first

    def _leave_out(self, geom: int, what: str) -> None:
        line = f"'{self.links[self.model.geom_bodyid[geom]]}' has {what}, which is left out: a URDF has no such shape"
        if line not in self.warnings:
            self.warnings.append(line)

    def _tell_what_is_left_out(self) -> None:
        model = self.model
        around = {int(model.body_rootid[number]) for number in range(1, model.nbody)} - set(self.kept)
        names = [f"'{self.links[number]}'" for number in sorted(around)]
        if names:
            more = f" and {len(names) - NAMED} more" * (len(names) > NAMED)
            self.warnings.append(f"left out, as they are no part of the arm: {', '.join(names[:NAMED])}{more}")
        self.warnings.extend(sorted({line for tie in range(model.neq) for line in self._coupling(tie)}))
        if any(map(self._closes_a_loop, range(model.neq))):
            self.warnings.append(
                "the MJCF ties links of the arm together besides their joints, by connect or weld. Here each joint "
                "moves by itself"
            )

    def _coupling(self, tie: int) -> Iterator[str]:
        """A line where an equality makes joints of the arm, and not only of its gripper, move together."""
        model, joints = self.model, list[int]()
        ends = [int(end) for end in (model.eq_obj1id[tie], model.eq_obj2id[tie]) if end >= 0]
        if model.eq_active0[tie] and model.eq_type[tie] == JOINTS:
            joints = ends
        elif model.eq_active0[tie] and model.eq_type[tie] == TENDONS:
            parts = [range(first, first + model.tendon_num[end]) for end in ends for first in (model.tendon_adr[end],)]
            joints = [int(model.wrap_objid[it]) for part in parts for it in part if model.wrap_type[it] == JOINT_WRAP]
        if any(
            int(model.jnt_bodyid[it]) in self.kept and self._is_on_trunk(int(model.jnt_bodyid[it])) for it in joints
        ):
            names = " and ".join(f"'{self.joints[it]}'" for it in sorted(set(joints)))
            yield f"the MJCF couples {names} by <equality>. Here each joint moves by itself"

    def _closes_a_loop(self, tie: int) -> bool:
        """Whether an equality joins two bodies of the arm, and not only parts of its gripper."""
        model = self.model
        if model.eq_type[tie] not in {0, 1} or not model.eq_active0[tie]:
            return False
        ends = [int(model.eq_obj1id[tie]), int(model.eq_obj2id[tie])]
        if model.eq_objtype[tie] == 6:
            ends = [int(model.site_bodyid[site]) for site in ends]
        return set(ends) <= {0, *self.kept} and any(map(self._is_on_trunk, ends))

    def _is_on_trunk(self, body: int) -> bool:
        """Whether all that moves carries a body or is carried by it."""
        movers = [number for number in self.kept if self.model.body_jntnum[number]]
        ways = {number: set(self._way_to(number)) for number in (body, *movers)}
        return body > 0 and all(body in ways[mover] or mover in ways[body] for mover in movers)

    def _way_to(self, body: int) -> Iterator[int]:
        while body:
            yield body
            body = int(self.model.body_parentid[body])

    def _tip(self) -> str | None:
        """The one site that is called like a tool's frame; None where there is none, or several are."""
        sites = [
            name
            for number, name in enumerate(self.sites)
            if SITE.search(name) and int(self.model.site_bodyid[number]) in self.kept
        ]
        return sites[0] if len(sites) == 1 else None

    def _home(self) -> dict[str, float]:
        """The positions of the joints in the keyframe 'home', within their ranges."""
        model = self.model
        joints = np.flatnonzero(model.jnt_type >= 2).tolist()
        for key in range(model.nkey):
            if model.key(key).name.lower() == "home":
                return {self.joints[number]: self._within(number, model.key_qpos[key]) for number in joints}
        return {}

    def _within(self, number: int, qpos: Float) -> float:
        position = float(qpos[self.model.jnt_qposadr[number]])
        lower, upper = self.model.jnt_range[number] if self.model.jnt_limited[number] else (-math.pi, math.pi)
        within = min(max(position, float(lower)), float(upper))
        if within != position and int(self.model.jnt_bodyid[number]) in self.kept:
            turns = self.model.jnt_type[number] == 3
            told = [f"{math.degrees(it):.4g} deg" if turns else f"{it:.4g} m" for it in (position, within)]
            line = (
                f"the keyframe 'home' puts '{self.joints[number]}' at {told[0]}, beyond its range: {told[1]} is taken"
            )
            self.warnings.append(line)
        return within


def _distinct(names: list[str], taken: set[str], ending: str = "") -> list[str]:
    """The names, each made another one where it comes again."""
    given: list[str] = []
    for name in names:
        free = f"{name}{ending}" if name in taken else name
        while free in taken:
            free += "_"
        taken.add(free)
        given.append(free)
    return given


def _fix(robot: Element, name: str, parent: str, child: str, xyz: Float, rotation: Float) -> None:
    joint = SubElement(robot, "joint", name=name, type="fixed")
    SubElement(joint, "origin", xyz=_text(xyz), rpy=_text(_rpy(rotation)))
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)


def _rotation(quaternion: Float) -> Float:
    """The matrix of a unit quaternion w, x, y, z, (3, 3)."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def _turn(axis: Float, angle: float) -> Float:
    """The rotation by an angle [rad] about a unit vector, (3, 3)."""
    return _rotation(np.array([math.cos(angle / 2.0), *(math.sin(angle / 2.0) * axis)]))


def _rpy(rotation: Float) -> Float:
    """Turns about the fixed x, then y, then z axis, (3,), [rad]; exact also where the pitch is next to 90 degrees."""
    yaw = math.atan2(rotation[1, 0], rotation[0, 0]) if rotation[1, 0] or rotation[0, 0] else 0.0
    rest = _turn(np.array([0.0, 0.0, 1.0]), -yaw) @ rotation
    return np.array([math.atan2(-rest[1, 2], rest[1, 1]), math.atan2(-rest[2, 0], rest[0, 0]), yaw])


def _text(numbers: Float) -> str:
    return " ".join(repr(float(number)) for number in numbers)
