"""The MuJoCo model of an arm: its URDF with ground, target marker, servos and sensors."""

import re
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from itertools import product
from typing import Any, TypeAlias
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mujoco
import numpy as np

from harness import Float
from harness.errors import UsageError
from harness.robot import Robot, Servo, Shape, read_surface

GREY = [0.7, 0.7, 0.7, 1.0]
"""Red, green, blue and opacity, 0 to 1, of a surface without a colour."""
COLOR = re.compile(r"(\s*(\d+\.?\d*|\.\d+)(?=\s|$)){4}\s*")
"""Matches four numbers with spaces between them."""


Surface: TypeAlias = tuple[Any, Float, list[float]]
"""What is drawn and touches nothing: a mesh, [m], T_link_mesh, (4, 4), and red, green, blue and opacity, 0 to 1."""


def without_meshes(urdf: Element) -> str:
    """The text of a URDF without the shapes that are meshes; the element `urdf` itself is left as it is."""
    robot = deepcopy(urdf)
    for link in robot.iter("link"):
        for shape in [*link.findall("collision"), *link.findall("visual")]:
            if shape.find("geometry/mesh") is not None:
                link.remove(shape)
    return ElementTree.tostring(robot, encoding="unicode")


def add_meshes(spec: mujoco.MjSpec, urdf: Element, link_shapes: Mapping[str, Sequence[Shape]]) -> None:
    """Add the shapes that `without_meshes` left out: convex hulls that collide, and surfaces to be seen.

    Args:
        spec: The arm without meshes.
        urdf: The element `<robot>` of the arm's URDF.
        link_shapes: As in `harness.robot.Robot`.
    """
    bodies = {body.name: body for body in spec.bodies}
    surfaces = _read_surfaces(urdf)
    for link, shapes in link_shapes.items():
        body = bodies.get(link, spec.worldbody)  # the root link has become the world
        for shape in (shape for shape in shapes if shape.kind == "mesh"):
            mesh = _new_mesh(spec, f"collision of link {link}", uservert=shape.points.ravel())
            geom = _add_geom(body, mesh, shape.T_link_shape)
            geom.group = 3 if surfaces[link] else 0  # drawn only if the link has no surface
        for surface in surfaces[link]:
            _add_surface(spec, body, link, surface)


def _read_surfaces(urdf: Element) -> dict[str, list[Surface]]:
    """The surfaces of each link."""
    colors = dict(_colors(urdf))
    return {link.get("name", ""): list(_surfaces(link, colors)) for link in urdf.findall("link")}


def _surfaces(link: Element, colors: dict[str, list[float]]) -> Iterator[Surface]:
    owner = f"Link '{link.get('name')}'"
    for visual in link.findall("visual"):
        if visual.find("geometry/mesh") is not None:
            (mesh, pose), material = read_surface(visual, owner), visual.find("material")
            name = "" if material is None else material.get("name", "")
            yield mesh, pose, colors.get(name, GREY)


def _colors(robot: Element) -> Iterator[tuple[str, list[float]]]:
    """Named materials and their colours: red, green, blue and opacity. A malformed colour is left out."""
    for material in robot.iter("material"):
        color = material.find("color")
        words = "" if color is None else color.get("rgba", "")
        if COLOR.fullmatch(words):
            yield material.get("name", ""), [float(word) for word in words.split()]


def _add_surface(spec: mujoco.MjSpec, body: Any, link: str, surface: Surface) -> None:
    mesh, pose, color = surface
    name = _new_mesh(spec, f"visual of link {link}", uservert=mesh.vertices.ravel(), userface=mesh.faces.ravel())
    spec.mesh(name).inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # the surface may be open
    geom = _add_geom(body, name, pose)
    geom.contype = geom.conaffinity = 0
    geom.group, geom.rgba = 1, color


def _new_mesh(spec: mujoco.MjSpec, what: str, **settings: Any) -> str:
    """Add a mesh, and its name, which MuJoCo's errors tell; a number in it makes it the only one."""
    name = f"{what} (mesh {len(spec.meshes) + 1})"
    spec.add_mesh(name=name, **settings)
    return name


def _add_geom(body: Any, mesh: str, pose: Float) -> Any:
    """Add a mesh to a link, at `pose` in the link's frame, (4, 4), [m]."""
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, pose[:3, :3].ravel())
    return body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, pos=pose[:3, 3], quat=quat)


