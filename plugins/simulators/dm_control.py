"""dm_control: every arm is an environment of dm_control, with a task that drives its joints."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from dm_control.rl import control
from dm_env import specs
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness import Float, Mask
from harness.errors import SimulationDiverged
from harness.robot import Robot
from harness.simulator import State, Substeps, servo_of

from ..mujoco_model import TOUCH, RampFeed, Renderer, ServoFeed, build_model, import_engine

engine = import_engine("dm_control.mujoco")


@dataclass(frozen=True)
class DmControl:
    """dm_control's Physics, with the arm and the servos of simulator `mujoco`.

    With equal settings an arm moves as in `mujoco`, with either kind of drives. A state that dm_control calls invalid
    ends the cell at once.
    """

    family: ClassVar[str] = "MuJoCo"
    later: ClassVar[tuple[str, ...]] = ("drive", "self_collision")
    substeps: Annotated[int, Field(gt=0, description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="bandwidth w of the joint servos [rad/s]")] = 100.0
    drive: Annotated[Literal["ideal", "servo"], Field(description="kind of joint drives; see docs/drives.md")] = "ideal"
    self_collision: Annotated[bool, Field(description="whether the arm's links collide with one another")] = False

    def build(self, robot: Robot, timestep: float) -> Any:
        """The model of an arm, with physics steps of `timestep` [s]. It is the same as in `mujoco`."""
        servo = servo_of(robot) if self.drive == "servo" else None
        return build_model(robot, timestep, self.bandwidth, servo, self.self_collision)

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "DmControlSimulation":
        return DmControlSimulation(self, robot, num_envs, control_period)


class JointRamp(control.Task):  # type: ignore[misc]  # dm_control ships no types
    """A task of dm_control. Its action says where each joint has to be at the end of the period.

    The joints go there at constant speed. Episodes do not end and pay nothing here, because the harness does both.

    Args:
        physics: The physics of the arm.
        robot: The arm.
        duration: The duration of a step, [s].
        steps: The number of physics steps in it.
        feed: Computes the controls of drives with limits; None if the drives are ideal.
    """

    def __init__(self, physics: Any, robot: Robot, duration: float, steps: int, feed: ServoFeed | None) -> None:
        data, named = physics.data, physics.named.data
        self.start = robot.home.copy()
        """Where the next episode starts, (dof,)."""
        self.duration, self.steps = duration, steps
        """The duration of the next step, in [s] and in physics steps."""
        self._robot = robot
        # Views, looked up once: MuJoCo keeps them up to date, and looking up by name in every period is slow.
        self._qpos, self._held = data.qpos, data.act
        self._feed = feed or RampFeed(data.act[None], np.zeros((1, 1, 2 * robot.dof)))
        self._observation = {
            "qpos": data.qpos,
            "qvel": data.qvel,
            "end_effector": named.xpos[robot.end_effector_link],
            "touch": named.sensordata[TOUCH],
        }

    def initialize_episode(self, physics: Any) -> None:
        """Put the arm at rest at `start`, where the servos hold it."""
        self._qpos[:] = self.start
        if len(self._held):
            self._held[:] = self.start
        self._feed.reset(self.start[None], np.ones(1, bool))

    def before_step(self, action: Float, physics: Any) -> None:
        """Feed the actuators.

        If each physics step has controls of its own, this method takes all physics steps but the last. dm_control takes
        the last one.
        """
        (controls,) = self._feed.controls(action[None], self.duration, self.steps)
        for earlier in controls[:-1]:
            physics.set_control(earlier)
            physics.step()
        physics.set_control(controls[-1])

    def action_spec(self, physics: Any) -> Any:
        """Joint positions, (dof,), within the joints' ranges."""
        robot = self._robot
        return specs.BoundedArray((robot.dof,), np.float64, robot.lower, robot.upper, "qpos")

    def get_observation(self, physics: Any) -> dict[str, Float]:
        """The state as views that hold until the next step; `touch`, (1,), counts contacts with the ground."""
        return self._observation

    def get_reward(self, physics: Any) -> float:
        """Always 0: the harness pays."""
        return 0.0


class DmControlSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, settings: DmControl, robot: Robot, num_envs: int, control_period: float) -> None:
        timestep = control_period / settings.substeps
        self._substeps, self._duration = Substeps(settings.substeps, control_period), control_period
        self._servo = servo_of(robot) if settings.drive == "servo" else None
        model = settings.build(robot, timestep)
        self._model, self._renderer = engine.wrapper.MjModel(model), Renderer(model, robot)
        self.arms = [self._open_arm(robot, control_period, settings.substeps) for _ in range(num_envs)]
        self._awake = np.ones(num_envs, bool)
        joints = (num_envs, robot.dof)
        self._state = State(np.zeros(joints), np.zeros(joints), np.zeros((num_envs, 3)), np.zeros(num_envs, bool))
        self.place(np.tile(robot.home, (num_envs, 1)))

    def _open_arm(self, robot: Robot, period: float, substeps: int) -> control.Environment:
        physics = engine.Physics.from_model(self._model)  # all arms share the model, each has its own data
        feed = None if self._servo is None else ServoFeed(self._servo, 1, period / substeps)
        ramp = JointRamp(physics, robot, period, substeps, feed)
        # The legacy order ends with the links and contacts of the last state, not of one physics step before.
        return control.Environment(physics, ramp, n_sub_steps=self._steps_of_one_control(substeps), legacy_step=True)

    def _steps_of_one_control(self, steps: int) -> int:
        """How many of the `steps` physics steps of a drive get the same controls."""
        return steps if self._servo is None else 1

    def reset(self, qpos: Float, mask: Mask) -> State:
        self._awake |= mask
        for k in np.flatnonzero(mask).tolist():
            self.arms[k].task.start[:] = qpos[k]
            self._advance(k, self.arms[k].reset)
        return self._state

    def place(self, qpos: Float) -> State:
        return self.reset(qpos, np.ones(len(self.arms), bool))

    def drive(self, qpos: Float, duration: float) -> State:
        if duration != self._duration:
            self._set_duration(duration)
        for k in np.flatnonzero(self._awake).tolist():
            self._advance(k, self.arms[k].step, qpos[k])
        return self._state

    def rest(self, mask: Mask) -> None:
        self._awake = ~mask

    def _set_duration(self, duration: float) -> None:
        steps = self._substeps.within(duration)
        for arm in self.arms:
            # A second Environment of the same Physics would begin a new episode.
            arm._n_sub_steps = self._steps_of_one_control(steps)
            arm.task.duration, arm.task.steps = duration, steps
        self._duration = duration

    def _advance(self, k: int, call: Any, *action: Float) -> None:
        """Call arm `k`'s `reset` or `step` and copy what it observes."""
        try:
            seen = call(*action).observation
        except control.PhysicsError as error:
            raise SimulationDiverged(f"dm_control stops the arm of env {k}: {error}") from error
        state = self._state
        state.qpos[k], state.qvel[k], state.end_effector[k] = seen["qpos"], seen["qvel"], seen["end_effector"]
        state.ground_contact[k] = seen["touch"][0] > 0.0

    def read(self) -> State:
        return self._state

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        return self._renderer.frame(self._state.qpos[env], target, width, height)

    def close(self) -> None:
        self._renderer.close()
        for arm in self.arms:
            arm.physics.free()
        self.arms = []
