"""PhysX by SAPIEN: every arm in a scene of its own, driven by velocity drives."""

import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.arrays import Float
from harness.authoring.substeps import Substeps
from harness.errors import UsageError
from harness.robot import Robot
from harness.robot.shapes import Shape
from harness.simulator import State

from ..arms_apart import ArmsApart, bare_loop
from ..bare_urdf import bare_urdf

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it warns of graphics drivers, and nothing is drawn by them
    import sapien
    from sapien import physx

Count = Annotated[int, Field(gt=0)]

FRICTION = 1.0
"""Of links on the ground, static and sliding."""
MATERIAL = (FRICTION, FRICTION, 0.0)
GROUND, LINK = [1, 2, 0, 0], [2, 1, 0, 0]
"""Collision groups: what has a bit of the first number touches what has it in its second."""
UPWARDS = [np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0]
"""Turns the x axis, a plane's normal in PhysX and the axis of its capsules and cylinders, to z; a quaternion."""

ROUND = {"cylinder": physx.PhysxCollisionShapeCylinder, "capsule": physx.PhysxCollisionShapeCapsule}
AT_HOME, ALOFT = sapien.Pose(), sapien.Pose([0.0, 0.0, 1000.0])
"""Poses of the base."""
DAMPING = 1e6
"""Of a drive, [N m s] or [N s/m]."""


@dataclass(frozen=True)
class PhysX:
    """PhysX, the engine that Unity simulates with, with velocity drives that track a joint ramp.

    Over a control period each drive holds the speed that leads from where the joint is to its target. Its damping is so
    large that nothing but the ground slows it. Arms are weightless: their drives make up for gravity. PhysX computes in
    single precision. Frames are drawn by the harness, not by SAPIEN.
    """

    family: ClassVar[str] = "PhysX"
    sources: ClassVar[tuple[str, ...]] = ("harness_plugins.arms_apart", "harness_plugins.bare_urdf")
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    iterations: Annotated[Count, Field(le=255, description="of the constraint solver per physics step")] = 16

    def open(self, robot: Robot, num_envs: int, control_period: float) -> ArmsApart:
        """See `harness.simulator.Simulator`."""
        substeps = Substeps(self.substeps, control_period)
        model = Model(robot, control_period / self.substeps, self.iterations)
        probe = Probe(model)
        return ArmsApart(robot, num_envs, lambda: Arm(model, probe, substeps))

    def bare_loop(self, robot: Robot, targets: Float, period: float) -> Callable[[], None]:
        """See `harness.simulator.Simulator`."""
        return bare_loop(self.open(robot, targets.shape[1], period), targets, period)


class Body:
    """The arm on the ground in a new scene.

    Attributes:
        arm: SAPIEN's articulation.
        system: Which steps it.
        joints: Those that are driven, in the robot's order.
        order: Where each of them stands in PhysX's positions, (dof,).
        tip: The end effector's link.
    """

    def __init__(self, model: "Model") -> None:
        self.system = physx.PhysxCpuSystem()
        self.system.timestep = model.timestep
        self._scene = sapien.Scene([self.system])
        self._scene.add_entity(_ground())
        self.arm = model.builder.set_scene(self._scene).build()
        self.arm.set_solver_position_iterations(model.iterations)
        for link in self.arm.links:
            link.disable_gravity = True
            link.linear_damping = link.angular_damping = 0.0
        robot = model.robot
        self.joints = [self.arm.find_joint_by_name(name) for name in robot.joint_names]
        for joint, shapes in zip(self.joints, robot.joint_shapes, strict=True):
            joint.set_drive_property(0.0, DAMPING)
            for shape in shapes:
                joint.child_link.attach(_solid(shape))
        names = [joint.name for joint in self.arm.active_joints]
        self.order = np.array([names.index(name) for name in robot.joint_names])
        self.tip = self.arm.find_link_by_name(robot.end_effector_link)
        self._rest = np.zeros(len(names), np.float32)

    def put(self, positions: NDArray[np.float32]) -> None:
        """At rest at `positions`, (dof,), in PhysX's order."""
        self.arm.set_qpos(positions)
        self.arm.set_qvel(self._rest)

    def points(self) -> Iterator[Any]:
        """Where the arm is near the ground or touches it, found at the beginning of the last step."""
        return (point for contact in self.system.get_contacts() for point in contact.points)


