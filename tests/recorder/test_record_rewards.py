"""`harness.RecordRewards`: what it records, and what it leaves alone."""

import gc
import os
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from harness.errors import SchemaError, StorageError, UsageError
from harness.record import read_recording
from tests.recorder.conftest import ACTION


def gain(observation, action, next_observation, info):
    """How far the count went, and the action."""
    return float(next_observation[0] - observation[0] + action[0])


@pytest.fixture
def record(record):
    """As elsewhere, with a reward `gain` unless others are given."""
    return lambda **given: record(**{"rewards": {"gain": gain}, **given})


def _act(env, steps, seed=None):
    """Reset, and take steps; episodes that end are followed by the next."""
    env.reset(seed=seed)
    for _ in range(steps):
        if any(env.step(ACTION)[2:4]):
            env.reset()


def _recorded(env, steps, tmp_path, seed=None):
    _act(env, steps, seed)
    env.close()
    return read_recording(tmp_path / "run")


def test_abandoned_episode_is_an_episode_of_its_own(record, tmp_path):
    """A reset in its middle begins the next; a reset without a step before it does not."""
    env = record()
    for steps in (1, 0, 2):
        _act(env, steps)
    env.close()
    assert read_recording(tmp_path / "run")["episode"].tolist() == [0, 1, 1]


def test_reward_that_trained_may_be_a_function_of_the_steps(record, tmp_path):
    """Where the env pays the same."""
    count = {"count": lambda before, action, after, info: after[0]}
    found = _recorded(record(trained_with="count", rewards=count), 3, tmp_path)
    assert (found.facts.trained_with, found.facts.rewards, found.facts.paid_otherwise) == ("count", ("count",), "")


def test_env_that_pays_something_else_is_told(record, tmp_path):
    """Once, with the first step in which it does."""
    env = record(trained_with="gain")
    with pytest.warns(
        UserWarning, match="is not paid by trained_with='gain': env 0, episode 0, step 0: the env paid 1"
    ):
        env.reset(), env.step(ACTION)
    found = _recorded(env, 3, tmp_path)
    assert found.facts.paid_otherwise == "env 0, episode 0, step 0: the env paid 1, 'gain' 1.5"


def test_env_is_left_as_it_is(record, counting):
    """The same observations, payments, ends and infos, objects and all."""
    bare, recorded = counting(), record()
    assert recorded.reset(seed=1)[1] == bare.reset(seed=1)[1]
    for _ in range(3):
        one = recorded.step(ACTION)
        assert one == bare.step(ACTION)
        assert one[0] is recorded.unwrapped._place
    assert recorded.np_random.random() == bare.np_random.random()


@pytest.mark.filterwarnings("ignore::UserWarning:gymnasium")
def test_check_env_passes(record):
    """With a registered env; the spec is the env's own, of which `make` makes an env that is not recorded."""
    bare = gymnasium.make("Pendulum-v1")
    env = record(env=bare, rewards={"height": lambda before, action, after, info: after[0]})
    assert env.spec is bare.spec
    check_env(env, skip_render_check=True)
    env.close()


def test_seed_and_env_are_written_down(record, tmp_path):
    """The first seed; the spec with its arguments; the versions."""
    facts = _recorded(record(env=gymnasium.make("Pendulum-v1", g=9.0)), 2, tmp_path, seed=5).facts
    assert facts.seed == 5
    assert (facts.env, facts.spec["kwargs"], facts.spec["max_episode_steps"]) == ("Pendulum-v1", {"g": 9.0}, 200)
    assert facts.versions["gymnasium"] == gymnasium.__version__
    assert {"python", "fd100-harness", "numpy", "pyarrow"} < set(facts.versions)


def test_nothing_of_the_machine_is_written_down(record, tmp_path):
    """Neither its name nor a place on its disk."""
    _recorded(record(), 1, tmp_path)
    text = (tmp_path / "run" / "recording-0.json").read_text()
    assert os.uname().nodename not in text
    assert str(tmp_path) not in text
    assert str(Path.home()) not in text


