"""MuJoCo without the harness: what a simulator built on it is timed beside."""

from collections.abc import Callable

import mujoco
import numpy as np

from harness.arrays import Float
from harness.robot.servo import Servo

from .arms import FULL, rest_at
from .feeds import ServoFeed


def servo_controls(targets: Float, period: float) -> Float:
    """What ideal servos are fed along a closed motion, (periods, num_envs, 1, 2 dof): the speeds twice, [rad/s]."""
    speeds = (targets - np.roll(targets, 1, axis=0)) / period
    return np.concatenate([speeds, speeds], axis=-1)[:, :, None]


def limited_servo_controls(servo: Servo, targets: Float, period: float, substeps: int) -> Float:
    """What drives with limits are fed along a closed motion, (periods, num_envs, substeps, dof), [N m]."""
    feed = ServoFeed(servo, targets.shape[1], period / substeps)
    feed.reset(targets[-1], np.ones(targets.shape[1], bool))
    return np.array([feed.controls(qpos, period, substeps) for qpos in targets])


def step_alone(model: mujoco.MjModel, targets: Float, period: float, substeps: int) -> Callable[[], None]:
    """One arm along `targets`, (periods, dof), by one ``mj_step`` per period."""
    data, controls = mujoco.MjData(model), servo_controls(targets[:, None], period)[:, 0, 0]
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
    return _roll_out(model, targets[-1], servo_controls(targets, period), substeps, threads)


def roll_out_servo_alone(
    model: mujoco.MjModel, servo: Servo, targets: Float, period: float, substeps: int, threads: int
) -> Callable[[], None]:
    """The same of arms with limited drives, one alone included; each physics step has controls of its own."""
    controls = limited_servo_controls(servo, targets, period, substeps)
    return _roll_out(model, targets[-1], controls, substeps, threads)


def _roll_out(model: mujoco.MjModel, start: Float, controls: Float, substeps: int, threads: int) -> Callable[[], None]:
    """Arms that rest at `start`, (num_envs, dof), fed `controls`, (periods, num_envs, substeps or 1, nu)."""
    from mujoco import rollout  # by now as `harness_plugins.mujoco_model` imported it

    pool = rollout.Rollout(nthread=min(threads, len(start)))
    data = [mujoco.MjData(model) for _ in range(min(threads, len(start)))]
    states = _states_at(model, start)

    def run() -> None:
        for control in controls:
            out, _ = pool.rollout(model, data, states, control, nstep=substeps)
            states[:] = out[:, -1]

    return run


def _states_at(model: mujoco.MjModel, qpos: Float) -> Float:
    """At rest at `qpos`, (num_envs, dof), the servos holding it."""
    data, states = mujoco.MjData(model), np.zeros((len(qpos), mujoco.mj_stateSize(model, FULL)))
    for state, pose in zip(states, qpos, strict=True):
        rest_at(model, data, pose)
        mujoco.mj_getState(model, data, state, FULL)
    return states
