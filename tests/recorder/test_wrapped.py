"""Wrappers that change what is paid, or observed, stand on one side of the recorder; the other is refused or told."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorWrapper
from gymnasium.wrappers import NormalizeObservation, NormalizeReward, TransformReward

import harness
from harness.errors import UsageError
from harness.record import read_recording
from harness.recorder.recorder import Noted
from tests.recorder.conftest import ACTION, take

REWARDS = {"own": "own", "raw": lambda s, a, n, i: float(n[0])}


class Bonus(gymnasium.RewardWrapper[Any, Any]):
    """Somebody's own reward."""

    def reward(self, reward):
        """One more."""
        return float(reward) + 1.0


def _record(env, path, **given):
    return harness.RecordRewards(env, path, **{"trained_with": "own", "rewards": REWARDS, **given})


@pytest.mark.parametrize("wrap", [NormalizeReward, lambda env: TransformReward(env, lambda pay: 0.01 * pay)])
def test_scaled_pay_inside_is_refused_where_the_recorder_pays(counting, tmp_path, wrap):
    """One reward would be scaled and the other not; the right order is said, and nothing is written."""
    with pytest.raises(UsageError, match=r"Put it outside: \w+Reward\(RecordRewards\(env, \.\.\., pay=True\)\)"):
        _record(gymnasium.wrappers.TimeLimit(wrap(counting()), 3), tmp_path / "run", pay=True)
    assert not (tmp_path / "run").exists()


def test_scaled_pay_outside_scales_every_reward(counting, tmp_path):
    """The recording has both as they are."""
    for trained in REWARDS:
        env = NormalizeReward(_record(counting(), tmp_path / trained, trained_with=trained, pay=True))
        env.reset(seed=0)
        assert abs(float(env.step(ACTION)[1])) > 5  # the first of a normalised stream
        env.close()
        assert read_recording(tmp_path / trained)["reward/own"].tolist() == [1.0]


def test_normalised_pay_of_the_env_is_told(counting, tmp_path):
    """The learner gets it all the same, so nothing is refused."""
    with pytest.warns(Noted, match="NormalizeReward stands inside the recorder: 'own' is in units that change"):
        _record(NormalizeReward(counting()), tmp_path / "run").close()
    assert len(read_recording(tmp_path / "run").facts.notes) == 1


def test_reward_wrapper_of_somebody_is_told(counting, tmp_path):
    """It may be the env's reward itself; where the env pays nothing is to be told."""
    with pytest.warns(Noted, match="Bonus stands inside the recorder: 'own' is what it makes of the pay"):
        _record(Bonus(counting()), tmp_path / "pays", pay=True).close()
    _record(Bonus(counting()), tmp_path / "looks").close()


def test_batch_is_looked_into(tmp_path):
    """At its own wrappers, and at those of its first env."""
    single = gymnasium.make_vec("CartPole-v1", 2, vectorization_mode="sync", wrappers=[NormalizeReward])
    whole = gymnasium.wrappers.vector.NormalizeReward(gymnasium.make_vec("CartPole-v1", 2, vectorization_mode="sync"))
    for envs in (single, whole):
        with pytest.raises(UsageError, match=r"NormalizeReward\(RecordVectorRewards\(env, \.\.\., pay=True\)\)"):
            harness.RecordVectorRewards(envs, tmp_path / "run", trained_with="own", rewards=REWARDS, pay=True)
        envs.close()


def _evaluate(env, path, policy=lambda seen: ACTION):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Noted)
        harness.evaluate_policy(policy, env, path, trained_with="own", seed=0, rewards=REWARDS, episodes=1)
    return read_recording(path).facts.notes


def test_normalisation_that_the_evaluation_lacks_is_told(counting, tmp_path):
    """Where the evaluation lies in the training's folder; with the training's means nothing is told."""
    trained = NormalizeObservation(counting())
    env = _record(trained, tmp_path / "run")
    env.reset(seed=0), env.step(ACTION), env.close()
    (none,) = _evaluate(counting(), tmp_path / "run" / "none")
    assert "those of the evaluation are not" in none
    (fresh,) = _evaluate(NormalizeObservation(counting()), tmp_path / "run" / "fresh")
    assert "goes on with means of its own" in fresh
    right = NormalizeObservation(counting())
    right.obs_rms, right.update_running_mean = trained.obs_rms, False
    assert _evaluate(right, tmp_path / "run" / "right") == ()


def test_policy_of_a_model_that_learned_normalised_observations_is_told(counting, tmp_path):
    """By what stable-baselines3's models say of themselves; one that normalises what it is given is right."""

    class Normalize:
        norm_obs = True

        def normalize_obs(self, seen):
            return seen

    class Model:
        normalize = Normalize()

        def get_vec_normalize_env(self):
            return self.normalize

        def predict(self, seen):
            return ACTION, None

    model = Model()
    (told,) = _evaluate(counting(), tmp_path / "raw", lambda seen: model.predict(seen)[0])
    assert "the model was trained with VecNormalize" in told
    vec = model.get_vec_normalize_env()
    right = _evaluate(counting(), tmp_path / "right", lambda seen: model.predict(vec.normalize_obs(seen))[0])
    assert right == ()


class Vectors(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Pays two numbers a step."""

    def step(self, action):
        """The second one is a cost."""
        seen, paid, *rest = self.env.step(action)
        return seen, np.array([paid, -1.0]), *rest


class VectorsOfBatch(VectorWrapper[Any, Any, Any, Any, Any]):
    """The same of a batch."""

    def step(self, actions):
        """The second one is a cost."""
        seen, paid, *rest = self.env.step(actions)
        return seen, np.column_stack([paid, -paid]), *rest


@pytest.mark.parametrize("trained_with", ["own", "seen"])
@pytest.mark.parametrize("is_batch", [False, True])
def test_env_that_pays_vectors_is_told_in_one_line(counting, tmp_path, is_batch, trained_with):
    """What functions say goes on being recorded."""
    rewards = {"seen": lambda o, a, n, i: float(n[0])}
    if is_batch:
        inner = VectorsOfBatch(SyncVectorEnv([lambda: counting(9, fresh=True)] * 2))
        env: Any = harness.RecordVectorRewards(inner, tmp_path, trained_with=trained_with, rewards=rewards)
    else:
        env = harness.RecordRewards(Vectors(counting(9)), tmp_path, trained_with=trained_with, rewards=rewards)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        take(env, [np.zeros_like(env.action_space.sample())] * 3, AutoresetMode.NEXT_STEP if is_batch else None)
    assert "the env pays 2 numbers a step, and a reward is one" in str(told[0].message)
    assert len(told) == 1
    found = read_recording(tmp_path)
    assert sorted(set(found["reward/seen"].tolist())) == [1.0, 2.0, 3.0]
    assert trained_with == "seen" or np.isnan(found["reward/own"]).all()