FAILURES = {
    "raises": (lambda before, action, after, info: 1 / (after[0] - 2) if after[0] != 2 else 1 / 0, "ZeroDivisionError"),
    "nan": (lambda before, action, after, info: float("nan") if after[0] == 2 else 0.0, "ValueError: it is nan"),
    "shape": (lambda before, action, after, info: after if after[0] == 2 else 0.0, r"an array of shape \(1,\)"),
    "key": ("other", "info has no 'other'; it has 'left', 'words'"),
}


@pytest.mark.parametrize(("given", "reason"), FAILURES.values(), ids=FAILURES)
def test_reward_that_fails_is_given_up(record, tmp_path, given, reason):
    """From its step on it is NaN, in later episodes too; what was recorded stays, and the others go on."""
    env = record(rewards={"bad": given, "gain": gain})
    with pytest.warns(UserWarning, match=f"^reward 'bad' failed in env 0, episode 0, step 1: .*{reason}") as warned:
        found = _recorded(env, 5, tmp_path)
    assert len(warned) == 1
    assert np.isnan(found["reward/bad"]).tolist() == [False, True, True, True, True]
    assert found["reward/gain"].tolist() == [1.5] * 5
    (failure,) = found.facts.failures
    assert (failure.column, failure.env, failure.episode, failure.step) == ("reward/bad", 0, 0, 1)


@pytest.mark.parametrize(("given", "reason"), FAILURES.values(), ids=FAILURES)
def test_reward_that_fails_can_stop_the_training(record, given, reason):
    """With on_error="raise"."""
    env = record(rewards={"bad": given}, on_error="raise")
    env.reset()
    env.step(ACTION)
    with pytest.raises(UsageError, match=f"reward 'bad' failed in env 0, episode 0, step 1: .*{reason}"):
        env.step(ACTION)


def test_memory_that_cannot_restart_is_given_up(record, tmp_path):
    """As if its first step had failed."""

    class Stuck:
        def reset(self):
            raise RuntimeError("stuck")

        def __call__(self, step):
            return 0.0

    with pytest.warns(UserWarning, match="episode 0, step 0: RuntimeError: stuck"):
        found = _recorded(record(rewards={"bad": Stuck()}), 2, tmp_path)
    assert np.isnan(found["reward/bad"]).all()


def test_behaviour_that_is_missing_at_the_end_is_given_up(record, tmp_path):
    """It would be missing for good."""
    with pytest.warns(UserWarning, match="behaviour 'never' failed in env 0, episode 0, step 2: .*info has no 'never'"):
        _recorded(record(behaviour={"never": "never"}), 3, tmp_path)


UNUSABLE = {
    "unknown trained_with": ({"trained_with": "v3"}, "trained_with='v3' is none of the rewards"),
    "no function": ({"rewards": {"v1": 3}}, "reward 'v1' is 3: it has to be a function of"),
    "name": ({"behaviour": {"": "x"}}, "behaviour '': a name is a text"),
    "on_error": ({"on_error": "stop"}, "on_error='stop': it is 'warn' or 'raise'"),
    "number": ({"number": -1}, "number=-1"),
    "steps below 0": ({"steps_asked": -1}, "steps_asked=-1: it is a whole number"),
    "episodes of a training": ({"episodes_asked": 3}, "episodes_asked with evaluation=True"),
    "steps of an evaluation": ({"steps_asked": 3, "evaluation": True}, "steps_asked goes with a training"),
    "bounds of what is no measure": (
        {"behaviour": {"left": "left"}, "bounds": {"right": (0.0, 1.0)}},
        r"bounds names 'right', which is none of the measures \['left'\]",
    ),
    "bounds without an order": (
        {"behaviour": {"left": "left"}, "bounds": {"left": (1.0, 0.0)}},
        r"bounds of 'left' are \(1.0, 0.0\): give two numbers, the lower one first",
    ),
}


@pytest.mark.parametrize(("given", "message"), UNUSABLE.values(), ids=UNUSABLE)
def test_what_cannot_be_used_is_refused(record, tmp_path, given, message):
    """Before anything is written."""
    with pytest.raises(UsageError, match=message):
        record(**given)
    assert not (tmp_path / "run").exists()


def test_path_that_cannot_be_a_folder_is_refused(record, tmp_path):
    """A file stands there."""
    (tmp_path / "run").write_text("mine")
    with pytest.raises(StorageError, match="cannot be written"):
        record()


