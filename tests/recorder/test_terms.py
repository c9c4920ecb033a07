"""Functions of a step as rewards of any env, and the terms that they pay."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import harness
from harness.errors import SchemaError, UsageError
from harness.record import read_recording
from harness.record.recording.recording_writer import RecordingWriter
from harness.recorder import GivenUp, Later, Retake
from harness.reward.terms import sum_of
from harness.score.weighted_recordings import weighed
from tests.record.recording.told import terms_of


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


def _act(env, steps, seed=0):
    env.action_space.seed(seed)
    env.reset(seed=seed)
    for _ in range(steps):
        if any(env.step(env.action_space.sample())[2:4]):
            env.reset()


def _act_batch(env, steps):
    env.action_space.seed(0)
    env.reset(seed=0)
    for _ in range(steps):
        env.step(env.action_space.sample())


def _recorded(folder, steps, name="Pendulum-v1", **given):
    env = harness.RecordRewards(gymnasium.make(name), folder, **{"trained_with": "own", "rewards": {}, **given})
    _act(env, steps)
    env.close()
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


def test_before_the_first_step_there_are_zeros_and_the_info_of_the_reset(counting, record):
    """Afterwards the observation, the action and the info of the step before."""
    seen = []

    def look(step):
        before = step.before
        seen.append((before.observation[0], before.action.tolist(), dict(before.info).get("left"), step.info["left"]))
        return 0.0

    env = record(counting(2), rewards={"look": look})
    for _ in range(2):
        env.reset()
        env.step(np.array([0.5], np.float32)), env.step(np.array([0.25], np.float32))
    asked = list(dict.fromkeys((one[0], tuple(one[1]), *one[2:]) for one in seen))
    assert asked == [(0.0, (0.0,), None, 1), (1.0, (0.5,), 1, 0)]


def test_choice_before_the_first_step_is_0(tmp_path):
    """Of a Discrete action."""
    seen = []
    _recorded(tmp_path / "run", 1, "CartPole-v1", rewards={"look": lambda step: seen.append(step.before.action) or 0.0})
    assert seen[0] == 0
    assert isinstance(seen[0], int | np.integer)


FAILS = {
    "a field that is not there": (lambda step: step.distance, 0, "has no 'distance'. It has: observation, action"),
    "a key that is not there": (lambda step: step.info["lost"], 0, "info has no 'lost'; it has 'left'"),
    "a key, of four arguments": (lambda o, a, n, i: i["lefd"], 0, "Did you mean 'left'?"),
    "an empty dict": (lambda step: {}, 0, "A dict of terms is empty"),
    "a total that is not the sum": (lambda step: (5.0, {"a": 1.0, "b": 2.0}), 0, "The total 5 is not the sum"),
    "a term that is no number": (lambda step: {"a": "x"}, 0, ""),
    "a term that is not finite": (lambda step: {"a": 1.0, "b": float("nan")}, 0, "its term 'b': it is nan"),
    "a name that is none": (lambda step: {"a/b": 1.0}, 0, "is no name of a term"),
    "a lost term": (
        lambda step: {"a": 1.0, **({"b": 2.0} if step.observation[0] < 2 else {})},
        1,
        "the terms a, b at first, and now a",
    ),
    "another term": (lambda step: {"a" if step.observation[0] < 2 else "b": 1.0}, 1, "and now b"),
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
@pytest.mark.parametrize("vector", [False, True])
def test_what_is_wrong_with_a_reward_is_told_by_name(counting, tmp_path, reward, at, told, vector):
    """It is NaN from that step on, with all of its terms, and the others go on."""
    given = {"trained_with": "own", "rewards": {"it": reward, "fine": lambda step: {"c": 1.0}}}
    if vector:
        env = harness.RecordVectorRewards(
            SyncVectorEnv([lambda: counting(3, fresh=True)] * 2), tmp_path / "run", **given
        )
    else:
        env = harness.RecordRewards(counting(3), tmp_path / "run", **given)
    env.reset(seed=0)
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        for _ in range(3):
            env.step(np.ones_like(env.action_space.sample()))
    env.close()
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


def test_terms_may_be_given_by_name(counting, record, tmp_path):
    """Keys of info and functions of both forms; one with a memory is restarted."""

    class Count:
        def reset(self):
            self.count = 0

        def __call__(self, step):
            self.count += 1
            return float(self.count)

    terms = {"left": "left", "count": Count(), "went": lambda o, a, n, i: float(n[0] - o[0])}
    env = record(counting(3), rewards={"it": terms})
    _act(env, 6)
    env.close()
    found = read_recording(tmp_path / "run")
    assert {name: values.tolist() for name, values in terms_of(found, "it").items()} == {
        "left": [2.0, 1.0, 0.0] * 2,
        "count": [1.0, 2.0, 3.0] * 2,
        "went": [1.0] * 6,
    }
    assert found.facts.sources["reward/it"].text.startswith("# left\ninfo key 'left'\n# count\n")


class Parts(gymnasium.Env[Any, Any]):
    """Tells what its reward is made of, and after two steps only how much it is."""

    observation_space = action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,))

    def reset(self, **given):
        """Count from 0."""
        super().reset(**given)
        self.count = 0
        return np.zeros(1, np.float32), {}

    def step(self, action):
        """Count on."""
        self.count += 1
        told = {"near": 1.0, "far": 2.0} if self.count < 3 else 5.0
        return np.zeros(1, np.float32), 3.0, False, self.count == 5, {"parts": told}


@pytest.mark.parametrize("is_batch", [False, True])
def test_key_that_told_terms_has_to_tell_them_in_every_step(is_batch, tmp_path):
    """The terms of the step before are not those of a step that told a number."""
    asked = {"trained_with": "own", "rewards": {"own": "own", "it": "parts"}}
    one = harness.RecordRewards(Parts(), tmp_path / "run", **asked) if not is_batch else None
    env = one or harness.RecordVectorRewards(SyncVectorEnv([Parts]), tmp_path / "run", **asked)
    with pytest.warns(GivenUp, match="step 2: It paid the terms near, far at first, and now none"):
        _act_batch(env, 5) if is_batch else _act(env, 5)
    env.close()
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


@pytest.mark.parametrize("mode", [AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP, AutoresetMode.DISABLED])
def test_batch_records_what_single_envs_do(counting, tmp_path, mode, step_two):
    """Of what is now and what was before, in each way of starting episodes, asked one by one and at once."""

    def each(step):
        told = step.before.info.get("left", -1.0)
        return {
            "seen": 10.0 * step.before.observation[0] + step.observation[0],
            "acted": step.action[0] + 0.1 * step.before.action[0],
            "told": float(told),
        }

    def whole(step):
        return {
            "seen": 10.0 * step.before.observation[:, 0] + step.observation[:, 0],
            "acted": step.action[:, 0] + 0.1 * step.before.action[:, 0],
        }

    lengths, actions = (3, 2), np.arange(1.0, 25.0, dtype=np.float32).reshape(12, 2, 1) / 25
    env = harness.RecordVectorRewards(
        SyncVectorEnv([lambda length=length: counting(length, fresh=True) for length in lengths], autoreset_mode=mode),
        tmp_path / "batch", trained_with="own", rewards={"each": each, "whole": whole}, batched=["whole"],
    )  # fmt: skip
    taken = step_two(env, actions, mode)
    found = read_recording(tmp_path / "batch")
    for number, length in enumerate(lengths):
        single = harness.RecordRewards(
            counting(length), tmp_path / f"single{number}", trained_with="own", rewards={"each": each}
        )
        single.reset()
        for value in taken[number]:
            if single.step(np.array([value], np.float32))[2]:
                single.reset()
        single.close()
        alone, rows = read_recording(tmp_path / f"single{number}"), found["env"] == number
        for term, values in terms_of(alone, "each").items():
            assert found[f"reward/each/{term}"][rows].tolist() == values.tolist(), term
        for term in found.terms_of("whole"):
            assert found[f"reward/whole/{term}"][rows] == pytest.approx(alone[f"reward/each/{term}"], abs=1e-6)
        assert np.array_equal(
            sum_of({name: it[rows] for name, it in terms_of(found, "whole").items()}), found["reward/whole"][rows]
        )


def test_terms_are_paid_again(tmp_path):
    """A recording that is paid later has the terms too, in place of earlier ones of that reward."""
    live = _recorded(tmp_path / "live", 250, rewards={"gentle": gentle})
    _recorded(tmp_path / "plain", 250)
    for later in ({"gentle": lambda step: {"old": 1.0}}, {"gentle": gentle}):
        retake = Retake(lambda: gymnasium.make("Pendulum-v1"), lambda env, it=later: Later(it, {}))
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
