"""Arms that MuJoCo moves: one arm in MuJoCo's own data, or many by `mujoco.rollout`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness import Float, Mask
from harness.robot import Servo
from harness.simulator import ServoTrack, State

from .engine import mujoco


class RampFeed:
    """Computes the controls of ideal drives: the joints' speeds twice, the same in all physics steps.

    Args:
        held: What the integrating actuators hold, (num_envs, dof); a view.
        controls: Where the speeds are written, (num_envs, 1, 2 dof).
    """

    def __init__(self, held: Float, controls: Float) -> None:
        self._held, self._controls = held, controls
        self._speeds = controls.reshape(len(held), 2, held.shape[1])

    def reset(self, qpos: Float, mask: Mask) -> None:
        """Does nothing: the actuators hold the pose already."""

    def controls(self, qpos: Float, duration: float, steps: int) -> Float:
        """The controls that lead to `qpos`, (num_envs, dof), in `duration` [s]; (num_envs, 1, 2 dof)."""
        # The speeds lead from the positions that the servos hold now, so rounding cannot add up over periods.
        speeds = qpos - self._held
        speeds /= duration
        self._speeds[...] = speeds[:, None]
        return self._controls


class ServoFeed:
    """Computes the controls of drives with limits: in each physics step, the torque that the references alone cause.

    Args:
        servo: The drives.
        num_envs: How many arms.
        timestep: A physics step, [s].
    """

    def __init__(self, servo: Servo, num_envs: int, timestep: float) -> None:
        self._servo, self._track = servo, ServoTrack(servo, num_envs, timestep)

    def reset(self, qpos: Float, mask: Mask) -> None:
        """Begin new references for the arms of `mask`, (num_envs,), which were put at `qpos`, (num_envs, dof)."""
        self._track.reset(qpos, mask)

    def controls(self, qpos: Float, duration: float, steps: int) -> Float:
        """The controls that lead to `qpos`, (num_envs, dof), for `duration` [s]: (num_envs, steps, dof), [N m]."""
        position, speed = self._track.advance(qpos, duration, steps)
        wanted = self._servo.stiffness * position + self._servo.damping * speed
        return np.ascontiguousarray(wanted.swapaxes(0, 1))


FULL = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
"""The parts of a state: time, positions, speeds, and what integrating actuators hold."""


class OneArm:
    """One arm of a model from `build_model`. Its actuators are fed the same in all physics steps of a drive."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        data, seen = self._data, self._data.sensordata  # a view, like all arrays of MjData
        self.held: Float = data.act[None]
        """What integrating actuators hold, (1, na)."""
        self.controls: Float = data.ctrl[None, None]
        """What the actuators are fed, (1, 1, nu)."""
        self._touch = seen[:1]
        self._state = State(data.qpos[None], data.qvel[None], seen[None, 1:], np.zeros(1, bool))

    def reset(self, qpos: Float, mask: Mask) -> None:
        """Put the arm at rest at `qpos`, (1, dof), if `mask`, (1,), says so."""
        if mask[0]:
            rest_at(self._model, self._data, qpos[0])

    def advance(self, controls: Float, steps: int) -> None:
        """Do `steps` physics steps with `controls`, (1, 1, nu).

        The calls are shifted by half a step. So links and contacts are those at the end, not those of one step before.
        """
        model, data = self._model, self._data
        self.controls[...] = controls
        mujoco.mj_step2(model, data)
        if steps > 1:
            mujoco.mj_step(model, data, steps - 1)
        mujoco.mj_step1(model, data)

    def rest(self, mask: Mask) -> None:
        """Does nothing: with one arm it would save no time."""

    def read(self) -> State:
        """The present state."""
        self._state.ground_contact[0] = self._touch[0] > 0.0
        return self._state

    def close(self) -> None:
        """Does nothing: there is nothing to release."""