def test_recording_is_not_written_over(record, tmp_path):
    """A path that holds one is refused, and stays."""
    before = _recorded(record(), 4, tmp_path)
    with pytest.raises(UsageError, match=r"holds a recording already: .*resume=True"):
        record()
    assert len(read_recording(tmp_path / "run")) == len(before)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"rewards": {"gain": lambda before, action, after, info: 0.0}}, "its sources differ"),
        ({"rewards": {"gain": gain, "left": "left"}}, "its rewards differ"),
        ({"trained_with": "gain"}, "its trained_with differ"),
        ({"env": gymnasium.make("Pendulum-v1")}, "its env differ"),
    ],
)
def test_another_training_does_not_go_on(record, tmp_path, change, what):
    """The recording stays that of one training."""
    _recorded(record(), 1, tmp_path)
    with pytest.raises(UsageError, match=what):
        record(resume=True, **change)


def test_a_recording_goes_on_with_its_own_seed(record, tmp_path):
    """Steps of another seed are of another training; whoever says none goes on."""
    _recorded(record(seed=3), 1, tmp_path)
    with pytest.raises(UsageError, match="its seed differ: 3, now 4"):
        record(resume=True, seed=4)
    assert len(_recorded(record(resume=True), 1, tmp_path)) == 2


def test_given_up_reward_stays_given_up_in_a_recording_that_goes_on(record, tmp_path):
    """Its NaN has no gap."""
    with pytest.warns(UserWarning, match="failed"):
        _recorded(record(rewards={"bad": "other"}), 2, tmp_path)
    found = _recorded(record(rewards={"bad": "other"}, resume=True), 1, tmp_path)
    assert np.isnan(found["reward/bad"]).tolist() == [False, True, True]


def test_envs_of_one_training_record_beside_one_another(record, tmp_path):
    """Each with a number; without one the second is refused."""
    first = record()
    with pytest.raises(UsageError, match="is being recorded by another env with number=0"):
        record()
    second = record(number=1)
    _act(first, 2)
    _act(second, 2)
    first.close(), second.close()
    found = read_recording(tmp_path / "run")
    assert found.facts.num_envs == 2
    assert found["tick"].tolist() == [0, 0, 1, 1]
    assert found["env"].tolist() == [0, 1, 0, 1]


def test_recording_can_be_read_while_it_goes_on(record, tmp_path, monkeypatch):
    """As far as it was written, which is every few seconds."""
    monkeypatch.setattr("harness.record.parts.WRITE_EVERY", 0.0)
    env = record()
    for steps in (0, 2):
        _act(env, steps)
        assert len(read_recording(tmp_path / "run")) == steps
    assert not read_recording(tmp_path / "run").facts.closed


def test_garbage_is_written_first(record, tmp_path):
    """An env that nobody closes leaves all its steps."""
    env = record()
    _act(env, 2)
    del env
    gc.collect()
    found = read_recording(tmp_path / "run")
    assert (len(found), found.facts.closed) == (2, True)


def test_steps_after_close_are_not_recorded(record, tmp_path):
    """Closing ends the recording; closing twice is nothing new."""
    env = record()
    found = _recorded(env, 2, tmp_path)
    _act(env, 1)
    env.close()
    assert len(read_recording(tmp_path / "run")) == len(found) == 2


def test_full_disk_ends_the_recording_and_not_the_training(record, tmp_path, monkeypatch):
    """One warning, and closing the env says no more; what was written stays."""

    def refuse(*given):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("harness.record.parts.WRITE_EVERY", 0.0)
    env = record()
    monkeypatch.setattr("harness.record.parts.write_packed", refuse)
    with pytest.warns(
        UserWarning, match=r"cannot be written: No space left on device\. Nothing more is recorded"
    ) as told:
        _act(env, 3)
    env.close()
    assert [warning.filename for warning in told] == [__file__]
    assert len(read_recording(tmp_path / "run")) == 0


LEFT = """
import sys, gymnasium, harness
env = harness.RecordRewards(gymnasium.make("Pendulum-v1"), sys.argv[1], trained_with="own", rewards={})
env.reset(seed=0)
for step in range(7):
    env.step(env.action_space.sample())
"""


