"""`harness.RecordVectorRewards`: what it records is what single envs record, in each way of starting episodes."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import harness
from harness.errors import UsageError
from harness.record import read_recording

LENGTHS = (3, 2)
CALLS = 9
MODES = [AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP, AutoresetMode.DISABLED]


class Remembering:
    """Sums what happens in an episode."""

    def __init__(self) -> None:
        self.sum = np.nan

    def reset(self):
        """Begin."""
        self.sum = 0.0

    def __call__(self, before, action, after, info):
        """Both observations, the action and the info are in it."""
        seen = [*map(float, (before[0], after[0], action[0])), info["left"], "final" in info]
        self.sum += float(np.dot([100, 10, 1, 0.001, 0.0001], seen))
        return self.sum


class RememberingBatch:
    """The same of all envs at once, of what a batch has of it."""

    def __init__(self) -> None:
        self.sums = np.full(len(LENGTHS), np.nan)

    def reset(self, mask):
        """Begin in some envs."""
        self.sums[mask] = 0

    def __call__(self, before, actions, after, infos):
        """Observations and actions."""
        self.sums += 100 * before[:, 0] + 10 * after[:, 0] + actions[:, 0]
        return self.sums


GIVEN = {
    "trained_with": "own",
    "rewards": {"sum": Remembering()},
    "behaviour": {"left": "left", "final": "final"},
    "lower_is_better": ["left"],
}


def _action(env, call):
    return 0.01 * env + 0.1 * (call % 7)


@pytest.fixture
def make_batch(counting):
    """Two counting envs, of other lengths."""

    def make(mode):
        return SyncVectorEnv(
            [lambda length=length: counting(length, fresh=True) for length in LENGTHS], autoreset_mode=mode
        )

    return make


def _act(envs, mode, calls=CALLS):
    """Take steps in all envs; those that have to be told to start an episode are told."""
    envs.reset(seed=3)
    for call in range(calls):
        actions = np.array([[_action(env, call)] for env in range(len(LENGTHS))], np.float32)
        _, _, terminated, truncated, _ = envs.step(actions)
        ended = terminated | truncated
        if mode == AutoresetMode.DISABLED and ended.any():
            envs.reset(options={"reset_mask": ended})


@pytest.fixture
def recorded(make_batch, tmp_path):
    """What is recorded of such a batch."""

    def record(mode=AutoresetMode.SAME_STEP, calls=CALLS, **given):
        envs = harness.RecordVectorRewards(make_batch(mode), tmp_path / "batch", **{"trained_with": "own", **given})
        _act(envs, mode, calls)
        envs.close()
        return read_recording(tmp_path / "batch")

    return record


def _single(counting, path, env, calls):
    """What one env alone records, of the actions of these calls."""
    alone = harness.RecordRewards(counting(LENGTHS[env]), path, **GIVEN)
    alone.reset()
    for call in calls:
        if alone.step(np.array([_action(env, call)], np.float32))[2]:
            alone.reset()
    alone.close()
    return read_recording(path)


@pytest.mark.parametrize("mode", MODES)
def test_batch_records_what_its_envs_record_alone(counting, recorded, tmp_path, mode):
    """Every column of every env, with the last observation and info of an episode that ended."""
    found = recorded(mode, **GIVEN)
    assert (found.facts.num_envs, found.facts.seed, found.facts.closed) == (2, 3, True)
    for env, length in enumerate(LENGTHS):
        rows = found["env"] == env
        only_reset = range(length, CALLS, length + 1) if mode == AutoresetMode.NEXT_STEP else ()
        calls = [call for call in range(CALLS) if call not in only_reset]
        alone = _single(counting, tmp_path / str(env), env, calls)
        assert found["tick"][rows].tolist() == calls
        for name in ("episode", "step", "terminated", "truncated"):
            assert np.array_equal(found[name][rows], alone[name]), name
        for name in ("own", "sum"):
            assert np.array_equal(found[f"reward/{name}"][rows], alone[f"reward/{name}"]), name
        for name in ("left", "final"):
            assert np.array_equal(found[f"behaviour/{name}"][rows], alone[f"behaviour/{name}"], equal_nan=True), name


@pytest.mark.parametrize("mode", MODES)
def test_batched_reward_is_that_of_single_envs(recorded, mode):
    """Called once for all envs, with the observations of the step, and restarted in those that start an episode."""
    rewards = {"all": RememberingBatch(), "each": lambda *given: given[1][0] + 10 * given[2][0] + 100 * given[0][0]}
    found = recorded(mode, rewards=rewards, batched=["all"], behaviour={})
    for env in range(len(LENGTHS)):
        for episode in range(3):
            rows = (found["env"] == env) & (found["episode"] == episode)
            np.testing.assert_allclose(found["reward/all"][rows], np.cumsum(found["reward/each"][rows]), rtol=1e-6)


@pytest.mark.parametrize("mode", MODES)
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


def test_observations_of_several_parts(tmp_path):
    """A reward of one env is given that env's dict, at an episode's end the last one."""

    class Parts(gymnasium.Env[Any, Any]):
        observation_space = gymnasium.spaces.Dict(
            {"a": gymnasium.spaces.Box(0, 9, (2,)), "b": gymnasium.spaces.Tuple([gymnasium.spaces.Discrete(9)])}
        )
        action_space = gymnasium.spaces.Dict({"go": gymnasium.spaces.Discrete(2)})
        count = 0

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            self.count = 0
            return self._seen(), {}

        def step(self, action):
            self.count += 1
            return self._seen(), 0.0, self.count == 2, False, {"nested": {"deep": self.count}}

        def _seen(self):
            return {"a": np.full(2, self.count, np.float32), "b": (self.count,)}

    def seen(before, action, after, info):
        return 1000 * action["go"] + 100 * info["nested"]["deep"] + 10 * after["a"][1] + after["b"][0] - before["b"][0]

    envs = harness.RecordVectorRewards(
        SyncVectorEnv([Parts, Parts], autoreset_mode=AutoresetMode.SAME_STEP),
        tmp_path,
        trained_with="own",
        rewards={"seen": seen},
    )
    envs.reset(seed=0)
    for _ in range(3):
        envs.step({"go": np.array([0, 1])})
    envs.close()
    found = read_recording(tmp_path)
    assert found["reward/seen"][found["env"] == 0].tolist() == [111, 221, 111]
    assert found["reward/seen"][found["env"] == 1].tolist() == [1111, 1221, 1111]


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
        ("other", (), "info has no 'other'; it has 'left', 'words'"),
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


def test_envs_that_pay_something_else_are_told(recorded):
    """With the first env and step."""
    rewards = {"mine": lambda before, action, after, info: float(after[0]) + (after[0] == 3)}
    with pytest.warns(UserWarning, match="env 0, episode 0, step 2: the env paid 3, 'mine' 4") as told:
        recorded(trained_with="mine", rewards=rewards)
    assert len(told) == 1


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
