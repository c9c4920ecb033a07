"""The MuJoCo model of an arm: its URDF with ground, target marker, servos and sensors."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mujoco
import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot import Robot

from .meshes import add_meshes, without_meshes

GROUND, TARGET, TOUCH, TIP = "harness_ground", "harness_target", "harness_touch", "harness_tip"


def build_model(robot: Robot, timestep: float, bandwidth: float) -> mujoco.MjModel:
    """The robot's URDF with ground, target marker, servos, and sensors: ground contact, then the end effector.

    The servos stand for drives that are strong enough and make up for weight, friction and damping: the model has none
    of these, nor the URDF's efforts.

    Raises:
        UsageError: MuJoCo cannot load the URDF.
    """
    urdf = ElementTree.fromstring(robot.urdf)
    spec = _read_arm(robot, urdf)
    inertia = _inertia_at_home(spec, robot)  # before the meshes, which take long and weigh nothing
    add_meshes(spec, urdf, robot.link_shapes)
    _set_contacts(spec)
    _set_options(spec, timestep)
    ground = spec.worldbody.add_geom(name=GROUND, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3, 3, 0.1], contype=0)
    ground.conaffinity, ground.rgba = 1, [0.82, 0.84, 0.86, 1]
    spec.worldbody.add_light(pos=[1.5, -1.5, 3], dir=[-0.4, 0.4, -0.8])
    _add_target(spec)
    _add_servos(spec, robot, inertia, bandwidth)
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
    """The arm alone, without meshes; neither weight nor friction is left to the servos."""
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
    """Let links touch the ground, not one another; what is only there to be seen touches nothing."""
    for geom in (geom for body in spec.bodies for geom in body.geoms):
        geom.contype, geom.conaffinity = int(bool(geom.contype)), 0


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
    # A step must depend on the state alone, not on the step before; and a state that is no number any more must show.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)


def _add_target(spec: mujoco.MjSpec) -> None:
    marker = spec.worldbody.add_body(name=TARGET, mocap=True)
    marker.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.03, 0, 0], rgba=[0.85, 0.2, 0.15, 1], contype=0, conaffinity=0
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


def _inertia_at_home(spec: mujoco.MjSpec, robot: Robot) -> Float:
    """Diagonal of the joint-space inertia at the home pose, (dof,), [kg m^2] or [kg]."""
    model = _compile(spec, robot)
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return np.diag(full).copy()
