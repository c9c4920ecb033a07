"""MuJoCo without the harness. `harness bench` compares the speed of the simulators with it."""

from collections.abc import Callable

import mujoco
import numpy as np

from harness.arrays import Float
from harness.robot.servo import Servo

from .arms import FULL, rest_at
from .feeds import ServoFeed


def servo_controls(targets: Float, period: float) -> Float:
    """The controls of ideal servos along a closed motion: the speeds twice, (periods, num_envs, 1, 2 dof), [rad/s].

    `targets` is (periods, num_envs, dof); the last target leads back to the first. `period` is in [s].
    """
    speeds = (targets - np.roll(targets, 1, axis=0)) / period
    return np.concatenate([speeds, speeds], axis=-1)[:, :, None]


def limited_servo_controls(servo: Servo, targets: Float, period: float, substeps: int) -> Float:
    """The controls of drives with limits along a closed motion, (periods, num_envs, substeps, dof), [N m]."""
    feed = ServoFeed(servo, targets.shape[1], period / substeps)
    feed.reset(targets[-1], np.ones(targets.shape[1], bool))
    return np.array([feed.controls(qpos, period, substeps) for qpos in targets])


def step_alone(model: mujoco.MjModel, targets: Float, period: float, substeps: int) -> Callable[[], None]:
    """A function that drives one arm along `targets`, (periods, dof), by one ``mj_step`` per period."""
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
    """A function that drives many arms along `targets`, (periods, num_envs, dof), by a `mujoco.rollout` per period."""
    return _roll_out(model, targets[-1], servo_controls(targets, period), substeps, threads)


def roll_out_servo_alone(
    model: mujoco.MjModel, servo: Servo, targets: Float, period: float, substeps: int, threads: int
) -> Callable[[], None]:
    """The same for arms with limited drives, also for a single arm. Each physics step has controls of its own."""
    controls = limited_servo_controls(servo, targets, period, substeps)
    return _roll_out(model, targets[-1], controls, substeps, threads)


def _roll_out(model: mujoco.MjModel, start: Float, controls: Float, substeps: int, threads: int) -> Callable[[], None]:
    """A function that drives arms from rest at `start`, (num_envs, dof).

    It feeds them `controls`, (periods, num_envs, substeps or 1, nu).
    """
    from mujoco import rollout  # `engine` has imported MuJoCo by now

    pool = rollout.Rollout(nthread=min(threads, len(start)))
    data = [mujoco.MjData(model) for _ in range(min(threads, len(start)))]
    states = _states_at(model, start)

    def run() -> None:
        for control in controls:
            out, _ = pool.rollout(model, data, states, control, nstep=substeps)
            states[:] = out[:, -1]

    return run


def _states_at(model: mujoco.MjModel, qpos: Float) -> Float:
    """MuJoCo's states, one row per arm, of arms at rest at `qpos`, (num_envs, dof), where the servos hold them."""
    data, states = mujoco.MjData(model), np.zeros((len(qpos), mujoco.mj_stateSize(model, FULL)))
    for state, pose in zip(states, qpos, strict=True):
        rest_at(model, data, pose)
        mujoco.mj_getState(model, data, state, FULL)
    return states
