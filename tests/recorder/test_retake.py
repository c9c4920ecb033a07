"""Recordings paid by rewards that were written later: the same calls, the same steps, or nothing."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import harness
from harness.errors import UsageError
from harness.record import read_recording
from harness.recorder.env_facts import Columns
from harness.recorder.retake import Retake
from tests.recorder.conftest import recorder, take


def low(observation, action, next_observation, info):
    """Minus the height, and what the action costs."""
    return -float(next_observation[0]) - 0.1 * float(np.sum(np.abs(action)))


class Worst:
    """The lowest height of the episode so far."""

    def reset(self):
        """An episode starts."""
        self.worst = 1.0

    def __call__(self, observation, action, next_observation, info):
        """Look at one more step."""
        self.worst = min(self.worst, float(next_observation[0]))
        return self.worst


REWARDS = {"low": low}
MEASURES = {"worst": Worst()}


def _act(env, steps):
    """Episodes, one of them abandoned, another started with a seed."""
    env.action_space.seed(0)
    env.reset(seed=3)
    for step in range(steps):
        ended = any(env.step(env.action_space.sample())[2:4])
        if ended or step == 30:
            env.reset()
        if step == 70:
            env.reset(seed=9)
    env.close()


def _record(path, name="Pendulum-v1", steps=250, **given):
    _act(
        harness.RecordRewards(
            gymnasium.make(name), path, **{"trained_with": "own", "rewards": {"own": "own"}, "seed": 1, **given}
        ),
        steps,
    )
    return read_recording(path)


def _retake(name="Pendulum-v1", **given):
    return Retake(lambda: gymnasium.make(name, **given), lambda env: Columns(REWARDS, MEASURES, (), ["worst"]))


def test_reward_pays_what_it_would_have_paid(tmp_path):
    """The same numbers as if it had been recorded at once, to the last bit; what was recorded stays."""
    at_once = _record(
        tmp_path / "at-once", rewards={"own": "own", **REWARDS}, behaviour=MEASURES, higher_is_better=["worst"]
    )
    before = _record(tmp_path / "later")
    assert _retake().score(tmp_path / "later") == ()
    later = read_recording(tmp_path / "later")
    assert np.array_equal(later["reward/low"], at_once["reward/low"])
    assert np.array_equal(later["behaviour/worst"], at_once["behaviour/worst"])
    assert np.array_equal(later["reward/own"], before["reward/own"])
    assert (later.facts.higher_is_better, later.facts.sources["reward/low"]) == (
        ("worst",),
        at_once.facts.sources["reward/low"],
    )


def test_episodes_that_the_recorder_cut_are_cut_again(tmp_path):
    """An evaluation with a horizon can be paid later too."""
    told = {"trained_with": "own", "rewards": {"own": "own"}, "episodes": 2, "horizon": 20}
    harness.evaluate_policy(lambda seen: np.zeros(1), "Pendulum-v1", tmp_path, seed=0, **told)
    _retake().score(tmp_path)
    assert len(read_recording(tmp_path)["reward/low"]) == 40


@pytest.mark.parametrize("mode", [gymnasium.vector.AutoresetMode.NEXT_STEP, gymnasium.vector.AutoresetMode.SAME_STEP])
def test_envs_of_a_batch_are_paid_one_by_one(tmp_path, mode):
    """Each env went on by itself, however the batch starts episodes."""

    def record(path, **given):
        envs = recorder([lambda: gymnasium.make("CartPole-v1")] * 3, mode, path, **given)
        envs.action_space.seed(1)
        take(envs, [envs.action_space.sample() for _ in range(90)], mode)
        return read_recording(path)

    at_once = record(tmp_path / "at-once", rewards=REWARDS, behaviour=MEASURES, higher_is_better=["worst"])
    record(tmp_path / "later")
    _retake("CartPole-v1").score(tmp_path / "later")
    later = read_recording(tmp_path / "later")
    assert later["episode"].max() > 1
    assert np.array_equal(later["reward/low"], at_once["reward/low"])
    assert np.array_equal(later["behaviour/worst"], at_once["behaviour/worst"])


def test_several_recorders_of_one_training_are_paid(tmp_path):
    """Each has a file of its own."""
    for number in (0, 1):
        _record(tmp_path / "run", steps=40, number=number)
    _retake().score(tmp_path / "run")
    assert {"scores-0.parquet", "scores-1.parquet"} < {path.name for path in (tmp_path / "run").iterdir()}
    assert not np.isnan(read_recording(tmp_path / "run")["reward/low"]).any()


def test_training_that_went_on_is_paid_to_its_end(tmp_path):
    """What was scored before counts for the steps that there were."""
    _record(tmp_path / "run", steps=40)
    _retake().score(tmp_path / "run")
    _record(tmp_path / "run", steps=40, resume=True)
    assert "low" not in read_recording(tmp_path / "run").rewards
    _retake().score(tmp_path / "run")
    assert len(read_recording(tmp_path / "run")["reward/low"]) == 80


def test_reward_that_fails_costs_itself_alone(tmp_path):
    """It is NaN from that step on, and told; there is no warning."""

    def fails(observation, action, next_observation, info):
        raise KeyError("no such")

    _record(tmp_path / "run", steps=5)
    retake = Retake(lambda: gymnasium.make("Pendulum-v1"), lambda env: Columns({"fails": fails, **REWARDS}, {}))
    assert retake.score(tmp_path / "run") == ("reward_fails fails in episode 0, step 0: KeyError: 'no such'",)
    found = read_recording(tmp_path / "run")
    assert np.isnan(found["reward/fails"]).all()
    assert not np.isnan(found["reward/low"]).any()


def _step_apart(env):
    """An env that answers otherwise from its 20th step on."""

    class Apart(gymnasium.Wrapper[Any, Any, Any, Any]):
        steps = 0

        def step(self, action):
            self.steps += 1
            return super().step(action if self.steps < 20 else -action)

    return Apart(env)


REFUSED = {
    "other physics": (lambda: gymnasium.make("Pendulum-v1", g=9.0), "episode 0, step 0: the environment does not answ"),
    "later": (lambda: _step_apart(gymnasium.make("Pendulum-v1")), "does not answer as it did"),
    "an earlier end": (lambda: gymnasium.make("Pendulum-v1", max_episode_steps=20), "episode 0, step 19: the environm"),
    "another env": (lambda: gymnasium.make("CartPole-v1"), "episode 0, step 0: the environment raises AssertionError"),
}


@pytest.mark.parametrize(("make", "told"), REFUSED.values(), ids=REFUSED)
def test_env_that_answers_otherwise_pays_nothing(tmp_path, make, told):
    """The new reward would be paid for another training."""
    _record(tmp_path / "run")
    with pytest.raises(UsageError, match=told):
        Retake(make, lambda env: Columns(REWARDS, {})).score(tmp_path / "run")
    assert not (tmp_path / "run" / "scores-0.parquet").exists()
    assert "low" not in read_recording(tmp_path / "run").rewards


def test_recording_that_does_not_tell_all_calls_is_refused(tmp_path):
    """With the reason."""
    env = harness.RecordRewards(gymnasium.make("Pendulum-v1"), tmp_path / "run", trained_with="own", rewards={})
    env.reset()
    env.step(env.action_space.sample())
    env.close()
    with pytest.raises(
        UsageError, match="its env was not reset with a seed, so that its actions cannot be taken again"
    ):
        _retake().score(tmp_path / "run")


def test_recording_of_an_earlier_version_is_refused():
    """It has no actions."""
    old = Path(__file__).parents[1] / "compatibility" / "recordings_1" / "loose" / "own-0"
    with pytest.raises(UsageError, match="does not hold the actions of its training"):
        _retake("CartPole-v1").score(old)


def test_steps_are_told_while_they_are_taken(tmp_path):
    """Counted over all envs of the recording."""
    told = []
    _record(tmp_path / "run", steps=7)
    Retake(lambda: gymnasium.make("Pendulum-v1"), lambda env: Columns(REWARDS, {}), told.append).score(tmp_path / "run")
    assert told == [1, 2, 3, 4, 5, 6, 7]