STIFF = [0.999, 0.999, 0.001, 0.5, 2.0]
"""MuJoCo's ``solimp`` of dry friction: how hard it is. With the default of 0.9 a joint that friction holds creeps."""
GROUND, TARGET, TOUCH, TIP = "harness_ground", "harness_target", "harness_touch", "harness_tip"


def build_model(
    robot: Robot, timestep: float, bandwidth: float, servo: Servo | None = None, self_collision: bool = False
) -> mujoco.MjModel:
    """The robot's URDF with ground, target marker, servos, and sensors: ground contact, then the end effector.

    Without `servo` the drives are ideal: they are strong enough and make up for weight, friction and damping. So the
    model has none of these, and it ignores the URDF's efforts.

    Args:
        robot: The arm.
        timestep: Duration of a physics step, [s].
        bandwidth: Bandwidth of ideal drives, [rad/s].
        servo: Drives with limits, in place of ideal ones. Each joint then has one actuator. It is fed stiffness times
            the reference's position plus damping times its speed, [N m].
        self_collision: Whether links collide with one another.

    Raises:
        UsageError: MuJoCo cannot load the URDF.
    """
    urdf = ElementTree.fromstring(robot.urdf)
    spec = _read_arm(robot, urdf)
    inertia = _inertia_at_home(spec, robot)  # before meshes are added, which take long and have no mass
    add_meshes(spec, urdf, robot.link_shapes)
    _set_contacts(spec)
    _set_options(spec, timestep)
    floor = spec.worldbody
    if self_collision:
        _let_links_collide(spec, robot)
        floor = spec.worldbody.add_body(name=GROUND)  # apart from the base, whose pairs are excluded
    ground = floor.add_geom(name=GROUND, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3, 3, 0.1], contype=0)
    ground.conaffinity, ground.rgba = 1, [0.82, 0.84, 0.86, 1]
    spec.worldbody.add_light(pos=[1.5, -1.5, 3], dir=[-0.4, 0.4, -0.8])
    _add_target(spec)
    if servo is None:
        _add_servos(spec, robot, inertia, bandwidth)
    else:
        _add_limited_servos(spec, robot, servo)
    spec.add_sensor(
        name=TOUCH, type=mujoco.mjtSensor.mjSENS_CONTACT, objtype=mujoco.mjtObj.mjOBJ_GEOM, objname=GROUND,
        intprm=[1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1],
    )  # fmt: skip
    spec.add_sensor(
        name=TIP, type=mujoco.mjtSensor.mjSENS_FRAMEPOS, objtype=mujoco.mjtObj.mjOBJ_XBODY,
        objname=robot.end_effector_link,
    )  # fmt: skip
    return _compile(spec, robot)


def _read_arm(robot: Robot, urdf: Element) -> mujoco.MjSpec:
    """The arm alone, without meshes. Its weight is compensated. Its joints have no friction and no limit of force."""
    try:
        spec = mujoco.MjSpec.from_string(without_meshes(urdf))
    except ValueError as error:
        raise _refusal(robot, error) from error
    spec.compiler.fusestatic = False  # the end effector stays a body
    spec.compiler.discardvisual = False  # so does the marker of the target
    for body in spec.bodies:
        body.gravcomp = 1.0
        for joint in body.joints:
            joint.damping, joint.frictionloss = np.zeros(3), 0.0
            joint.actfrclimited = int(mujoco.mjtLimited.mjLIMITED_FALSE)
    return spec


def _set_contacts(spec: mujoco.MjSpec) -> None:
    """Let links touch the ground but not one another. Shapes that are only drawn touch nothing."""
    for geom in (geom for body in spec.bodies for geom in body.geoms):
        geom.contype, geom.conaffinity = int(bool(geom.contype)), 0


