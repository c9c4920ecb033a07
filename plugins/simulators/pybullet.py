"""PyBullet: every arm in a physics client of its own, driven by velocity motors."""

import ctypes
import os
import sys
import tempfile
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import pybullet
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.arrays import Float, Mask
from harness.authoring.substeps import Substeps
from harness.errors import UsageError
from harness.robot import Robot
from harness.simulator import State

from ..peer_envs import panda_reach

Count = Annotated[int, Field(gt=0)]

GRAVITY = -9.81
"""Along z, [m/s^2]."""
FORCE = 1e6
"""Of a motor at most, [N m] or [N]: drives are strong enough, whatever a URDF has as effort."""
LOAD_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER
BASE = -1
"""Bullet's number of the root link."""
DISTANCE, NORMAL_FORCE = 8, 9
"""Their places in a contact point."""


@dataclass(frozen=True)
class PyBullet:
    """Bullet with velocity motors that track a joint ramp.

    Over a control period each motor holds the speed that leads from where the joint is to its target. The motors are
    constraints of the solver: they carry the arm against gravity.
    A client takes about 28 MB of memory, and a process has at most 1,024 of them.
    """

    family: ClassVar[str] = "Bullet"
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    iterations: Annotated[Count, Field(description="of the constraint solver per physics step")] = 50

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "PyBulletSimulation":
        """See `harness.simulator.Simulator`."""
        return PyBulletSimulation(self, robot, num_envs, control_period)

    def bare_loop(self, robot: Robot, targets: Float, period: float) -> Callable[[], None]:
        """See `harness.simulator.Simulator`: Bullet's own calls, all substeps of a period in one, for each arm."""
        simulation = self.open(robot, targets.shape[1], period)
        simulation.place(targets[-1])
        speeds = ((targets - np.roll(targets, 1, axis=0)) / period).tolist()

        def run() -> None:
            for row in speeds:
                for arm, speed in zip(simulation.arms, row, strict=True):
                    _turn_alone(arm, speed)

        return run

    def peer_envs(self) -> Mapping[str, Callable[[], Any]]:
        """See `harness.simulator.Simulator`."""
        return {"PandaReach": panda_reach}


class PyBulletSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, settings: PyBullet, robot: Robot, num_envs: int, control_period: float) -> None:
        self._robot, self._num_envs = robot, num_envs
        self._substeps, self._duration = Substeps(settings.substeps, control_period), control_period
        self._clients: list[int] = []
        self._close = weakref.finalize(self, _disconnect, self._clients)
        self._scene: Scene | None = None
        self.arms = []
        for _ in range(num_envs):
            client = self._connect()
            self.arms.append(Arm(client, robot, control_period, settings.substeps, settings.iterations))
        self._awake = np.ones(num_envs, bool)
        joints = (num_envs, robot.dof)
        self._state = State(np.zeros(joints), np.zeros(joints), np.zeros((num_envs, 3)), np.zeros(num_envs, bool))
        self.place(np.tile(robot.home, (num_envs, 1)))

    def _connect(self) -> int:
        client = connect()
        self._clients.append(client)
        return client

    def reset(self, qpos: Float, mask: Mask) -> State:
        """See `harness.simulator.Simulation`."""
        self._awake |= mask
        for k in np.flatnonzero(mask).tolist():
            self.arms[k].put(qpos[k])
            self.arms[k].read(self._state, k, placed=True)
        return self._state

    def place(self, qpos: Float) -> State:
        """See `harness.simulator.Simulation`."""
        return self.reset(qpos, np.ones(self._num_envs, bool))

    def drive(self, qpos: Float, duration: float) -> State:
        """See `harness.simulator.Simulation`."""
        if duration != self._duration:
            self._set_duration(duration)
        # From where the joints are to their targets: errors cannot add up over periods.
        speeds = ((qpos - self._state.qpos) / duration).tolist()
        for k in np.flatnonzero(self._awake).tolist():
            self.arms[k].turn(speeds[k])
            self.arms[k].read(self._state, k)
        return self._state

    def rest(self, mask: Mask) -> None:
        """See `harness.simulator.Simulation`."""
        self._awake = ~mask

    def _set_duration(self, duration: float) -> None:
        steps = self._substeps.within(duration)
        for arm in self.arms:
            _set_steps(arm.client, exact_timestep(self._substeps.period, self._substeps.count), steps)
        self._duration = duration

    def read(self) -> State:
        """See `harness.simulator.Simulation`."""
        return self._state

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness.simulator.Simulation`."""
        if self._scene is None:
            self._scene = Scene(self._connect(), self._robot)
        return self._scene.frame(self._state.qpos[env], target, width, height)

    def close(self) -> None:
        """See `harness.simulator.Simulation`."""
        self._close()


class Arm:
    """One arm on the ground in the world of one client."""

    def __init__(self, client: int, robot: Robot, period: float, substeps: int, iterations: int) -> None:
        self.client = client
        _set_options(client, period, substeps, iterations)
        self.body = load_body(client, robot, LOAD_FLAGS | pybullet.URDF_IGNORE_VISUAL_SHAPES)
        links, self.joints = _numbers(client, self.body, robot)
        self.forces = [FORCE] * robot.dof
        self.tip = links[robot.end_effector_link]
        self.ground = _add_ground(client, self.body, self.joints)
        pybullet.changeDynamics(self.body, BASE, linearDamping=0.0, angularDamping=0.0, physicsClientId=client)
        self._new = pybullet.saveState(physicsClientId=client)

    def put(self, qpos: Float) -> None:
        """At rest at `qpos`, (dof,), as if the world were new, contacts included."""
        pybullet.restoreState(self._new, physicsClientId=self.client)
        _put(self.client, self.body, self.joints, qpos)

    def turn(self, speeds: list[float]) -> None:
        """Turn the joints at constant `speeds`, (dof,), for one control period."""
        pybullet.setJointMotorControlArray(
            self.body, self.joints, pybullet.VELOCITY_CONTROL,
            targetVelocities=speeds, forces=self.forces, physicsClientId=self.client,
        )  # fmt: skip
        pybullet.stepSimulation(physicsClientId=self.client)

    def read(self, state: State, env: int, placed: bool = False) -> None:
        """Write what holds now into row `env` of `state`; an arm that was `placed` has not moved since."""
        client = self.client
        joints = pybullet.getJointStates(self.body, self.joints, physicsClientId=client)
        state.qpos[env] = [joint[0] for joint in joints]
        state.qvel[env] = [joint[1] for joint in joints]
        tip = pybullet.getLinkState(self.body, self.tip, computeForwardKinematics=1, physicsClientId=client)
        state.end_effector[env] = tip[4]  # the link's frame, not that of its inertia
        pybullet.performCollisionDetection(physicsClientId=client)  # a step ends with the contacts of its beginning
        points = pybullet.getContactPoints(self.body, self.ground, physicsClientId=client)
        state.ground_contact[env] = any(
            # Bullet also tells near misses. One that bears a load is a contact; a placed arm's load is of before.
            point[DISTANCE] <= 0.0 or (point[NORMAL_FORCE] > 0.0 and not placed)
            for point in points
        )


def _turn_alone(arm: Arm, speeds: list[float]) -> None:
    """Bullet's calls for one period of one arm, what is read at its end included."""
    body, client = arm.body, {"physicsClientId": arm.client}
    pybullet.setJointMotorControlArray(
        body, arm.joints, pybullet.VELOCITY_CONTROL, targetVelocities=speeds, forces=arm.forces, **client
    )
    pybullet.stepSimulation(**client)
    pybullet.getJointStates(body, arm.joints, **client)
    pybullet.getLinkState(body, arm.tip, computeForwardKinematics=1, **client)
    pybullet.performCollisionDetection(**client)
    pybullet.getContactPoints(body, arm.ground, **client)


class Scene:
    """A world to look at: ground, arm and target, drawn by Bullet's own software renderer."""

    def __init__(self, client: int, robot: Robot) -> None:
        self.client = client
        self.body = load_body(client, robot, LOAD_FLAGS)
        _, self.joints = _numbers(client, self.body, robot)
        _add_shape(client, [0.0, 0.0, -0.01], pybullet.GEOM_BOX, halfExtents=[3, 3, 0.01], rgbaColor=[0.8, 0.8, 0.8, 1])
        red = [0.85, 0.2, 0.15, 1]
        self.target = _add_shape(client, [0.0, 0.0, 0.0], pybullet.GEOM_SPHERE, radius=0.03, rgbaColor=red)

    def frame(self, qpos: Float, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """The arm at `qpos`, (dof,), and a marker at `target`, (3,), [m]; RGB, (height, width, 3)."""
        client = self.client
        _put(client, self.body, self.joints, qpos)
        pybullet.resetBasePositionAndOrientation(self.target, list(target), [0, 0, 0, 1], physicsClientId=client)
        view = pybullet.computeViewMatrixFromYawPitchRoll([0.4, 0.0, 0.6], 3.0, 40.0, -20.0, 0.0, 2)
        image = pybullet.getCameraImage(
            width, height, view, pybullet.computeProjectionMatrixFOV(45.0, width / height, 0.05, 20.0),
            renderer=pybullet.ER_TINY_RENDERER, physicsClientId=client,
        )  # fmt: skip
        pixels = np.array(image[2], np.uint8).reshape(height, width, 4)  # the array is Bullet's, the copy ours
        return np.ascontiguousarray(pixels[..., :3])


def connect() -> int:
    """A new client without a window.

    Raises:
        UsageError: This process has as many as it can have.
    """
    try:
        return int(pybullet.connect(pybullet.DIRECT))
    except pybullet.error as error:
        raise UsageError(f"PyBullet opens no more clients ({error}): take fewer envs, or another simulator") from error


def load_body(client: int, robot: Robot, flags: int) -> int:
    """The robot's URDF as a body with a fixed base at the origin, links not touching one another.

    Raises:
        UsageError: Bullet cannot load it.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "robot.urdf")
        path.write_text(robot.urdf, encoding="utf-8")
        try:
            with _c_prints_on_stderr():
                return int(pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client))
        except pybullet.error as error:
            raise UsageError(f"PyBullet cannot load the URDF of robot '{robot.name}': {error}") from error


def exact_timestep(period: float, substeps: int) -> float:
    """The duration of a physics step [s], `period / substeps` in single precision.

    Bullet, which computes in double precision, divides a period by the physics step and keeps the rest for later.
    With so few bits the quotient is exact: there is never a rest, and no period depends on those before it.
    """
    return float(np.float32(period / substeps))


def _set_options(client: int, period: float, substeps: int, iterations: int) -> None:
    pybullet.setGravity(0.0, 0.0, GRAVITY, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        numSolverIterations=iterations, deterministicOverlappingPairs=1, physicsClientId=client
    )
    _set_steps(client, exact_timestep(period, substeps), substeps)


def _set_steps(client: int, timestep: float, steps: int) -> None:
    """Let every `stepSimulation` do so many physics steps."""
    pybullet.setPhysicsEngineParameter(fixedTimeStep=timestep * steps, numSubSteps=steps, physicsClientId=client)


def _numbers(client: int, body: int, robot: Robot) -> tuple[dict[str, int], list[int]]:
    """Bullet's numbers of the links by name, and of the driven joints in the robot's order."""
    count = pybullet.getNumJoints(body, physicsClientId=client)
    infos = [pybullet.getJointInfo(body, number, physicsClientId=client) for number in range(count)]
    links = {info[12].decode(): info[0] for info in infos}
    joints = {info[1].decode(): info[0] for info in infos}
    return links, [joints[name] for name in robot.joint_names]


def _add_ground(client: int, body: int, joints: list[int]) -> int:
    """The plane z = 0. What no driven joint moves may stand in it."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    ground = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
    moves = {BASE: False}
    for link in range(pybullet.getNumJoints(body, physicsClientId=client)):  # parents come first
        parent = pybullet.getJointInfo(body, link, physicsClientId=client)[16]
        moves[link] = link in joints or moves[parent]
    for link in (link for link, moving in moves.items() if not moving):
        pybullet.setCollisionFilterPair(body, ground, link, BASE, 0, physicsClientId=client)
    return int(ground)


def _add_shape(client: int, position: list[float], kind: int, **shape: object) -> int:
    """Something to see at `position`, [m], that touches nothing."""
    visual = pybullet.createVisualShape(kind, physicsClientId=client, **shape)
    return int(
        pybullet.createMultiBody(0.0, baseVisualShapeIndex=visual, basePosition=position, physicsClientId=client)
    )


def _put(client: int, body: int, joints: list[int], qpos: Float) -> None:
    for joint, position in zip(joints, qpos, strict=True):
        pybullet.resetJointState(body, joint, position, 0.0, physicsClientId=client)


def _disconnect(clients: list[int]) -> None:
    for client in clients:
        pybullet.disconnect(physicsClientId=client)


@contextmanager
def _c_prints_on_stderr() -> Iterator[None]:
    """What Bullet prints about a file goes to stderr: stdout is for results."""
    if os.name != "posix":
        yield
        return
    sys.stdout.flush()
    flush = ctypes.CDLL(None).fflush
    flush(None)
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        flush(None)
        os.dup2(kept, 1)
        os.close(kept)
