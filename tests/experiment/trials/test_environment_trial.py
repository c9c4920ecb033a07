"""One episode in an environment says what a training would find out later."""

import pytest

from harness import load_registry
from harness.experiment.trials.environment_trial import MOST_STEPS, try_environment
from harness.experiment.trials.tried import Fault, Tried
from harness.registry import choose


@pytest.fixture
def tried(lay):
    """The trial of an environment with files of functions; what was asked, in order."""

    def trial(task="walking", *, without=(), asked=None, **files):
        registry = load_registry(given=lay(**files))
        tell = (lambda column: None) if asked is None else asked.append
        return try_environment(choose(registry, "environments", task), registry, without, tell)

    return trial


def test_what_works_is_not_spoken_of(tried):
    """A key of the last step alone works too."""
    assert tried(far="return abs(float(next_observation[0]))") == Tried()


def test_reward_that_raises_is_named_with_its_line(tried):
    """And the step."""
    (fault,) = tried(bad="return next_observation.angle").faults
    assert (fault.noun, fault.name) == ("reward", "bad")
    assert fault.reason == (
        "fails in step 0: AttributeError: 'numpy.ndarray' object has no attribute 'angle' (bad.py, line 2)."
    )


@pytest.mark.parametrize(
    ("body", "told"),
    [
        (
            "return 1.0 if next_observation is not None and info['is_success'] else 1 / 0",
            "fails in step 0: ZeroDivision",
        ),
        ("return float('nan')", "fails in step 0: ValueError: it is nan"),
        ("return next_observation.repeat(2)", "fails in step 0: ValueError: it is an array of shape (2,)"),
        ("return 'much'", "fails in step 0: TypeError"),
        ("raise SystemExit", "fails in step 0: RuntimeError: SystemExit"),
        ("return 1.0 / (1.0 - info.get('last', 0.0))", "fails in step 7: ZeroDivisionError"),
    ],
)
def test_what_no_recording_takes_is_a_fault(tried, body, told):
    """In whichever step."""
    (fault,) = tried(bad=body).faults
    assert fault.reason.startswith(told)


def test_missing_key_is_told_with_the_near_one(tried):
    """At the end of an episode, where a measure has to be there."""
    (fault,) = tried("walking:tells=success").faults
    assert fault == Fault(
        "measure",
        "success",
        "cannot be read in step 7, the last of an episode: "
        "No key of info 'success'. There is: is_success, last. Did you mean 'is_success'?",
    )


def test_key_that_only_the_end_may_tell_is_a_note_where_no_episode_ended(tried):
    """It cannot be known."""
    found = tried("walking:tells=success,length=100000")
    assert not found.faults
    (note,) = found.notes
    assert f"no episode ended within {MOST_STEPS:,} steps, and none of them told 'success'" in note
    assert "Did you mean 'is_success'?" in note


@pytest.mark.parametrize(("start", "is_told"), [("seeded", False), ("numpy", True), ("python", True)])
def test_seed_that_the_env_ignores_is_told(tried, start, is_told):
    """Of whichever generator its starts come."""
    notes = tried(f"walking:start={start}").notes
    assert any("reset with the same seed" in note for note in notes) is is_told
    assert len(notes) == is_told


def test_reward_that_changes_the_env_is_told_as_such(tried):
    """The seed is not blamed for it."""
    (note,) = tried("walking:touches=true").notes
    assert "they should only look on" in note


def test_what_is_left_out_is_not_asked(tried):
    """It may be what ends a process."""
    asked = []
    assert tried(bad="return 1 / 0", without={"reward_bad"}, asked=asked) == Tried()
    assert {*asked} == {"", "reward_own", "behaviour_last", "behaviour_place"}


def test_env_that_fails_is_told(tried):
    """What it raises is no fault of a reward."""
    found = tried("walking:start=nowhere", far="return 1.0")
    assert not found.faults
    (note,) = found.notes
    assert "the environment fails: ValueError: could not convert string to float: 'here' (walking.py, line" in note


def test_hidden_memory_is_a_fault(tried):
    """It would be given up in every cell, and the cell that it pays would fail."""
    (fault,) = tried(counts="counts.n = getattr(counts, 'n', 0) + 1\n    return counts.n").faults
    assert fault.reason.startswith("cannot be used: it said 1, and said 2 when it was asked about the same step at on")


def test_what_writes_is_told_what_to_write(tried):
    """As a training would tell it."""
    (fault,) = tried(halves="action /= 2\n    return 0.0").faults
    assert fault.reason.startswith("fails in step 0: it writes into its action, which others read too: write `action")


def test_slow_reward_is_not_asked_all_over(tried, monkeypatch):
    """The trial would take longer than a call may, and the reward would be thought to hang."""
    monkeypatch.setattr("harness.experiment.trials.environment_trial.MOST_AGAIN", 0.0)
    asked = []
    assert tried(slow="return float(next_observation[0])", asked=asked) == Tried()
    assert asked.count("reward_slow") == 8 + 1
