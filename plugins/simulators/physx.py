"""PhysX by SAPIEN: every arm in a scene of its own, driven by velocity drives or by torques."""

import tempfile
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness import Float, Float32
from harness.errors import UsageError
from harness.robot import Robot, Servo, Shape
from harness.simulator import State, Substeps, servo_of

from ..arms.apart import ArmsApart
from ..arms.bare_urdf import bare_urdf
from ..arms.self_collision import Pair, pair, pairs_apart, partners
from ..arms.servo import ServoArms

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # SAPIEN warns of graphics drivers, which nothing here uses
    import sapien
    from sapien import physx

Count = Annotated[int, Field(gt=0)]

FRICTION = 1.0
"""Coefficient of friction of links on the ground, static and sliding."""
MATERIAL = (FRICTION, FRICTION, 0.0)
GROUND, FIRST = [1, 0, 0, 0], 2
"""Collision groups of the ground, and the bit of the base's group.

Two shapes touch if the first number of one has a bit in common with the second number of the other.
"""
UPWARDS = [np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0]
"""A quaternion that turns the x axis to z. In PhysX, x is a plane's normal and the axis of capsules and cylinders."""

ROUND = {"cylinder": physx.PhysxCollisionShapeCylinder, "capsule": physx.PhysxCollisionShapeCapsule}
AT_HOME, ALOFT = sapien.Pose(), sapien.Pose([0.0, 0.0, 1000.0])
"""Poses of the base: where it stands, and 1 km above."""
DAMPING = 1e6
"""Damping of an ideal drive, [N m s] or [N s/m]."""
CREEP = 1e-4
"""Speed at which dry friction has its full torque, [rad/s] or [m/s]. A joint under less load creeps more slowly."""


@dataclass(frozen=True)
class PhysX:
    """PhysX, the engine that Unity simulates with. Velocity drives track a joint ramp.

    Over a control period each drive holds the speed that leads from the joint's present position to its target. Its
    damping is so large that nothing but the ground slows the joint down. Arms are weightless, because their drives make
    up for gravity. PhysX computes in single precision. With drive=servo each joint has the drive that robot.toml
    describes. It applies a torque in each physics step, and PhysX's velocity drive serves as dry friction. The harness
    draws the frames, not SAPIEN.
    """

    family: ClassVar[str] = "PhysX"
    later: ClassVar[tuple[str, ...]] = ("drive", "self_collision")
    sources: ClassVar[tuple[str, ...]] = (
        "harness_plugins.arms.apart",
        "harness_plugins.arms.bare_urdf",
        "harness_plugins.arms.self_collision",
        "harness_plugins.arms.servo",
    )
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    iterations: Annotated[
        Count, Field(le=255, description="iterations of the constraint solver per physics step, at most 255")
    ] = 16
    drive: Annotated[Literal["ideal", "servo"], Field(description="kind of joint drives; see docs/drives.md")] = "ideal"
    self_collision: Annotated[bool, Field(description="whether the arm's links collide with one another")] = False

    def open(self, robot: Robot, num_envs: int, control_period: float) -> ArmsApart | ServoArms:
        substeps, timestep = Substeps(self.substeps, control_period), control_period / self.substeps
        if self.drive == "servo":
            servo = servo_of(robot)
            model = Model(robot, timestep, self.iterations, servo, self.self_collision)
            probe = Probe(model)
            return ServoArms(robot, num_envs, substeps, lambda: ServoArm(model, probe, servo))
        model = Model(robot, timestep, self.iterations, None, self.self_collision)
        probe = Probe(model)
        return ArmsApart(robot, num_envs, lambda: Arm(model, probe, substeps))