class Batch:
    """Many arms of a model from `build_model`, or one arm whose controls differ between physics steps."""

    def __init__(self, model: mujoco.MjModel, num_envs: int, threads: int) -> None:
        from mujoco import rollout  # `engine` has imported MuJoCo by now

        n, dof = num_envs, model.nv
        self._model, self._data, self._num_envs = model, mujoco.MjData(model), n
        self._rollout: Any = rollout.Rollout(nthread=min(threads, n))
        self._thread_data = [mujoco.MjData(model) for _ in range(min(threads, n))]
        self._states, self._touch = np.zeros((n, mujoco.mj_stateSize(model, FULL))), np.zeros(n)
        self.held: Float = self._states[:, 1 + 2 * dof :]
        """What integrating actuators hold, (num_envs, na)."""
        self.controls: Float = np.zeros((n, 1, model.nu))
        """What the actuators are fed, (num_envs, 1, nu)."""
        qpos, qvel = self._states[:, 1 : 1 + dof], self._states[:, 1 + dof : 1 + 2 * dof]
        self._state = State(qpos, qvel, np.zeros((n, 3)), np.zeros(n, bool))
        self._outputs: dict[int, dict[str, Float]] = {}  # by the number of physics steps
        self._awake: NDArray[np.intp] = np.arange(n)

    def reset(self, qpos: Float, mask: Mask) -> None:
        """Put the arms of `mask`, (num_envs,), at rest at `qpos`, (num_envs, dof), and wake them."""
        self._awake = np.union1d(self._awake, np.flatnonzero(mask))
        data = self._data
        for k in np.flatnonzero(mask):
            rest_at(self._model, data, qpos[k])
            mujoco.mj_getState(self._model, data, self._states[k], FULL)
            self._touch[k], self._state.end_effector[k] = data.sensordata[0], data.sensordata[1:]

    def advance(self, controls: Float, steps: int) -> None:
        """Do `steps` physics steps with `controls`, (num_envs, steps or 1, nu)."""
        if controls.shape[1] > 1:
            controls = np.concatenate([controls, controls[:, -1:]], axis=1)
        # The result of one more step is dropped: the step that starts from a state computes its links and contacts.
        found, awake = self._roll_out(controls, steps + 1), self._awake
        self._states[awake], seen = found["state"][:, -2], found["sensordata"][:, -1]
        self._touch[awake], self._state.end_effector[awake] = seen[:, 0], seen[:, 1:]

    def _roll_out(self, controls: Float, steps: int) -> dict[str, Float]:
        """States and sensor data of `steps` physics steps of the arms that are awake; valid until the next call."""
        awake = self._awake
        if not awake.size:
            return {name: array[:0] for name, array in self._outputs_of(steps).items()}
        outputs = {name: array[: len(awake)] for name, array in self._outputs_of(steps).items()}
        states = self._states
        if len(awake) < self._num_envs:
            states, controls = states[awake], controls[awake]
        self._rollout.rollout(self._model, self._thread_data, states, controls, nstep=steps, **outputs)
        return outputs

    def _outputs_of(self, steps: int) -> dict[str, Float]:
        """The arrays into which `mujoco.rollout` writes `steps` physics steps. They are allocated once."""
        if steps not in self._outputs:
            self._outputs[steps] = {
                "state": np.zeros((self._num_envs, steps, self._states.shape[1])),
                "sensordata": np.zeros((self._num_envs, steps, self._model.nsensordata)),
            }
        return self._outputs[steps]

    def rest(self, mask: Mask) -> None:
        """Leave the arms of `mask`, (num_envs,), as they are until they are reset."""
        self._awake = np.flatnonzero(~mask)

    def read(self) -> State:
        """The present state."""
        np.greater(self._touch, 0.0, out=self._state.ground_contact)
        return self._state

    def close(self) -> None:
        """Release the threads; a second call does nothing."""
        if self._rollout is not None:
            self._rollout.close()
            self._rollout = None


def rest_at(model: mujoco.MjModel, data: mujoco.MjData, qpos: Float) -> None:
    """Put an arm at rest at `qpos`, (dof,); integrating actuators hold it there."""
    mujoco.mj_resetData(model, data)
    data.qpos = qpos
    if model.na:
        data.act = qpos
    mujoco.mj_forward(model, data)
