"""PyBullet: every arm in a physics client of its own, driven by velocity motors or by torques."""

import weakref
from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
import pybullet
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.arrays import Float, Mask
from harness.authoring.servo_track import ServoTrack, servo_of
from harness.authoring.substeps import Substeps
from harness.robot import Robot
from harness.simulator import State

from ..arms.servo import follow_alone
from ..bullet_arms import Arm, FreeArm, Scene, ServoArm, connect, exact_timestep, set_steps, turn_alone
from ..peer_envs import panda_reach

Count = Annotated[int, Field(gt=0)]


@dataclass(frozen=True)
class PyBullet:
    """Bullet with velocity motors that track a joint ramp.

    Over a control period each motor holds the speed that leads from where the joint is to its target. The motors are
    constraints of the solver: they carry the arm against gravity. With drive=servo each joint has the drive that
    robot.toml describes, a torque in each physics step.
    A client takes about 28 MB of memory, and a process has at most 1,024 of them.
    """

    family: ClassVar[str] = "Bullet"
    later: ClassVar[tuple[str, ...]] = ("drive", "self_collision")
    sources: ClassVar[tuple[str, ...]] = (
        "harness_plugins.bullet_arms",
        "harness_plugins.arms.dry_friction",
        "harness_plugins.arms.servo",
    )
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    iterations: Annotated[Count, Field(description="of the constraint solver per physics step")] = 50
    drive: Annotated[Literal["ideal", "servo"], Field(description="what moves the joints; docs/drives.md")] = "ideal"
    self_collision: Annotated[bool, Field(description="whether links collide with one another")] = False

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "PyBulletSimulation":
        """See `harness.simulator.Simulator`."""
        if self.drive == "servo":
            return PyBulletServoSimulation(self, robot, num_envs, control_period)
        return PyBulletSimulation(self, robot, num_envs, control_period)

    def bare_loop(self, robot: Robot, targets: Float, period: float) -> Callable[[], None]:
        """See `harness.simulator.Simulator`: Bullet's own calls, all substeps of a period in one, for each arm."""
        simulation = self.open(robot, targets.shape[1], period)
        if isinstance(simulation, PyBulletServoSimulation):
            return follow_alone(simulation, targets, period, self.substeps)
        simulation.place(targets[-1])
        speeds = ((targets - np.roll(targets, 1, axis=0)) / period).tolist()

        def run() -> None:
            for row in speeds:
                for arm, speed in zip(simulation.arms, row, strict=True):
                    turn_alone(arm, speed)

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
        self.arms: list[Any] = []
        for _ in range(num_envs):
            self.arms.append(self._build_arm(settings, robot, control_period))
        self._awake = np.ones(num_envs, bool)
        joints = (num_envs, robot.dof)
        self._state = State(np.zeros(joints), np.zeros(joints), np.zeros((num_envs, 3)), np.zeros(num_envs, bool))
        self.place(np.tile(robot.home, (num_envs, 1)))

    def _build_arm(self, settings: PyBullet, robot: Robot, period: float) -> Arm:
        client, collide = self._connect(), settings.self_collision
        return Arm(client, robot, period, settings.substeps, settings.iterations, collide)

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
            set_steps(arm.client, exact_timestep(self._substeps.period, self._substeps.count), steps)
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


class PyBulletServoSimulation(PyBulletSimulation):
    """The same with drives that have limits."""

    def __init__(self, settings: PyBullet, robot: Robot, num_envs: int, control_period: float) -> None:
        self.track = ServoTrack(servo_of(robot), num_envs, control_period / settings.substeps)
        self._free: FreeArm | None = None
        super().__init__(settings, robot, num_envs, control_period)

    def _build_arm(self, settings: PyBullet, robot: Robot, period: float) -> ServoArm:
        if self._free is None:
            self._free = FreeArm(self._connect(), robot, servo_of(robot).armature)
        client, collide = self._connect(), settings.self_collision
        return ServoArm(
            client, robot, servo_of(robot), self._free, period, settings.substeps, settings.iterations, collide
        )

    def reset(self, qpos: Float, mask: Mask) -> State:
        """See `harness.simulator.Simulation`."""
        self.track.reset(qpos, mask)
        return super().reset(qpos, mask)

    def drive(self, qpos: Float, duration: float) -> State:
        """See `harness.simulator.Simulation`."""
        told = self.track.advance(qpos, duration, self._substeps.within(duration))
        for k in np.flatnonzero(self._awake).tolist():
            self.arms[k].follow(told.qpos[:, k], told.qvel[:, k])
            self.arms[k].read(self._state, k)
        return self._state


def _disconnect(clients: list[int]) -> None:
    for client in clients:
        pybullet.disconnect(physicsClientId=client)