def _let_links_collide(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Let links touch one another, except those that one joint connects and those that touch at the home pose."""
    for geom in (geom for body in spec.bodies for geom in body.geoms):
        geom.contype, geom.conaffinity = 3 * int(geom.contype), 2 * int(geom.contype)
    model = _compile(spec, robot)
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_forward(model, data)
    touching = {_bodies_of(model, contact.geom) for contact in data.contact}
    for first, second in sorted(touching | _neighbours_of_the_base(model)):
        spec.add_exclude(bodyname1=model.body(first).name, bodyname2=model.body(second).name)


def _bodies_of(model: mujoco.MjModel, geoms: Sequence[int]) -> tuple[int, int]:
    first, second = sorted(int(model.geom_bodyid[geom]) for geom in geoms)
    return first, second


def _neighbours_of_the_base(model: mujoco.MjModel) -> set[tuple[int, int]]:
    """Pairs of bodies, by number, that the first joint connects. MuJoCo excludes all other neighbours by itself."""
    welded, parents = model.body_weldid, model.body_parentid
    base = [body for body in range(model.nbody) if not welded[body]]
    first = [body for body in range(model.nbody) if welded[body] and not welded[parents[welded[body]]]]
    return {(min(pair), max(pair)) for pair in product(base, first)}


def _compile(spec: mujoco.MjSpec, robot: Robot) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        raise _refusal(robot, error) from error


def _refusal(robot: Robot, error: ValueError) -> UsageError:
    reason = " ".join(str(error).split())
    return UsageError(f"MuJoCo cannot load the URDF of robot '{robot.name}': {reason}. Correct it there.")


def _set_options(spec: mujoco.MjSpec, timestep: float) -> None:
    spec.option.timestep = timestep
    spec.option.integrator = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    # A step must depend on the state alone, not on the step before. A state with NaN must stay visible.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)


def _add_target(spec: mujoco.MjSpec) -> None:
    marker = spec.worldbody.add_body(name=TARGET, mocap=True)
    marker.add_geom(
        name=TARGET,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[0.03, 0, 0],
        rgba=[0.85, 0.2, 0.15, 1],
        contype=0,
        conaffinity=0,
    )


def _add_servos(spec: mujoco.MjSpec, robot: Robot, inertia: Float, bandwidth: float) -> None:
    """Two actuators per joint: all the position servos first, then the velocity servos."""
    joint = {"trntype": mujoco.mjtTrn.mjTRN_JOINT, "biastype": mujoco.mjtBias.mjBIAS_AFFINE}
    for name, own in zip(robot.joint_names, inertia, strict=True):
        stiffness = own * bandwidth**2
        spec.add_actuator(
            name=f"{name}_position", target=name, dyntype=mujoco.mjtDyn.mjDYN_INTEGRATOR,
            gainprm=[stiffness] + [0] * 9, biasprm=[0, -stiffness] + [0] * 8, **joint,
        )  # fmt: skip
    for name, own in zip(robot.joint_names, inertia, strict=True):
        damping = 2.0 * own * bandwidth
        spec.add_actuator(
            name=f"{name}_speed", target=name, gainprm=[damping] + [0] * 9, biasprm=[0, 0, -damping] + [0] * 7, **joint
        )


def _add_limited_servos(spec: mujoco.MjSpec, robot: Robot, servo: Servo) -> None:
    """One actuator per joint, as `harness.robot.Servo` says, and the armature and friction of each joint."""
    # A drive computes its torque at the beginning of a physics step and holds it, so its damping is not implicit.
    spec.option.integrator = int(mujoco.mjtIntegrator.mjINT_EULER)
    for body in spec.bodies:
        body.gravcomp = float(servo.gravity_compensated)
    for j, name in enumerate(robot.joint_names):
        joint = spec.joint(name)
        joint.armature = servo.armature[j]
        joint.damping, joint.frictionloss = [servo.viscous_friction[j], 0.0, 0.0], servo.dry_friction[j]
        joint.solref_friction, joint.solimp_friction = [2.0 * spec.option.timestep, 1.0], STIFF  # no creeping
        joint.actgravcomp = True  # holding the weight counts towards the limit
        joint.actfrclimited = int(mujoco.mjtLimited.mjLIMITED_TRUE)
        joint.actfrcrange = [-servo.max_torque[j], servo.max_torque[j]]
        spec.add_actuator(
            name=f"{name}_drive", target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE, gainprm=[1] + [0] * 9,
            biasprm=[0, -servo.stiffness[j], -servo.damping[j]] + [0] * 7,
        )  # fmt: skip


def _inertia_at_home(spec: mujoco.MjSpec, robot: Robot) -> Float:
    """Diagonal of the joint-space inertia at the home pose, (dof,), [kg m^2] or [kg]."""
    model = _compile(spec, robot)
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return np.diag(full).copy()