class Body:
    """The arm on the ground in a new scene.

    Attributes:
        arm: SAPIEN's articulation.
        system: SAPIEN's physics system, which steps the scene.
        joints: The driven joints, in the robot's order.
        order: Where each of these joints stands in PhysX's positions, (dof,).
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
            link.disable_gravity = model.servo is None
            link.linear_damping = link.angular_damping = 0.0
        robot = model.robot
        self.joints = [self.arm.find_joint_by_name(name) for name in robot.joint_names]
        for group, shapes in enumerate(model.shapes):
            link = self.joints[group - 1].child_link if group else self.arm.root
            for shape in shapes:
                link.attach(_solid(shape, model.masks[group]))
        for number, joint in enumerate(self.joints):
            if model.servo is None:
                joint.set_drive_property(0.0, DAMPING)
            else:
                _add_servo(joint, model.servo, number)
        names = [joint.name for joint in self.arm.active_joints]
        self.order = np.array([names.index(name) for name in robot.joint_names])
        self.tip = self.arm.find_link_by_name(robot.end_effector_link)
        self._rest = np.zeros(len(names), np.float32)

    def put(self, positions: Float32) -> None:
        """Put the arm at rest at `positions`, (dof,), in PhysX's order."""
        self.arm.set_qpos(positions)
        self.arm.set_qvel(self._rest)

    def put_joints(self, qpos: Float) -> None:
        """Put the arm at rest at `qpos`, (dof,), in the robot's order."""
        positions = np.empty(len(qpos), np.float32)
        positions[self.order] = qpos
        self.put(positions)

    def points(self) -> Iterator[Any]:
        """Points at which the arm is near the ground or touches it, as found at the beginning of the last step."""
        return (point for contact in self.system.get_contacts() if _has_ground(contact) for point in contact.points)

    def touching_groups(self) -> set[Pair]:
        """Groups of links that touch one another, as found at the beginning of the last step."""
        touching = [each for each in self.system.get_contacts() if any(spot.separation <= 0.0 for spot in each.points)]
        return {pair(*(_group_of(shape) for shape in each.shapes)) for each in touching if not _has_ground(each)}


class Model:
    """What all arms share.

    Attributes:
        robot: The arm.
        timestep: Duration of a physics step, [s].
        iterations: Iterations of the constraint solver per physics step.
        builder: SAPIEN's builder of the arm, without shapes.
        servo: The drives; None if they are ideal.
        shapes: The shapes of each of the dof + 1 groups of links, see `harness_plugins.arms.self_collision`.
        masks: The collision groups of each of these groups of links, see `GROUND`.
    """

    def __init__(
        self, robot: Robot, timestep: float, iterations: int, servo: Servo | None = None, self_collision: bool = False
    ) -> None:
        self.robot, self.timestep, self.iterations, self.servo = robot, timestep, iterations, servo
        self.builder = _read_arm(robot)
        self.shapes: tuple[tuple[Shape, ...], ...] = ((), *robot.joint_shapes)
        self.masks = _masks(robot.dof, frozenset())
        if self_collision:
            self.shapes = (robot.base_shapes, *robot.joint_shapes)
            self.masks = _masks(robot.dof, pairs_apart(robot.dof))
            self.masks = _masks(robot.dof, pairs_apart(robot.dof) - self._touching_at_home())

    def _touching_at_home(self) -> set[Pair]:
        body = Body(self)
        body.put_joints(self.robot.home)
        body.system.step()
        return body.touching_groups()


class Probe:
    """An arm that is never driven. It says whether an arm at given joint positions touches the ground.

    PhysX finds contacts at the beginning of a step. To find the contacts at the end of a step, one more step is needed.
    The probe takes it in place of the arm.
    """

    def __init__(self, model: Model) -> None:
        self._body = Body(model)

    def touches(self, positions: Float32) -> bool:
        """Whether a shape is in the ground at `positions`, (dof,), in PhysX's order."""
        body = self._body
        body.arm.set_root_pose(ALOFT)
        body.system.step()  # PhysX forgets the contacts of the last time
        body.arm.set_root_pose(AT_HOME)
        body.put(positions)
        body.system.step()
        return any(point.separation <= 0.0 for point in body.points())


