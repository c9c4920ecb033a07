"""Drake: every arm in a context and a simulator of its own, driven by velocity servos or by torques."""

import logging
from collections.abc import Callable, Iterator, Set
from contextlib import contextmanager
from functools import partial
from itertools import combinations
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass
from pydrake.geometry import Box, Capsule, CollisionFilterDeclaration, Convex, Cylinder, GeometrySet, HalfSpace, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from harness import Float
from harness.errors import SimulationDiverged, UsageError
from harness.robot import Robot, Servo, Shape
from harness.simulator import State, Substeps, servo_of

from ..arms.apart import ArmsApart
from ..arms.bare_urdf import bare_urdf
from ..arms.dry_friction import DryFriction
from ..arms.self_collision import Pair, pair, pairs_apart
from ..arms.servo import ServoArms

FRICTION = CoulombFriction(1.0, 1.0)
"""Coefficients of friction, static and sliding, of links on the ground and on one another."""


@dataclass(frozen=True)
class Drake:
    """Drake's multibody plant with velocity servos that track a joint ramp.

    Over a control period each servo holds the speed that leads from the joint's present position to its target. Its
    damping is I w, where I is the diagonal of the joint-space inertia at the home pose and w is `bandwidth`. A physics
    step is a step of the SAP contact solver, which takes the servos implicitly. Arms are weightless, because their
    drives make up for gravity. With drive=servo each joint has the drive that robot.toml describes. It applies a torque
    in each physics step, and `bandwidth` has no effect. The harness draws the frames, not Drake.
    """

    family: ClassVar[str] = "Drake"
    later: ClassVar[tuple[str, ...]] = ("drive", "self_collision")
    sources: ClassVar[tuple[str, ...]] = (
        "harness_plugins.arms.apart",
        "harness_plugins.arms.bare_urdf",
        "harness_plugins.arms.dry_friction",
        "harness_plugins.arms.self_collision",
        "harness_plugins.arms.servo",
    )
    substeps: Annotated[int, Field(gt=0, description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="bandwidth w of the joint servos [rad/s]")] = 2000.0
    drive: Annotated[Literal["ideal", "servo"], Field(description="kind of joint drives; see docs/drives.md")] = "ideal"
    self_collision: Annotated[bool, Field(description="whether the arm's links collide with one another")] = False

    def open(self, robot: Robot, num_envs: int, control_period: float) -> ArmsApart | ServoArms:
        substeps, timestep = Substeps(self.substeps, control_period), control_period / self.substeps
        if self.drive == "servo":
            servo = servo_of(robot)
            model = _build_model(robot, timestep, partial(_add_servos, servo=servo), self.self_collision)
            return ServoArms(robot, num_envs, substeps, lambda: ServoArm(model, substeps, servo))
        damping = _inertia_at_home(robot) * self.bandwidth
        model = _build_model(robot, timestep, partial(_add_ideal_drives, damping=damping), self.self_collision)
        return ArmsApart(robot, num_envs, lambda: Arm(model, substeps, damping))


class Model(NamedTuple):
    """What all arms share."""

    diagram: Any
    """The plant and its shapes, as a system."""
    plant: Any
    """The arm and the ground."""
    arm: Any
    """Drake's number of the arm."""
    tip: Any
    """Body of the end effector."""
    shapes: Any
    """Drake's scene graph, which finds collisions."""
    order: NDArray[np.intp]
    """Where each of the robot's joints stands in Drake's positions, (dof,)."""
    ground: Any
    """Drake's number of the ground if links collide with one another, else None."""


class ArmAlone:
    """See `harness_plugins.arms.apart.ArmAlone`."""

    def __init__(self, model: Model, substeps: Substeps) -> None:
        self.model, self._substeps, self._done = model, substeps, 0
        with _unsaid():  # Drake would warn that no soft body can touch the ground
            context = model.diagram.CreateDefaultContext()
        self.simulator = Simulator(model.diagram, context)
        self.context = model.plant.GetMyMutableContextFromRoot(context)
        self._query = model.shapes.get_query_output_port()
        self._shapes_context = model.shapes.GetMyContextFromRoot(context)
        self._torques = model.plant.get_actuation_input_port(model.arm)

    def put(self, qpos: Float) -> None:
        plant, self._done = self.model.plant, 0
        positions = np.empty_like(qpos)
        positions[self.model.order] = qpos
        self.simulator.get_mutable_context().SetTime(0.0)
        plant.SetPositions(self.context, positions)
        plant.SetVelocities(self.context, np.zeros_like(qpos))
        self.simulator.Initialize()

    def _advance(self, steps: int) -> None:
        """Do `steps` physics steps."""
        self._done += steps
        # The end lies between two steps. If it lay on a step, rounding would decide whether that step is done.
        end = (self._done - 0.5) * self._substeps.period / self._substeps.count
        try:
            self.simulator.AdvanceTo(end)
        except RuntimeError as error:
            raise SimulationDiverged(f"Drake stops the arm: {' '.join(str(error).split())}") from error

    def read(self, state: State, env: int) -> None:
        plant, context = self.model.plant, self.context
        state.qpos[env] = plant.GetPositions(context)[self.model.order]
        state.qvel[env] = plant.GetVelocities(context)[self.model.order]
        state.end_effector[env] = plant.EvalBodyPoseInWorld(context, self.model.tip).translation()
        state.ground_contact[env] = self._touches_ground()

    def _touches_ground(self) -> bool:
        query, ground = self._query.Eval(self._shapes_context), self.model.ground
        if ground is None:  # nothing else can be touched
            return bool(query.HasCollisions())
        return any(ground in (each.id_A, each.id_B) for each in query.ComputePointPairPenetration())


