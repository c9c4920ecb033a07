"""MuJoCo: one arm with one C call per control period, many through the threads of `mujoco.rollout`."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.arrays import Float, Mask
from harness.authoring.substeps import Substeps
from harness.robot import Robot
from harness.simulator import State

from ..mujoco_model import Renderer, build_model, mujoco
from ..mujoco_model.alone import FULL, roll_out_alone, step_alone
from ..peer_envs import fetch_reach, panda_reach

Count = Annotated[int, Field(gt=0)]


@dataclass(frozen=True)
class Mujoco:
    """MuJoCo with position servos that track a joint ramp.

    Each joint has two actuators that are fed the period's joint speed: an integrated-velocity servo (stiffness
    I w^2, I the diagonal of the joint-space inertia at the home pose) holds the ramp's position, a velocity servo
    (2 I w, critically damped) its speed. Gravity is compensated, the integrator implicit.
    """

    family: ClassVar[str] = "MuJoCo"
    substeps: Annotated[Count, Field(description="physics steps per control period")] = 20
    bandwidth: Annotated[float, Field(gt=0, description="of the joint servos, w [rad/s]")] = 100.0
    threads: Annotated[Count, Field(description="of a batch of several arms")] = 1

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "MujocoSimulation":
        """See `harness.simulator.Simulator`."""
        return MujocoSimulation(self, robot, num_envs, control_period)

    def bare_loop(self, robot: Robot, targets: Float, period: float) -> Callable[[], None]:
        """See `harness.simulator.Simulator`: ``mj_step``, for a batch `mujoco.rollout`."""
        model = build_model(robot, period / self.substeps, self.bandwidth)
        if targets.shape[1] == 1:
            return step_alone(model, targets[:, 0], period, self.substeps)
        return roll_out_alone(model, targets, period, self.substeps, self.threads)

    def peer_envs(self) -> Mapping[str, Callable[[], Any]]:
        """See `harness.simulator.Simulator`."""
        return {"PandaReach": panda_reach, "FetchReach": fetch_reach}


class MujocoSimulation:
    """See `harness.simulator.Simulation`."""

    def __init__(self, settings: Mujoco, robot: Robot, num_envs: int, control_period: float) -> None:
        self.model = build_model(robot, control_period / settings.substeps, settings.bandwidth)
        n, dof = num_envs, robot.dof
        self._num_envs, self._dof = n, dof
        self._substeps = Substeps(settings.substeps, control_period)
        self._data = data = mujoco.MjData(self.model)
        seen = data.sensordata  # a view, as all of MjData's arrays
        # What the actuators are fed: the joint speeds twice. One arm's are MjData's own.
        self._controls = np.zeros((n, 1, 2 * dof)) if n > 1 else data.ctrl[None, None]
        self._speeds = self._controls.reshape(n, 2, dof)
        self._awake = np.arange(n)
        self._rollout: Any = None
        self._renderer = Renderer(self.model)
        if n == 1:
            self._held, self._touch = data.act[None], seen[:1]
            self._state = State(data.qpos[None], data.qvel[None], seen[None, 1:], np.zeros(1, bool))
        else:
            self._open_rollout(min(settings.threads, n))

    def _open_rollout(self, threads: int) -> None:
        from mujoco import rollout  # by now as `harness_plugins.mujoco_model` imported it

        model, n, dof = self.model, self._num_envs, self._dof
        self._rollout = rollout.Rollout(nthread=threads)
        self._thread_data = [mujoco.MjData(model) for _ in range(threads)]
        states = np.zeros((n, mujoco.mj_stateSize(model, FULL)))  # time, qpos, qvel, act
        self._states, self._touch = states, np.zeros(n)
        self._held = states[:, 1 + 2 * dof : 1 + 3 * dof]  # what the position servos hold
        qpos, qvel = states[:, 1 : 1 + dof], states[:, 1 + dof : 1 + 2 * dof]
        self._state = State(qpos, qvel, np.zeros((n, 3)), np.zeros(n, bool))
        self._outputs: dict[int, dict[str, Float]] = {}  # by the number of physics steps

    def reset(self, qpos: Float, mask: Mask) -> State:
        """See `harness.simulator.Simulation`."""
        data = self._data
        self._awake = np.union1d(self._awake, np.flatnonzero(mask))
        for k in np.flatnonzero(mask):
            mujoco.mj_resetData(self.model, data)
            data.qpos = data.act = qpos[k]
            mujoco.mj_forward(self.model, data)
            if self._rollout is not None:
                mujoco.mj_getState(self.model, data, self._states[k], FULL)
                self._touch[k], self._state.end_effector[k] = data.sensordata[0], data.sensordata[1:]
        return self.read()

    def place(self, qpos: Float) -> State:
        """See `harness.simulator.Simulation`."""
        return self.reset(qpos, np.ones(self._num_envs, bool))

    def drive(self, qpos: Float, duration: float) -> State:
        """See `harness.simulator.Simulation`."""
        # From where the servos hold now to the target: rounding cannot add up over periods.
        np.divide((qpos - self._held)[:, None], duration, out=self._speeds)
        if self._rollout is None:
            self._drive_one(self._substeps.within(duration))
        else:
            self._drive_many(self._substeps.within(duration))
        return self.read()

    def _drive_one(self, steps: int) -> None:
        """So many physics steps, shifted by half a step: links and contacts are those of the end, not of one before."""
        model, data = self.model, self._data
        mujoco.mj_step2(model, data)
        if steps > 1:
            mujoco.mj_step(model, data, steps - 1)
        mujoco.mj_step1(model, data)

    def _drive_many(self, steps: int) -> None:
        self._states[self._awake] = self._roll_out(steps)["state"][:, -1]
        self._look()

    def _look(self) -> None:
        """Links and contacts of the states as they are: what one more physics step, that is forgotten, starts from."""
        awake, seen = self._awake, self._roll_out(1)["sensordata"][:, 0]
        self._touch[awake], self._state.end_effector[awake] = seen[:, 0], seen[:, 1:]

    def _roll_out(self, steps: int) -> dict[str, Float]:
        """What so many physics steps of the arms that are awake bring; valid until the next call."""
        awake = self._awake
        if not awake.size:
            return {name: array[:0] for name, array in self._outputs_of(steps).items()}
        outputs = {name: array[: len(awake)] for name, array in self._outputs_of(steps).items()}
        states, controls = (self._states, self._controls)
        if len(awake) < self._num_envs:
            states, controls = states[awake], controls[awake]
        self._rollout.rollout(self.model, self._thread_data, states, controls, nstep=steps, **outputs)
        return outputs

    def rest(self, mask: Mask) -> None:
        """See `harness.simulator.Simulation`."""
        self._awake = np.flatnonzero(~mask)

    def _outputs_of(self, steps: int) -> dict[str, Float]:
        """Where `mujoco.rollout` writes so many physics steps; allocated once."""
        if steps not in self._outputs:
            self._outputs[steps] = {
                "state": np.zeros((self._num_envs, steps, self._states.shape[1])),
                "sensordata": np.zeros((self._num_envs, steps, self.model.nsensordata)),
            }
        return self._outputs[steps]

    def read(self) -> State:
        """See `harness.simulator.Simulation`."""
        np.greater(self._touch, 0.0, out=self._state.ground_contact)
        return self._state

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness.simulator.Simulation`."""
        return self._renderer.frame(self._state.qpos[env], target, width, height)

    def close(self) -> None:
        """See `harness.simulator.Simulation`."""
        self._renderer.close()
        if self._rollout is not None:
            self._rollout.close()
            self._rollout = None