class ArmAlone:
    """See `harness_plugins.arms.apart.ArmAlone`."""

    def __init__(self, model: Model, probe: Probe) -> None:
        self._model, self._probe = model, probe
        self._body = Body(model)

    def put(self, qpos: Float) -> None:
        self._body = Body(self._model)  # only a new scene makes PhysX forget contacts; it takes a millisecond
        self._body.put_joints(qpos)

    def read(self, state: State, env: int) -> None:
        body = self._body
        positions = body.arm.qpos
        state.qpos[env] = positions[body.order]
        state.qvel[env] = body.arm.qvel[body.order]
        state.end_effector[env] = body.tip.entity_pose.p
        # A point that bears a load may be a little above the ground.
        is_pressed = any(point.impulse.any() for point in body.points())
        state.ground_contact[env] = is_pressed or self._probe.touches(positions)


class Arm(ArmAlone):
    """See `harness_plugins.arms.apart.Arm`."""

    def __init__(self, model: Model, probe: Probe, substeps: Substeps) -> None:
        super().__init__(model, probe)
        self._substeps = substeps

    def turn(self, speeds: Float, duration: float) -> None:
        for joint, speed in zip(self._body.joints, speeds.tolist(), strict=True):
            joint.set_drive_velocity_target(speed)
        step = self._body.system.step
        for _ in range(self._substeps.within(duration)):
            step()


class ServoArm(ArmAlone):
    """See `harness_plugins.arms.servo.ServoArm`."""

    def __init__(self, model: Model, probe: Probe, servo: Servo) -> None:
        super().__init__(model, probe)
        self._servo = servo

    def follow(self, qpos_ref: Float, qvel_ref: Float) -> None:
        servo, order, arm, step = self._servo, self._body.order, self._body.arm, self._body.system.step
        torque = np.empty(len(order), np.float32)
        for position, speed in zip(qpos_ref, qvel_ref, strict=True):
            qvel = arm.qvel[order].astype(np.float64)
            weight = arm.compute_passive_force(True, False)[order] if servo.gravity_compensated else 0.0
            driven = servo.torque(arm.qpos[order], qvel, position, speed, weight)
            torque[order] = driven - servo.viscous_friction * qvel
            arm.set_qf(torque)
            step()


def _add_servo(joint: Any, servo: Servo, number: int) -> None:
    """Give a joint its armature and its dry friction.

    Dry friction is a drive to speed 0 with a limited force, because PhysX's joint friction grows with the load.
    """
    friction = servo.dry_friction[number]
    joint.set_armature(servo.armature[number : number + 1].astype(np.float32))
    joint.set_friction(0.0)
    joint.set_drive_property(0.0, friction / CREEP, friction, "force")


def _read_arm(robot: Robot) -> Any:
    """SAPIEN's builder of the arm, its base fixed, without shapes."""
    loader = sapien.Scene([physx.PhysxCpuSystem()]).create_urdf_loader()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "robot.urdf")
        text, _ = bare_urdf(robot)
        path.write_text(text, encoding="utf-8")
        try:
            builder = loader.load_file_as_articulation_builder(str(path))
        except Exception as error:  # its reader raises errors of many kinds
            reason = " ".join(str(error).split())
            raise UsageError(f"SAPIEN cannot load the URDF of robot '{robot.name}': {reason}. Correct it.") from error
    for link in builder.link_builders:
        if link.joint_record.joint_type == "revolute":  # a continuous joint, whose angle SAPIEN would wrap
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


def _masks(dof: int, pairs: Iterable[Pair]) -> list[list[int]]:
    """The collision groups of each of the dof + 1 groups of links. The groups in `pairs` may touch one another."""
    masks = []
    for group in range(dof + 1):
        touched = sum(FIRST << other for other in partners(group, pairs))
        masks.append([FIRST << group, touched + (GROUND[0] if group else 0), 0, 0])
    return masks


def _group_of(shape: Any) -> int:
    return int(shape.collision_groups[0]).bit_length() - FIRST.bit_length()


def _has_ground(contact: Any) -> bool:
    return any(shape.collision_groups[0] == GROUND[0] for shape in contact.shapes)


def _solid(shape: Shape, mask: list[int]) -> Any:
    """A shape that collides, in the frame of the link that carries it."""
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
    solid.set_collision_groups(mask)
    return solid