class Model:
    """What all arms share.

    Attributes:
        robot: The arm.
        timestep: Of a physics step, [s].
        iterations: Of the constraint solver.
        builder: SAPIEN's, of the arm without shapes.
    """

    def __init__(self, robot: Robot, timestep: float, iterations: int) -> None:
        self.robot, self.timestep, self.iterations = robot, timestep, iterations
        self.builder = _read_arm(robot)


class Probe:
    """An arm that is never driven, to ask whether it touches the ground at some joint positions.

    PhysX finds contacts at the beginning of a step. Those of where an arm is at the end of one take one more, which the
    probe makes instead of the arm.
    """

    def __init__(self, model: Model) -> None:
        self._body = Body(model)

    def touches(self, positions: NDArray[np.float32]) -> bool:
        """Whether a shape is in the ground at `positions`, (dof,), in PhysX's order."""
        body = self._body
        body.arm.set_root_pose(ALOFT)
        body.system.step()  # PhysX forgets the contacts of the last time
        body.arm.set_root_pose(AT_HOME)
        body.put(positions)
        body.system.step()
        return any(point.separation <= 0.0 for point in body.points())


class Arm:
    """See `harness_plugins.arms_apart.Arm`."""

    def __init__(self, model: Model, probe: Probe, substeps: Substeps) -> None:
        self._model, self._probe, self._substeps = model, probe, substeps
        self._body = Body(model)

    def put(self, qpos: Float) -> None:
        """See `harness_plugins.arms_apart.Arm`."""
        self._body = Body(self._model)  # nothing less makes PhysX forget contacts, and it takes a millisecond
        positions = np.empty(len(qpos), np.float32)
        positions[self._body.order] = qpos
        self._body.put(positions)

    def turn(self, speeds: Float, duration: float) -> None:
        """See `harness_plugins.arms_apart.Arm`."""
        for joint, speed in zip(self._body.joints, speeds.tolist(), strict=True):
            joint.set_drive_velocity_target(speed)
        step = self._body.system.step
        for _ in range(self._substeps.within(duration)):
            step()

    def read(self, state: State, env: int) -> None:
        """See `harness_plugins.arms_apart.Arm`."""
        body = self._body
        positions = body.arm.qpos
        state.qpos[env] = positions[body.order]
        state.qvel[env] = body.arm.qvel[body.order]
        state.end_effector[env] = body.tip.entity_pose.p
        # A contact that bears a load may hover a little.
        is_pressed = any(point.impulse.any() for point in body.points())
        state.ground_contact[env] = is_pressed or self._probe.touches(positions)


def _read_arm(robot: Robot) -> Any:
    """SAPIEN's builder of the arm, its base fixed, without shapes."""
    loader = sapien.Scene([physx.PhysxCpuSystem()]).create_urdf_loader()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "robot.urdf")
        text, _ = bare_urdf(robot)
        path.write_text(text, encoding="utf-8")
        try:
            builder = loader.load_file_as_articulation_builder(str(path))
        except Exception as error:  # whatever its reader meets
            reason = " ".join(str(error).split())
            raise UsageError(f"SAPIEN cannot load the URDF of robot '{robot.name}': {reason}. Correct it.") from error
    for link in builder.link_builders:
        if link.joint_record.joint_type == "revolute":  # a continuous one, whose angle SAPIEN would wrap
            link.joint_record.joint_type = "revolute_unwrapped"
    return builder


def _ground() -> Any:
    """The plane z = 0."""
    plane = physx.PhysxCollisionShapePlane(physx.PhysxMaterial(*MATERIAL))
    plane.local_pose = sapien.Pose(q=UPWARDS)
    plane.set_collision_groups(GROUND)
    body, entity = physx.PhysxRigidStaticComponent(), sapien.Entity()
    body.attach(plane)
    entity.add_component(body)
    return entity


def _solid(shape: Shape) -> Any:
    """What touches the ground, in the frame of a joint's child link."""
    material, pose = physx.PhysxMaterial(*MATERIAL), sapien.Pose(shape.T_link_shape)
    if shape.kind == "mesh":
        solid = physx.PhysxCollisionShapeConvexMesh(shape.points, [1.0, 1.0, 1.0], material)
    elif shape.kind == "box":
        solid = physx.PhysxCollisionShapeBox([edge / 2.0 for edge in shape.size], material)
    elif shape.kind == "sphere":
        solid = physx.PhysxCollisionShapeSphere(*shape.size, material)
    else:
        radius, length = shape.size
        solid = ROUND[shape.kind](radius, length / 2.0, material)
        pose = pose * sapien.Pose(q=UPWARDS)
    solid.local_pose = pose
    solid.set_collision_groups(LINK)
    return solid