class Arm(ArmAlone):
    """See `harness_plugins.arms.apart.Arm`; `damping` is that of the servos, (dof,), [N m s] or [N s/m]."""

    def __init__(self, model: Model, substeps: Substeps, damping: Float) -> None:
        super().__init__(model, substeps)
        self._damping = damping

    def turn(self, speeds: Float, duration: float) -> None:
        self._torques.FixValue(self.context, self._damping * speeds)
        self._advance(self._substeps.within(duration))


class ServoArm(ArmAlone):
    """See `harness_plugins.arms.servo.ServoArm`."""

    def __init__(self, model: Model, substeps: Substeps, servo: Servo) -> None:
        super().__init__(model, substeps)
        self._servo, self._timestep = servo, substeps.period / substeps.count
        self._friction = DryFriction(servo.dry_friction * self._timestep)
        self._viscous, self._entries = (
            np.diag(servo.viscous_friction * self._timestep),
            np.ix_(model.order, model.order),
        )

    def put(self, qpos: Float) -> None:
        super().put(qpos)
        self._friction.forget()

    def follow(self, qpos_ref: Float, qvel_ref: Float) -> None:
        for position, speed in zip(qpos_ref, qvel_ref, strict=True):
            self._torques.FixValue(self.context, self._torque(position, speed))
            self._advance(1)

    def _torque(self, qpos_ref: Float, qvel_ref: Float) -> Float:
        """The torque of the drives and of dry friction, (dof,). Drake itself adds armature and viscous friction."""
        plant, context, order, servo = self.model.plant, self.context, self.model.order, self._servo
        qpos, qvel = plant.GetPositions(context)[order], plant.GetVelocities(context)[order]
        weight = -plant.CalcGravityGeneralizedForces(context)[order]
        driven = servo.torque(qpos, qvel, qpos_ref, qvel_ref, weight)
        load = driven - servo.viscous_friction * qvel - weight - plant.CalcBiasTerm(context)[order]
        mobility = np.linalg.inv(plant.CalcMassMatrix(context)[self._entries] + self._viscous)
        self._friction.slow(qvel + self._timestep * (mobility @ load), mobility)
        torque: Float = driven - self._friction.impulses / self._timestep
        return torque


AddDrives = Callable[[Any, Any, list[Any]], None]
"""A function that gives an arm its drives.

Its arguments are the plant, Drake's number of the arm, and the arm's joints in the robot's order.
"""


def _build_model(robot: Robot, timestep: float, add_drives: AddDrives, self_collision: bool) -> Model:
    builder, plant, shapes, arm = _read_arm(robot, timestep)
    joints = [plant.GetJointByName(name, arm) for name in robot.joint_names]
    add_drives(plant, arm, joints)
    groups = _add_shapes(plant, robot, joints, self_collision)
    ground = plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "ground", FRICTION)
    pairs = pairs_apart(robot.dof) if self_collision else frozenset()
    _part(shapes, groups, pairs)
    plant.Finalize()
    order = np.array([joint.position_start() for joint in joints])
    tip = plant.GetBodyByName(robot.end_effector_link, arm)
    model = Model(builder.Build(), plant, arm, tip, shapes, order, ground if self_collision else None)
    if self_collision:
        _part(shapes, groups, pairs - _touching_at(robot.home, model, groups))
    return model


def _add_ideal_drives(plant: Any, arm: Any, joints: list[Any], damping: Float) -> None:
    for joint, own in zip(joints, damping, strict=True):
        # A torque d v_target and a damping d make a servo of the speed. The solver takes damping implicitly. That is as
        # stable as Drake's own PD controllers, has the same result, and is many times faster.
        joint.set_default_damping(own)
        plant.AddJointActuator(joint.name(), joint)
    plant.set_gravity_enabled(arm, False)


