"""A callback records what a model of stable-baselines3 learns from, without a wrapper."""

from pathlib import Path

import gymnasium
import pytest
from numpy.testing import assert_array_equal
from stable_baselines3 import A2C, DQN
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor, VecNormalize

from harness.record import read_recording
from harness_plugins.sb3 import WatchCallback

LEAN = {"lean": lambda step: abs(float(step.observation[2]))}


def recorded(folder):
    """A recording, and its rows."""
    training = read_recording(Path(folder))
    return training, training.rows(training.names)


@pytest.mark.parametrize("learner", [A2C, DQN])
def test_every_step_is_recorded_as_a_wrapper_records_it(learner, tmp_path):
    """Pay, measure and ends are those that RecordRewards writes of the same training."""
    from harness import RecordRewards

    wrapped = RecordRewards(
        gymnasium.make("CartPole-v1"),
        tmp_path / "wrapped",
        trained_with="own",
        rewards={},
        behaviour=LEAN,
        lower_is_better=["lean"],
    )
    learner("MlpPolicy", wrapped, seed=0).learn(300)
    wrapped.close()
    callback = WatchCallback(tmp_path / "called", behaviour=LEAN, lower_is_better=["lean"], watch=False)
    learner("MlpPolicy", gymnasium.make("CartPole-v1"), seed=0).learn(300, callback=callback)
    (_, expected), (training, found) = recorded(tmp_path / "wrapped"), recorded(tmp_path / "called")
    assert training.facts.seed == 0
    assert training.facts.closed
    for name in ("episode", "step", "reward/own", "behaviour/lean", "terminated", "truncated"):
        assert_array_equal(found[name], expected[name][: len(found[name])])
    assert len(found["step"]) >= 300


def test_normalised_training_is_recorded_in_the_units_of_its_environment(tmp_path):
    """CartPole pays 1 a step; the learner is given something else."""
    envs = VecNormalize(VecMonitor(DummyVecEnv([lambda: gymnasium.make("CartPole-v1")] * 2)))
    A2C("MlpPolicy", envs, seed=0).learn(
        400, callback=WatchCallback(tmp_path, behaviour=LEAN, lower_is_better=["lean"], watch=False)
    )
    training, rows = recorded(tmp_path)
    assert training.facts.num_envs == 2
    assert set(rows["reward/own"]) == {1.0}
    ended = rows["terminated"].astype(bool)
    assert (rows["behaviour/lean"][ended] > 0.2).any()  # it fell: 12 degrees, in radians, before the reset
    assert rows["behaviour/lean"].max() < 0.5


def test_learning_that_goes_on_is_recorded_into_the_same_folder(tmp_path):
    """A second call of learn follows on the first."""
    callback = WatchCallback(tmp_path, behaviour=LEAN, lower_is_better=["lean"], watch=False)
    model = A2C("MlpPolicy", gymnasium.make("CartPole-v1"), seed=0)
    model.learn(100, callback=callback)
    model.learn(100, callback=callback, reset_num_timesteps=False)
    assert len(recorded(tmp_path)[1]["step"]) == 200
