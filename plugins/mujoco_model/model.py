"""The MuJoCo model of an arm: its URDF with ground, target marker, servos and a sensor for ground contact."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from harness.robot import Robot

Float = NDArray[np.float64]

GROUND, TARGET, TOUCH = "harness_ground", "harness_target", "harness_touch"


def build_model(robot: Robot, timestep: float, bandwidth: float) -> mujoco.MjModel:
    """The robot's URDF with ground, target marker, servos and a sensor for ground contact."""
    spec = mujoco.MjSpec.from_string(robot.urdf)
    spec.compiler.fusestatic = False  # the end effector stays a body
    spec.compiler.discardvisual = False  # so does the marker of the target
    spec.compiler.meshdir = str(robot.folder)
    _set_options(spec, timestep)
    for body in spec.bodies:
        body.gravcomp = 1.0
        for geom in body.geoms:  # touches the ground, not itself
            geom.contype, geom.conaffinity = 1, 0
    ground = spec.worldbody.add_geom(name=GROUND, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3, 3, 0.1], contype=0)
    ground.conaffinity, ground.rgba = 1, [0.82, 0.84, 0.86, 1]
    spec.worldbody.add_light(pos=[1.5, -1.5, 3], dir=[-0.4, 0.4, -0.8])
    _add_target(spec)
    _add_servos(spec, robot, bandwidth)
    spec.add_sensor(
        name=TOUCH, type=mujoco.mjtSensor.mjSENS_CONTACT, objtype=mujoco.mjtObj.mjOBJ_GEOM, objname=GROUND,
        intprm=[1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1],
    )  # fmt: skip
    return spec.compile()


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


def _add_servos(spec: mujoco.MjSpec, robot: Robot, bandwidth: float) -> None:
    """Two actuators per joint: all the position servos first, then the velocity servos."""
    inertia = _inertia_at_home(spec, robot)
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
    """Diagonal of the joint-space inertia at the home pose, (dof,), [kg m^2]."""
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return np.diag(full).copy()