def test_process_that_ends_leaves_its_steps(tmp_path):
    """By itself and without `close`."""
    subprocess.run([sys.executable, "-c", LEFT, tmp_path], check=True)
    found = read_recording(tmp_path)
    assert (len(found), found.facts.closed) == (7, True)


@pytest.mark.filterwarnings("ignore:pay was NaN")
def test_own_pay_that_is_no_number_ends_the_training_in_its_step(record, counting):
    """Rows are made later, and what the learner is paid is looked at before it gets it."""

    class Lost(counting):
        def step(self, action):
            seen, paid, *rest = super().step(action)
            return seen, np.nan if self.count == 150 else paid, *rest

    env = record(env=Lost(length=200), pay=True)
    _act(env, 149)
    with pytest.raises(UsageError, match=r"step 149: .* It pays the learner, so the training cannot go on"):
        env.step(env.action_space.sample())


def test_damaged_recording_does_not_go_on(record, tmp_path):
    """It is named, and left alone."""
    _recorded(record(), 1, tmp_path)
    path = tmp_path / "run" / "recording-0.json"
    path.write_bytes(path.read_bytes().replace(b'"own"', b'"owm"', 1))
    with pytest.raises(SchemaError, match="it is not what was written"):
        record(resume=True)


def test_what_was_asked_for_stands_in_the_record(record, tmp_path):
    """Of a training its steps; whoever goes on with it may ask for more."""
    for asked, told in (({"steps_asked": 30}, 30), ({}, 30), ({"steps_asked": 60}, 60)):
        record(resume=True, **asked).close()
        assert read_recording(tmp_path / "run").facts.asked == told


@pytest.mark.parametrize("better", ["lower_is_better", "higher_is_better"])
def test_a_measure_decides_only_where_it_is_known_what_is_better(record, tmp_path, better):
    """The first step refuses it, before anything is learned; what the message says to give is taken."""
    with pytest.raises(UsageError, match=rf"'left' decides.*{better}=\['left'\]"):
        _act(record(path="refused", behaviour={"left": "left"}), 1)
    found = _recorded(record(behaviour={"left": "left"}, **{better: ["left"]}), 5, tmp_path)
    assert getattr(found.facts, better) == ("left",)


def test_a_measure_of_which_both_are_said_decides_nothing(record, tmp_path):
    """Neither counts, whether they are said at once or by who goes on."""
    both = {"lower_is_better": ["left"], "higher_is_better": ["left"]}
    with pytest.raises(UsageError, match=r"'left' decides.*or both are said"):
        _act(record(path="refused", behaviour={"left": "left"}, **both), 1)
    _recorded(record(behaviour={"left": "left"}, lower_is_better=["left"]), 2, tmp_path)
    found = _recorded(record(behaviour={"left": "left"}, higher_is_better=["left"], resume=True), 2, tmp_path)
    assert (found.facts.lower_is_better, found.facts.higher_is_better) == (("left",), ("left",))


def test_a_measure_that_counts_up_from_1_is_asked_as_soon_as_it_is_no_flag(record, counting, tmp_path):
    """What was recorded is kept, and goes on with the answer; after the first steps the training goes on at once."""
    counted = {"count": lambda step: step.observation[0]}
    first = record(behaviour=counted)
    with pytest.raises(UsageError, match=r"'count' decides.*lower_is_better=\['count'\]"):
        _act(first, 2)
    first.close()
    again = record(behaviour=counted, lower_is_better=["count"], resume=True)
    found = _recorded(again, 3, tmp_path)
    assert (found["behaviour/count"].tolist(), found.facts.lower_is_better) == ([1, 1, 2, 3], ("count",))
    late = {"late": lambda step: 2.0 * (step.observation[0] > 120.0)}
    with pytest.warns(UserWarning, match=r"'late' decides.*--measure late:better=lower"):
        _act(record(path="late", env=counting(150), behaviour=late), 130)


def test_a_flag_and_an_evaluation_need_no_direction(record, tmp_path):
    """Of what is 0 or 1 more is better, and reports ask for what else a finished policy does."""
    flag = {"fell": lambda step: step.observation[0] > 1.0}
    assert len(_recorded(record(behaviour=flag), 5, tmp_path)) == 5
    _act(record(path="evaluation", behaviour={"left": "left"}, evaluation=True), 3)
