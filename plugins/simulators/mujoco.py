"""MuJoCo: one arm is stepped by itself, several arms by the threads of `mujoco.rollout`."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness import Float, Mask
from harness.robot import Robot
from harness.simulator import State, Substeps, servo_of

from ..mujoco_model import Batch, OneArm, RampFeed, Renderer, ServoFeed, build_model

Count = Annotated[int, Field(gt=0)]


@dataclass(frozen=True)
class Mujoco:
    """MuJoCo, with drives that follow a joint ramp: ideal drives or those of the robot.

    With drive=ideal each joint has two actuators that are fed the joint speed of the period. An integrated-velocity
    servo holds the ramp's position. Its stiffness is I w^2, where I is the diagonal of the joint-space inertia at the
    home pose and w is `bandwidth`. A velocity servo holds the ramp's speed. Its damping is 2 I w, which is critical.
    Gravity is compensated, and the integrator is implicit.

    With drive=servo each joint has the drive that robot.toml describes, with its torque limit, friction, armature and
    latency. `bandwidth` has no effect. The torque of a drive stays the same during a physics step.
    """

    family: ClassVar[str] = "MuJoCo"
    later: ClassVar[tuple[str, ...]] = ("drive", "self_collision")
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="bandwidth w of the joint servos [rad/s]")] = 100.0
    threads: Annotated[Count, Field(description="threads that step a batch of several arms")] = 1
    drive: Annotated[Literal["ideal", "servo"], Field(description="kind of joint drives; see docs/drives.md")] = "ideal"
    self_collision: Annotated[bool, Field(description="whether the arm's links collide with one another")] = False

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "MujocoSimulation":
        return MujocoSimulation(self, robot, num_envs, control_period)

    def build(self, robot: Robot, timestep: float) -> Any:
        """The model of an arm, with physics steps of `timestep` [s]."""
        servo = servo_of(robot) if self.drive == "servo" else None
        return build_model(robot, timestep, self.bandwidth, servo, self.self_collision)


class MujocoSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, settings: Mujoco, robot: Robot, num_envs: int, control_period: float) -> None:
        timestep = control_period / settings.substeps
        self.model = settings.build(robot, timestep)
        self._num_envs = num_envs
        self._substeps = Substeps(settings.substeps, control_period)
        self._renderer = Renderer(self.model, robot)
        self._arms: OneArm | Batch
        self._feed: RampFeed | ServoFeed
        if settings.drive == "servo":
            self._arms = Batch(self.model, num_envs, settings.threads)
            self._feed = ServoFeed(servo_of(robot), num_envs, timestep)
            self.place(np.tile(robot.home, (num_envs, 1)))
        else:
            self._arms = OneArm(self.model) if num_envs == 1 else Batch(self.model, num_envs, settings.threads)
            self._feed = RampFeed(self._arms.held, self._arms.controls)

    def reset(self, qpos: Float, mask: Mask) -> State:
        self._arms.reset(qpos, mask)
        self._feed.reset(qpos, mask)
        return self._arms.read()

    def place(self, qpos: Float) -> State:
        return self.reset(qpos, np.ones(self._num_envs, bool))

    def drive(self, qpos: Float, duration: float) -> State:
        steps = self._substeps.within(duration)
        self._arms.advance(self._feed.controls(qpos, duration, steps), steps)
        return self._arms.read()

    def rest(self, mask: Mask) -> None:
        self._arms.rest(mask)

    def read(self) -> State:
        return self._arms.read()

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        return self._renderer.frame(self.read().qpos[env], target, width, height)

    def close(self) -> None:
        self._renderer.close()
        self._arms.close()
