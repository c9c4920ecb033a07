"""One arm as a Gymnasium env: the vector env without its leading axis."""

import gymnasium
import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal

import harness
from harness.env.vector_env import ReachEnv
from tests.refusals import refused

TASK = "fd100-reach:horizon=5"


@pytest.fixture
def env():
    """One arm in MuJoCo."""
    env = ReachEnv(task=TASK)
    yield env
    env.close()


def test_gymnasium_makes_it():
    """`gymnasium.make` gives the env with what it was asked for."""
    env = gymnasium.make("harness/Reach-v0", simulator="mujoco", task=TASK, reward="arp:k2=3")
    assert isinstance(env.unwrapped, ReachEnv)
    assert env.unwrapped.vector_env.task.horizon == 5
    assert env.unwrapped.vector_env.reward.k2 == 3.0
    env.close()


def test_unknown_name_is_a_usage_error():
    """A simulator that there is not is refused in one line with the nearest name."""
    with refused("Did you mean 'mujoco'"):
        gymnasium.make("harness/Reach-v0", simulator="mujco")


def test_it_is_the_vector_env_of_one(env):
    """Seeded alike and told alike, it returns what the vector env returns for its first arm."""
    vector_env = harness.make_env(task=TASK)
    rng = default_rng(0)
    assert_array_equal(env.reset(seed=3)[0], vector_env.reset(seed=3)[0][0])
    for _ in range(4):
        action = rng.uniform(-1.0, 1.0, 6).astype(np.float32)
        one, batch = env.step(action), vector_env.step(action[None])
        assert_array_equal(one[0], batch[0][0])
        assert one[1:4] == (batch[1][0], batch[2][0], batch[3][0])
        assert {name: one[4][name] for name in batch[4]} == {name: values[0] for name, values in batch[4].items()}
    vector_env.close()


def test_plain_python_comes_back(env):
    """Reward, ends and infos are Python's own numbers and truth values."""
    env.reset(seed=0)
    _, reward, terminated, truncated, infos = env.step(np.zeros(6, np.float32))
    assert [type(value) for value in (reward, terminated, truncated)] == [float, bool, bool]
    assert {name: type(value) for name, value in infos.items() if name != "arm"} == {
        "distance": float,
        "reward_shaped": float,
        "is_success": bool,
        "task": float,
    }


def test_episode_ends_once_and_waits(env):
    """At the horizon the episode is truncated and the env waits to be reset."""
    start, _ = env.reset(seed=0)
    ends = [env.step(np.zeros(6, np.float32)) for _ in range(5)]
    assert [taken[3] for taken in ends] == [False] * 4 + [True]
    assert_array_equal(ends[-1][0][18:21], start[18:21])
    assert (env.reset()[0][18:21] != start[18:21]).any()


def test_options_reach_the_vector_env(env):
    """The options of a reset are those of the vector env: unknown ones are ignored, a mask counts."""
    start, _ = env.reset(seed=9, options={"x": 1})
    assert_array_equal(start, env.reset(seed=9)[0])
    assert_array_equal(env.reset(options={"reset_mask": [False]})[0], start)
    with refused("reset_mask"):
        env.reset(options={"reset_mask": [True, False]})


def test_nothing_is_rendered_without_a_mode(env):
    """Without a render mode there is no frame."""
    env.reset(seed=0)
    assert env.render() is None


def test_a_window_is_gymnasiums(env):
    """The env itself opens none: it says how to get one, and what to install."""
    with refused(r"gymnasium\[classic-control\]"):
        ReachEnv(render_mode="human")


def test_gymnasium_finds_no_fault_with_its_frames(egl, run_without_display):
    """Gymnasium's checker passes without a warning in the render mode rgb_array, without a display."""
    code = (
        "import gymnasium, harness\n"
        "from gymnasium.utils.env_checker import check_env\n"
        "env = gymnasium.make('harness/Reach-v0', render_mode='rgb_array')\n"
        "check_env(env.unwrapped)\n"
        "env.reset()\n"
        "assert env.render().shape == (480, 640, 3)\n"
        "env.close()\n"
    )
    # In a process of its own, where every warning is an error.
    done = run_without_display(code, warnings="error")
    assert (done.returncode, done.stderr) == (0, "")
