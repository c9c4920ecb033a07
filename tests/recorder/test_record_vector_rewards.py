"""`harness.RecordVectorRewards`: what it records is what single envs record, in each way of starting episodes."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Dict, Discrete
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import TransformAction

import harness
from harness.errors import UsageError
from harness.record import read_recording
from tests.recorder.conftest import take

LENGTHS = (3, 2)
CALLS = 9


GIVEN = {"trained_with": "own", "rewards": {}}


@pytest.fixture
def make_batch(counting):
    """Two counting envs, of other lengths."""

    def make(mode):
        return SyncVectorEnv(
            [lambda length=length: counting(length, fresh=True) for length in LENGTHS], autoreset_mode=mode
        )

    return make


@pytest.fixture
def recorded(make_batch, tmp_path):
    """What is recorded of such a batch."""

    def record(calls=CALLS, **given):
        mode = AutoresetMode.SAME_STEP
        envs = harness.RecordVectorRewards(make_batch(mode), tmp_path / "batch", **{**GIVEN, **given})
        take(envs, np.zeros((calls, 2, 1), np.float32), mode)
        return read_recording(tmp_path / "batch")

    return record


@pytest.mark.parametrize("mode", AutoresetMode)
def test_envs_are_left_as_they_are(make_batch, tmp_path, mode):
    """The same observations, payments, ends and infos."""
    bare, recorded = make_batch(mode), harness.RecordVectorRewards(make_batch(mode), tmp_path, **GIVEN)
    assert np.array_equal(bare.reset(seed=1)[0], recorded.reset(seed=1)[0])
    actions = np.zeros((2, 1), np.float32)
    for _ in range(2):  # no episode has ended before the second step
        one, other = bare.step(actions), recorded.step(actions)
        assert str(one) == str(other)
    assert recorded.spec is recorded.env.spec
    recorded.close()


def test_actions_of_several_parts(counting, tmp_path):
    """A reward of one env is given that env's part of each."""
    space = Dict({"go": Discrete(2)})
    envs = SyncVectorEnv([lambda: TransformAction(counting(fresh=True), lambda it: it, space)] * 2)
    rewards = {"went": lambda before, action, after, info: action["go"]}
    take(
        harness.RecordVectorRewards(envs, tmp_path, trained_with="own", rewards=rewards),
        [{"go": np.array([0, 1])}] * 3,
        AutoresetMode.NEXT_STEP,
    )
    found = read_recording(tmp_path)
    assert np.array_equal(found["reward/went"], found["env"])


def test_batch_that_tells_of_the_last_step_itself(tmp_path):
    """The harness's own env resets at once, and its infos are those of the step, without `final_info`."""
    envs = gymnasium.make_vec("harness/Reach-v0", num_envs=2, simulator="kinematic", task="fd100-reach")
    recorded = harness.RecordVectorRewards(
        envs,
        tmp_path,
        trained_with="own",
        rewards={"far": lambda before, action, after, info: info["distance"]},
        behaviour={"distance": "distance"},
        lower_is_better=["distance"],
    )
    recorded.reset(seed=0)
    recorded.action_space.seed(0)
    told = [recorded.step(recorded.action_space.sample())[4]["distance"].copy() for _ in range(60)]
    recorded.close()
    found = read_recording(tmp_path)
    assert found.facts.failures == ()
    assert (found["terminated"] | found["truncated"]).any()
    assert np.array_equal(found["behaviour/distance"], np.concatenate(told))
    assert np.array_equal(found["reward/far"], found["behaviour/distance"])


def _fail_in_second_env(before, action, after, info):
    if after[0] == 2 and info["left"] == 0:
        raise ValueError("at the end of the shorter")
    return 1.0


def _fail_in_batch(before, actions, after, infos):
    return np.where(after[:, 0] == [9, 2], np.nan, 1.0)


@pytest.mark.parametrize(
    ("given", "batched", "reason"),
    [
        (_fail_in_second_env, (), "ValueError: at the end of the shorter"),
        (_fail_in_batch, ("bad",), "ValueError: it is nan"),
        ("words", (), "it is 'none', no number"),
        (lambda *given: 0.0, ("bad",), r"an array of shape \(\), not \(2,\)"),
    ],
)
def test_reward_that_fails_is_given_up_with_env_and_step(recorded, given, batched, reason):
    """From there on it is NaN in all envs; other rewards go on."""
    with pytest.warns(UserWarning, match=f"^reward 'bad' failed in env .*{reason}") as told:
        found = recorded(rewards={"bad": given}, batched=batched)
    assert len(told) == 1
    (failure,) = found.facts.failures
    bad = np.flatnonzero(
        (found["env"] == failure.env) & (found["episode"] == failure.episode) & (found["step"] == failure.step)
    )
    assert np.isnan(found["reward/bad"]).tolist() == [row >= bad[0] for row in range(2 * CALLS)]
    assert not np.isnan(found["reward/own"]).any()


def test_batch_goes_on(recorded):
    """Episodes of each env go on where they were."""
    _, found = (recorded(calls=4, resume=True, **GIVEN) for _ in range(2))
    assert found["tick"].tolist() == sorted([*range(8), *range(8)])
    assert found["episode"][found["env"] == 0].tolist() == [0, 0, 0, 1, 2, 2, 2, 3]
    assert found["episode"][found["env"] == 1].tolist() == [0, 0, 1, 1, 2, 2, 3, 3]


def test_batched_names_are_names(recorded):
    """Of rewards or of behaviour."""
    with pytest.raises(UsageError, match="names 'nome', which is no reward and no behaviour"):
        recorded(batched=["nome"], **GIVEN)


def test_env_that_does_not_tell_how_it_starts_episodes_is_refused(make_batch, tmp_path):
    """The message says what its metadata need."""
    envs = make_batch(AutoresetMode.SAME_STEP)
    envs.metadata = {}
    with pytest.raises(UsageError, match=r"metadata need 'autoreset_mode', one of AutoresetMode\.NEXT_STEP"):
        harness.RecordVectorRewards(envs, tmp_path, **GIVEN)
