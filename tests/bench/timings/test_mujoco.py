"""What the environment costs on top of MuJoCo."""

import mujoco
import mujoco.rollout
import numpy as np
import pytest

import harness
from harness.record.trace import TraceWriter

pytestmark = pytest.mark.bench


def _recorded_env(tmp_path, simulator: str, num_envs: int):
    env = harness.make_env(simulator, num_envs=num_envs)
    env.recorder = TraceWriter(tmp_path / "trace.parquet", env.robot.dof, env.robot.dof)
    env.reset(seed=0)
    return env


def _actions(steps: int, num_envs: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, (steps, num_envs, 6)).astype(np.float32)


def test_one_env_has_seven_tenths_of_the_bare_loop(tmp_path, require_speed, step_through, amount):
    """Observation, reward and trace on, one env does at least 0.7 of the steps of a bare mj_step(nstep=20) loop.

    0.8 is wanted; 0.72 to 0.76 was measured.
    """
    env, actions = _recorded_env(tmp_path, "mujoco", 1), _actions(amount(1_000, 10), 1)
    model = env.simulation.model
    data = mujoco.MjData(model)
    speeds = 0.3 * actions[:, 0].astype(np.float64)

    def bare() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos = data.act = env.robot.home
        for speed in speeds:
            data.ctrl[:6] = speed
            data.ctrl[6:] = speed
            mujoco.mj_step(model, data, 20)
        assert data.time == pytest.approx(len(speeds) * env.task.control_period)

    require_speed(bare, lambda: step_through(env, actions), at_least=0.7)


def test_64_envs_have_eight_tenths_of_bare_rollout(tmp_path, require_speed, step_through, amount):
    """64 envs on 2 threads do at least 0.8 of the steps of bare mujoco.rollout.

    0.85 is wanted; 0.78 to 0.89 was measured, from run to run.
    """
    env, actions = _recorded_env(tmp_path, "mujoco:threads=2", 64), _actions(amount(40, 2), 64)
    model = env.simulation.model
    full = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
    data = mujoco.MjData(model)
    data.qpos = data.act = env.robot.home
    start = np.zeros(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, start, full)
    thread_data = [mujoco.MjData(model) for _ in range(2)]
    controls = 0.3 * np.concatenate([actions, actions], axis=2).astype(np.float64)

    def bare() -> None:
        states = np.tile(start, (64, 1))
        with mujoco.rollout.Rollout(nthread=2) as rollout:
            for control in controls:
                out, _ = rollout.rollout(model, thread_data, states, control[:, None], nstep=20)
                states = out[:, -1]
        np.testing.assert_allclose(states[:, 0], len(controls) * env.task.control_period)  # the time, [s]

    require_speed(bare, lambda: step_through(env, actions), at_least=0.8)
