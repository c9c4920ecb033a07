"""Functions of a step as rewards of any env, and the terms that they pay."""

import warnings

import gymnasium
import numpy as np
import pytest

import harness
from harness.errors import SchemaError, UsageError
from harness.record import read_recording
from harness.record.recording.recording_writer import RecordingWriter
from harness.recorder.env_facts import Columns
from harness.recorder.recorder import GivenUp
from harness.recorder.retake import Retake
from harness.reward.terms import sum_of
from harness.score.weighted_recordings import weighed
from tests.record.recording.told import terms_of
from tests.recorder.conftest import MODES, Counting, recorder, take


def gentle(step):
    """Stand upright, and push little: single and double precision, as NumPy makes them."""
    push, before = step.action, step.before.action
    return {
        "upright": step.observation[0],
        "effort": -0.01 * (push**2).sum(-1),
        "jerk": -0.1 * float((push[0] - before[0]) ** 2),
    }


def eureka(observation, action, next_observation, info):
    """The form of Eureka."""
    terms = {"upright": float(next_observation[0]), "speed": -0.1 * abs(float(next_observation[2]))}
    return sum(terms.values()), terms


def _recorded(folder, steps, **given):
    env = recorder([lambda: gymnasium.make("Pendulum-v1")], None, folder, **given)
    env.action_space.seed(0)
    take(env, [env.action_space.sample() for _ in range(steps)], None)
    return read_recording(folder)


@pytest.mark.filterwarnings("error")
def test_terms_add_up_to_the_pay_in_every_step(tmp_path):
    """To the last bit, of single precision too; a term has a column, and its sum is the reward.

    No warning is given of what works, whatever is asked again.
    """
    found = _recorded(tmp_path / "run", 450, rewards={"gentle": gentle, "eureka": eureka})
    assert found.facts.terms == {"gentle": ("upright", "effort", "jerk"), "eureka": ("upright", "speed")}
    for name in found.facts.terms:
        assert np.array_equal(sum_of(terms_of(found, name)), found[f"reward/{name}"])
        assert all(np.ptp(values) > 0.0 for values in terms_of(found, name).values())
    assert next(iter(found.facts.term_columns)) == "reward/gentle/upright"


def test_training_with_terms_pays_their_sum(tmp_path):
    """To the learner; and an evaluation records them too."""
    env = harness.RecordRewards(
        gymnasium.make("Pendulum-v1"), tmp_path / "run", trained_with="gentle", rewards={"gentle": gentle}, pay=True
    )
    env.reset(seed=0)
    paid = [env.step(np.array([0.3], np.float32))[1] for _ in range(5)]
    assert env.recorded["reward/gentle/jerk"] == 0.0
    env.close()
    assert read_recording(tmp_path / "run")["reward/gentle"].tolist() == paid
    harness.evaluate_policy(
        lambda seen: np.zeros(1, np.float32), "Pendulum-v1", tmp_path / "evaluation", trained_with="gentle", seed=0,
        rewards={"gentle": gentle}, episodes=1,
    )  # fmt: skip
    found = read_recording(tmp_path / "evaluation")
    assert np.array_equal(sum_of(terms_of(found, "gentle")), found["reward/gentle"])


FAILS = {
    "a field that is not there": (lambda step: step.distance, 0, "has no 'distance'. It has: observation, action"),
    "a key that is not there": (lambda step: step.info["lost"], 0, "info has no 'lost'; it has 'left'"),
    "a term that is no number": (lambda step: {"a": "x"}, 0, ""),
    "a term that is not finite": (lambda step: {"a": 1.0, "b": float("nan")}, 0, "its term 'b': it is nan"),
    "a lost term": (
        lambda step: {"a": 1.0, **({"b": 2.0} if step.observation[0] < 2 else {})},
        1,
        "the terms a, b at first, and now a",
    ),
    "a number in place of terms": (
        lambda step: {"a": 1.0} if step.observation[0] < 2 else 1.0,
        1,
        "the terms a at first, and now none",
    ),
    "terms in place of a number": (
        lambda step: 1.0 if step.observation[0] < 2 else {"a": 1.0},
        1,
        "the terms none at first, and now a",
    ),
}


@pytest.mark.parametrize(("reward", "at", "told"), FAILS.values(), ids=FAILS)
@pytest.mark.parametrize("mode", MODES[:2])
def test_what_is_wrong_with_a_reward_is_told_by_name(tmp_path, reward, at, told, mode):
    """It is NaN from that step on, with all of its terms, and the others go on."""
    rewards = {"it": reward, "fine": lambda step: {"c": 1.0}}
    env = recorder([lambda: Counting(3, fresh=True)] * 2, mode, tmp_path / "run", rewards=rewards)
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        take(env, [np.ones_like(env.action_space.sample())] * 3, mode)
    assert f"reward 'it' failed in env 0, episode 0, step {at}" in str(seen[0].message)
    assert [it.category for it in seen] == [GivenUp]
    found = read_recording(tmp_path / "run")
    (failure,) = found.facts.failures
    assert told in failure.reason
    first = found["step"] < at
    assert np.isfinite(found["reward/it"][first]).all()
    assert np.isnan(found["reward/it"][~first]).all()
    for values in terms_of(found, "it").values():
        assert np.isnan(values[~first]).all()
    assert found["reward/fine/c"].tolist() == [1.0] * len(found)


