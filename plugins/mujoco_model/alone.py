"""MuJoCo without the harness: what a simulator built on it is timed beside."""

from collections.abc import Callable

import mujoco
import numpy as np

from harness.arrays import Float

FULL = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)


def servo_controls(targets: Float, period: float) -> Float:
    """What the servos are fed along a closed motion, (periods, num_envs, 2 dof): the joint speeds twice, [rad/s]."""
    speeds = (targets - np.roll(targets, 1, axis=0)) / period
    return np.concatenate([speeds, speeds], axis=-1)


def step_alone(model: mujoco.MjModel, targets: Float, period: float, substeps: int) -> Callable[[], None]:
    """One arm along `targets`, (periods, dof), by one ``mj_step`` per period."""
    data, controls = mujoco.MjData(model), servo_controls(targets, period)
    data.qpos = data.act = targets[-1]

    def run() -> None:
        for control in controls:
            data.ctrl = control
            mujoco.mj_step(model, data, substeps)

    return run


def roll_out_alone(
    model: mujoco.MjModel, targets: Float, period: float, substeps: int, threads: int
) -> Callable[[], None]:
    """Many arms along `targets`, (periods, num_envs, dof), by one `mujoco.rollout` per period."""
    from mujoco import rollout  # by now as `harness_plugins.mujoco_model` imported it

    pool = rollout.Rollout(nthread=min(threads, targets.shape[1]))
    data = [mujoco.MjData(model) for _ in range(min(threads, targets.shape[1]))]
    controls, states = servo_controls(targets, period), _states_at(model, targets[-1])

    def run() -> None:
        for control in controls:
            out, _ = pool.rollout(model, data, states, control[:, None], nstep=substeps)
            states[:] = out[:, -1]

    return run


def _states_at(model: mujoco.MjModel, qpos: Float) -> Float:
    """At rest at `qpos`, (num_envs, dof), the servos holding it."""
    data, states = mujoco.MjData(model), np.zeros((len(qpos), mujoco.mj_stateSize(model, FULL)))
    for state, pose in zip(states, qpos, strict=True):
        data.qpos = data.act = pose
        mujoco.mj_getState(model, data, state, FULL)
    return states