def _add_servos(plant: Any, arm: Any, joints: list[Any], servo: Servo) -> None:
    for joint, viscous, armature in zip(joints, servo.viscous_friction, servo.armature, strict=True):
        joint.set_default_damping(viscous)
        plant.AddJointActuator(joint.name(), joint).set_default_rotor_inertia(armature)  # its gear is 1


def _read_arm(robot: Robot, timestep: float) -> tuple[Any, Any, Any, Any]:
    """A builder, its plant, its scene graph and the arm, welded to the world; without shapes and servos."""
    (text, root), builder = bare_urdf(robot), DiagramBuilder()
    config = MultibodyPlantConfig(
        time_step=timestep, contact_model="point", discrete_contact_approximation="sap", use_sampled_output_ports=False
    )
    with _naming(robot):
        plant, shapes = AddMultibodyPlant(config, builder)
        (arm,) = Parser(plant).AddModelsFromString(text, "urdf")
    if root != "world":  # Drake takes a link of this name for its own world
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root, arm))
    return builder, plant, shapes, arm


def _inertia_at_home(robot: Robot) -> Float:
    """Diagonal of the joint-space inertia at the home pose, (dof,), [kg m^2] or [kg]."""
    _, plant, _, arm = _read_arm(robot, 0.0)
    plant.Finalize()
    order = [plant.GetJointByName(name, arm).position_start() for name in robot.joint_names]
    positions = np.empty(robot.dof)
    positions[order] = robot.home
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, positions)
    inertia: Float = np.diag(plant.CalcMassMatrix(context))[order]
    return inertia


def _add_shapes(plant: Any, robot: Robot, joints: list[Any], with_base: bool) -> list[list[Any]]:
    """Add the shapes of the links, and of the base if `with_base`; Drake's numbers of the shapes, group by group."""
    plant.set_adjacent_bodies_collision_filters(False)  # else the links next to the base miss the ground
    bodies = [plant.world_body(), *(joint.child_body() for joint in joints)]
    groups: list[list[Any]] = [[] for _ in bodies]
    shapes = (robot.base_shapes if with_base else (), *robot.joint_shapes)
    for group, body, carried in zip(groups, bodies, shapes, strict=True):
        for shape in carried:
            pose, name = RigidTransform(shape.T_link_shape), f"shape_{sum(map(len, groups))}"
            group.append(plant.RegisterCollisionGeometry(body, pose, _solid(shape, name), name, FRICTION))
    return groups


def _part(shapes: Any, groups: list[list[Any]], pairs: Set[Pair]) -> None:
    """Let only the groups in `pairs` touch one another. A pair that was excluded before stays excluded."""
    filters = CollisionFilterDeclaration()
    for group in groups:
        filters.ExcludeWithin(GeometrySet(group))
    for one, other in combinations(range(len(groups)), 2):
        if (one, other) not in pairs:
            filters.ExcludeBetween(GeometrySet(groups[one]), GeometrySet(groups[other]))
    shapes.collision_filter_manager().Apply(filters)


def _touching_at(qpos: Float, model: Model, groups: list[list[Any]]) -> set[Pair]:
    """The groups of links that touch one another at `qpos`, (dof,)."""
    owner = {shape: number for number, group in enumerate(groups) for shape in group}
    with _unsaid():
        context = model.diagram.CreateDefaultContext()
    positions = np.empty_like(qpos)
    positions[model.order] = qpos
    model.plant.SetPositions(model.plant.GetMyMutableContextFromRoot(context), positions)
    query = model.shapes.get_query_output_port().Eval(model.shapes.GetMyContextFromRoot(context))
    touching = [(each.id_A, each.id_B) for each in query.ComputePointPairPenetration()]
    return {pair(owner[one], owner[other]) for one, other in touching if model.ground not in (one, other)}


def _solid(shape: Shape, name: str) -> Any:
    if shape.kind == "mesh":
        return Convex(shape.points.T, name)
    return {"box": Box, "cylinder": Cylinder, "capsule": Capsule, "sphere": Sphere}[shape.kind](*shape.size)


@contextmanager
def _unsaid() -> Iterator[None]:
    """Silence Drake's warnings within the block."""
    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(level)


@contextmanager
def _naming(robot: Robot) -> Iterator[None]:
    try:
        yield
    except RuntimeError as error:
        reason = " ".join(str(error).split())
        raise UsageError(f"Drake cannot load the URDF of robot '{robot.name}': {reason}. Correct it there.") from error