def test_function_that_writes_into_a_step_is_told_what_it_writes_into(record):
    """By the name under which it reads it."""

    def spoil(step):
        step.action[0] = 3.0
        return 0.0

    env = record(rewards={"spoil": spoil})
    env.reset()
    with pytest.warns(GivenUp, match=r"it writes into its step\.action, which others read too"):
        env.step(np.ones(1, np.float32))


class Parts(Counting):
    """Tells what its reward is made of, and after two steps only how much it is."""

    def step(self, action):
        """Count on."""
        seen, paid, *ended, _ = super().step(action)
        return seen, paid, *ended, {"parts": {"near": 1.0, "far": 2.0} if paid < 3 else 5.0}


@pytest.mark.parametrize("mode", MODES[:2])
def test_key_that_told_terms_has_to_tell_them_in_every_step(mode, tmp_path):
    """The terms of the step before are not those of a step that told a number."""
    env = recorder([lambda: Parts(5, fresh=True)], mode, tmp_path / "run", rewards={"it": "parts"})
    with pytest.warns(GivenUp, match="step 2: It paid the terms near, far at first, and now none"):
        take(env, [np.zeros_like(env.action_space.sample())] * 5, mode)
    found = read_recording(tmp_path / "run")
    assert np.array_equal(found["reward/it"], [3.0, 3.0, np.nan, np.nan, np.nan], equal_nan=True)
    assert np.array_equal(found["reward/it/far"], [2.0, 2.0, np.nan, np.nan, np.nan], equal_nan=True)


def test_measure_is_one_number(record):
    """Terms are a reward's: a measure that is given by terms is refused, one that returns them is given up."""
    with pytest.raises(UsageError, match="a measure is one number, only rewards have terms"):
        record(path="a", behaviour={"it": {"left": "left"}})
    env = record(behaviour={"it": lambda step: {"left": 1.0}})
    env.reset()
    with pytest.warns(GivenUp, match="behaviour 'it' failed"):
        env.step(np.ones(1, np.float32))


def test_recording_goes_on_with_its_terms(tmp_path):
    """Other terms are refused as in one recording."""
    first = _recorded(tmp_path / "run", 30, rewards={"gentle": gentle}, seed=1)
    found = _recorded(tmp_path / "run", 30, rewards={"gentle": gentle}, seed=1, resume=True)
    assert (len(found), found.facts.terms) == (60, first.facts.terms)
    assert np.array_equal(sum_of(terms_of(found, "gentle")), found["reward/gentle"])


def test_recording_without_terms_is_written_as_before(tmp_path):
    """Its facts say nothing of terms, and its parts have no more columns."""
    found = _recorded(tmp_path / "run", 10, rewards={"it": lambda step: 1.0})
    assert (dict(found.facts.terms), found.facts.term_columns) == ({}, {})
    assert '"terms"' not in (tmp_path / "run" / "recording-0.json").read_text()


def test_term_without_a_value_is_damage(tmp_path, monkeypatch):
    """The mutant: a NaN of which no failure is told."""
    write = RecordingWriter.append
    without = np.ones(13)
    without[6] = np.nan
    monkeypatch.setattr(RecordingWriter, "append", lambda self, rows: write(self, rows * without))
    with pytest.raises(SchemaError, match="reward/it/a has no value in some steps, and no failure of it is told"):
        _recorded(tmp_path / "run", 3, rewards={"it": lambda step: {"a": 1.0}}).rows()


def test_recorders_of_one_training_have_the_same_terms(tmp_path):
    """One that has no step yet has not learned them."""
    for number in range(2):
        found = _recorded(tmp_path / "run", 20 * (1 - number), rewards={"gentle": gentle}, number=number)
    assert (len(found), [*found.terms_of("gentle")]) == (20, ["upright", "effort", "jerk"])


def test_terms_are_paid_again(tmp_path):
    """A recording that is paid later has the terms too, in place of earlier ones of that reward."""
    live = _recorded(tmp_path / "live", 250, rewards={"gentle": gentle})
    _recorded(tmp_path / "plain", 250)
    for later in ({"gentle": lambda step: {"old": 1.0}}, {"gentle": gentle}):
        retake = Retake(lambda: gymnasium.make("Pendulum-v1"), lambda env, it=later: Columns(it, {}))
        assert not retake.score(tmp_path / "plain")
    found = read_recording(tmp_path / "plain")
    assert [*found.terms_of("gentle")] == ["upright", "effort", "jerk"]
    for name, values in terms_of(live, "gentle").items():
        assert np.array_equal(found[f"reward/gentle/{name}"], values)


def test_weights_pay_what_a_reward_with_these_weights_pays(tmp_path):
    """By the columns of its terms alone, to the last bit."""
    from harness.reward.given import Terms

    found = _recorded(
        tmp_path / "run", 250, rewards={"gentle": gentle, "gentle:effort=5": Terms({"gentle": gentle}, {"effort": 5.0})}
    )
    own = found["reward/gentle:effort=5"]
    without = weighed(_recorded(tmp_path / "other", 250, rewards={"gentle": gentle}), ["gentle:effort=5"])
    assert np.array_equal(without["reward/gentle:effort=5"], own)
    assert without.facts.terms["gentle:effort=5"] == ("upright", "effort", "jerk")
    for term, values in terms_of(found, "gentle:effort=5").items():
        assert np.array_equal(without[f"reward/gentle:effort=5/{term}"], values)
    assert not np.allclose(own, found["reward/gentle"])
    assert "gentle:mass=5" not in weighed(found, ["gentle:mass=5"]).rewards
