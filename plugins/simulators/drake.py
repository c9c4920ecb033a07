"""Drake: every arm in a context and a simulator of its own, driven by velocity servos."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any, ClassVar, NamedTuple

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

from harness.arrays import Float
from harness.authoring.substeps import Substeps
from harness.errors import SimulationDiverged, UsageError
from harness.robot import Robot
from harness.robot.shapes import Shape
from harness.simulator import State

from ..arms_apart import ArmsApart, bare_loop
from ..bare_urdf import bare_urdf

FRICTION = 1.0
"""Of links on the ground, Coulomb's coefficient."""


@dataclass(frozen=True)
class Drake:
    """Drake's multibody plant with velocity servos that track a joint ramp.

    Over a control period each servo holds the speed that leads from where the joint is to its target. Its damping is
    I w, I the diagonal of the joint-space inertia at the home pose. A physics step is one of the SAP contact solver,
    which takes the servos implicitly. Arms are weightless: their drives make up for gravity. Frames are drawn by the
    harness, not by Drake.
    """

    family: ClassVar[str] = "Drake"
    sources: ClassVar[tuple[str, ...]] = ("harness_plugins.arms_apart", "harness_plugins.bare_urdf")
    substeps: Annotated[int, Field(gt=0, description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="of the joint servos, w [rad/s]")] = 2000.0

    def open(self, robot: Robot, num_envs: int, control_period: float) -> ArmsApart:
        """See `harness.simulator.Simulator`."""
        substeps = Substeps(self.substeps, control_period)
        model = _build_model(robot, control_period / self.substeps, self.bandwidth)
        return ArmsApart(robot, num_envs, lambda: Arm(model, substeps))

    def bare_loop(self, robot: Robot, targets: Float, period: float) -> Callable[[], None]:
        """See `harness.simulator.Simulator`."""
        return bare_loop(self.open(robot, targets.shape[1], period), targets, period)


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
    """Drake's scene graph, which tells collisions."""
    order: NDArray[np.intp]
    """Where each of the robot's joints stands in Drake's positions, (dof,)."""
    damping: Float
    """Of the servos, (dof,), [N m s] or [N s/m]."""


class Arm:
    """See `harness_plugins.arms_apart.Arm`."""

    def __init__(self, model: Model, substeps: Substeps) -> None:
        self.model, self._substeps, self._done = model, substeps, 0
        with _unsaid():  # that no soft body would touch the ground
            context = model.diagram.CreateDefaultContext()
        self.simulator = Simulator(model.diagram, context)
        self.context = model.plant.GetMyMutableContextFromRoot(context)
        self._query = model.shapes.get_query_output_port()
        self._shapes_context = model.shapes.GetMyContextFromRoot(context)
        self._servos = model.plant.get_actuation_input_port(model.arm)

    def put(self, qpos: Float) -> None:
        """See `harness_plugins.arms_apart.Arm`."""
        plant, self._done = self.model.plant, 0
        positions = np.empty_like(qpos)
        positions[self.model.order] = qpos
        self.simulator.get_mutable_context().SetTime(0.0)
        plant.SetPositions(self.context, positions)
        plant.SetVelocities(self.context, np.zeros_like(qpos))
        self.simulator.Initialize()

    def turn(self, speeds: Float, duration: float) -> None:
        """See `harness_plugins.arms_apart.Arm`."""
        self._servos.FixValue(self.context, self.model.damping * speeds)
        self._done += self._substeps.within(duration)
        # Between two steps: on one, rounding would decide whether it is done.
        end = (self._done - 0.5) * self._substeps.period / self._substeps.count
        try:
            self.simulator.AdvanceTo(end)
        except RuntimeError as error:
            raise SimulationDiverged(f"Drake stops the arm: {' '.join(str(error).split())}") from error

    def read(self, state: State, env: int) -> None:
        """See `harness_plugins.arms_apart.Arm`."""
        plant, context = self.model.plant, self.context
        state.qpos[env] = plant.GetPositions(context)[self.model.order]
        state.qvel[env] = plant.GetVelocities(context)[self.model.order]
        state.end_effector[env] = plant.EvalBodyPoseInWorld(context, self.model.tip).translation()
        # The ground is all that the arm's shapes can collide with.
        state.ground_contact[env] = self._query.Eval(self._shapes_context).HasCollisions()


def _build_model(robot: Robot, timestep: float, bandwidth: float) -> Model:
    damping = _inertia_at_home(robot) * bandwidth
    builder, plant, shapes, arm = _read_arm(robot, timestep)
    joints = [plant.GetJointByName(name, arm) for name in robot.joint_names]
    for joint, own in zip(joints, damping, strict=True):
        # A torque d v_target beside a damping d is a servo of the speed. The solver takes damping implicitly, which is
        # as stable as its own PD controllers, with the same result, and many times faster.
        joint.set_default_damping(own)
        plant.AddJointActuator(joint.name(), joint)
    plant.set_gravity_enabled(arm, False)
    _add_shapes(plant, shapes, robot, joints)
    plant.Finalize()
    order = np.array([joint.position_start() for joint in joints])
    tip = plant.GetBodyByName(robot.end_effector_link, arm)
    return Model(builder.Build(), plant, arm, tip, shapes, order, damping)


def _read_arm(robot: Robot, timestep: float) -> tuple[Any, Any, Any, Any]:
    """A builder, its plant, its scene graph and the arm, welded to the world; without shapes and servos."""
    (text, root), builder = bare_urdf(robot), DiagramBuilder()
    config = MultibodyPlantConfig(
        time_step=timestep, contact_model="point", discrete_contact_approximation="sap", use_sampled_output_ports=False
    )
    with _naming(robot):
        plant, shapes = AddMultibodyPlant(config, builder)
        (arm,) = Parser(plant).AddModelsFromString(text, "urdf")
    if root != "world":  # which Drake takes for its own
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


def _add_shapes(plant: Any, shapes: Any, robot: Robot, joints: list[Any]) -> None:
    """The ground, and what the joints move. Links touch the ground, not one another."""
    friction = CoulombFriction(FRICTION, FRICTION)
    links: list[Any] = []
    plant.set_adjacent_bodies_collision_filters(False)  # links beside a base in the ground would not touch it
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "ground", friction)
    for joint, moved in zip(joints, robot.joint_shapes, strict=True):
        for shape in moved:
            body, pose, name = joint.child_body(), RigidTransform(shape.T_link_shape), f"shape_{len(links)}"
            links.append(plant.RegisterCollisionGeometry(body, pose, _solid(shape, name), name, friction))
    shapes.collision_filter_manager().Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(links)))


def _solid(shape: Shape, name: str) -> Any:
    if shape.kind == "mesh":
        return Convex(shape.points.T, name)
    return {"box": Box, "cylinder": Cylinder, "capsule": Capsule, "sphere": Sphere}[shape.kind](*shape.size)


@contextmanager
def _unsaid() -> Iterator[None]:
    """Without Drake's warnings."""
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
