import json
import math

import gymnasium
import numpy as np
import pytest

import harness
from harness.errors import UsageError
from harness.record import read_recording

GIVEN = {"trained_with": "count", "seed": 3, "rewards": {"count": lambda before, action, after, info: float(after[0])}}


def still(observation):
    """A policy that does nothing."""
    return np.zeros(1, np.float32)


@pytest.fixture
def evaluated(counting, tmp_path):
    """The recording of an evaluation: of the counting env and a policy that does nothing, if no others are given."""

    def evaluate(env=None, path="it", policy=still, episodes=1, **given):
        harness.evaluate_policy(policy, env or counting(), tmp_path / path, episodes=episodes, **{**GIVEN, **given})
        return read_recording(tmp_path / path)

    return evaluate


def test_whole_episodes_of_a_policy_are_recorded(evaluated):
    """As many as asked for, marked as an evaluation of the training's seed."""
    found = evaluated(episodes=4, behaviour={"left": "left"})
    assert (found.facts.evaluation, found.facts.seed, found.facts.closed) == (True, 3, True)
    assert found["terminated"].sum() == 4
    assert found["reward/count"].tolist() == [1.0, 2.0, 3.0] * 4


def test_every_policy_meets_the_same_episodes(counting, tmp_path):
    """The env is reset with the same seeds, each once."""
    seeds = []

    class Told(counting):
        def reset(self, *, seed=None, options=None):
            seeds.append(seed)
            return super().reset(seed=seed, options=options)

    for name in "ab":
        harness.evaluate_policy(still, Told(), tmp_path / name, episodes=3, **GIVEN)
    assert seeds[:3] == seeds[3:]
    assert len(set(seeds)) == 3


def test_an_env_may_be_an_id(evaluated):
    """It is made, and closed."""
    found = evaluated("CartPole-v1", policy=lambda seen: 0, rewards={"count": lambda *step: 1.0})
    assert found.facts.env == "CartPole-v1"


def test_an_env_that_was_given_stays_open(counting, evaluated):
    """Another policy may use it."""
    env = counting()
    env.close = lambda: pytest.fail("it was closed")
    evaluated(env)


def test_what_the_env_pays_needs_not_be_what_taught(evaluated, recwarn):
    """Nothing learns from it: nobody is warned."""
    evaluated(rewards={"count": lambda *step: -1.0})
    assert not recwarn.list


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"episodes": 0}, "episodes=0: it takes one at least"),
        ({"horizon": 0}, "horizon=0: an episode has one step at least"),
        ({"env": "Nowhere-v0"}, "env='Nowhere-v0' cannot be made: "),
        ({"lower_is_better": ["left"]}, "lower_is_better names 'left', which is none of the measures"),
    ],
)
def test_what_cannot_be_used_is_refused(counting, tmp_path, given, told):
    """In a line, before anything is recorded."""
    with pytest.raises(UsageError, match=told.replace("[", r"\[")):
        harness.evaluate_policy(still, given.pop("env", counting()), tmp_path / "new", **{**GIVEN, **given})
    assert not (tmp_path / "new").exists()


def test_the_training_tells_its_seed(counting, tmp_path):
    """Where it is given, the first reset does not change it."""
    env = harness.RecordRewards(counting(), tmp_path, **GIVEN)
    env.reset(seed=77)
    env.close()
    assert read_recording(tmp_path).facts.seed == 3


def test_a_training_whose_end_was_evaluated_does_not_go_on(counting, tmp_path):
    """What its last policy did would be told of an earlier one. On the way it may be evaluated."""
    for after, policy in ((1, "early"), (0, "last")):
        with harness.RecordRewards(counting(), tmp_path, resume=True, **GIVEN) as env:
            env.reset()
            env.step(env.action_space.sample())
        harness.evaluate_policy(still, counting(), tmp_path / policy, episodes=1, after=after, **GIVEN)
    with pytest.raises(UsageError, match="/last' evaluates the policy that the training in"):
        harness.RecordRewards(counting(), tmp_path, resume=True, **GIVEN)


def test_what_is_better_of_measures_is_recorded(counting, tmp_path):
    """In the order of the measures."""
    behaviour = {"left": "left", "speed": lambda *step: 1.0, "height": lambda *step: 0.0, "success": "success"}
    told = {"lower_is_better": {"speed", "left"}, "higher_is_better": {"height"}}
    env = gymnasium.Wrapper(counting())
    harness.RecordRewards(env, tmp_path, behaviour=behaviour, **told, **GIVEN).close()
    facts = read_recording(tmp_path).facts
    assert (facts.lower_is_better, facts.higher_is_better) == (("left", "speed"), ("height",))


def test_the_learner_can_be_paid_by_a_recorded_reward(counting, tmp_path):
    """In place of what the env pays, which is recorded beside it."""
    given = {**GIVEN, "rewards": {"count": lambda before, action, after, info: -float(after[0]), "own": "own"}}
    env = harness.RecordRewards(counting(), tmp_path, pay=True, **given)
    env.reset()
    assert [env.step(still(None))[1] for _ in range(3)] == [-1.0, -2.0, -3.0]
    env.close()
    found = read_recording(tmp_path)
    assert found["reward/own"].tolist() == [1.0, 2.0, 3.0]
    assert (found.facts.paid_otherwise, found.facts.failures, found.facts.pay) == ("", (), True)


def test_a_batch_of_learners_can_be_paid_so(tmp_path):
    """An env that was only reset pays 0."""
    rewards = {"count": lambda before, action, after, info: -2.0}
    envs = gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode="sync", max_episode_steps=2)
    envs = harness.RecordVectorRewards(envs, tmp_path, trained_with="count", rewards=rewards, pay=True)
    envs.reset(seed=0)
    paid = [envs.step(envs.action_space.sample())[1].tolist() for _ in range(3)]
    envs.close()
    assert paid == [[-2.0, -2.0], [-2.0, -2.0], [0.0, 0.0]]


def test_a_reward_that_pays_the_learner_may_not_fail(counting, tmp_path):
    """There is nothing that could be paid in its place."""
    given = {**GIVEN, "rewards": {"count": lambda *step: 1 / 0}}
    env = harness.RecordRewards(counting(), tmp_path, pay=True, **given)
    env.reset()
    with pytest.raises(UsageError, match=r"division by zero\. It pays the learner, so the training cannot go on"):
        env.step(still(None))
    env.close()
    with pytest.raises(UsageError, match="failed before, and pays the learner: name another path"):
        harness.RecordRewards(counting(), tmp_path, pay=True, resume=True, **given)


def test_an_episode_that_nothing_ends_is_cut(counting, evaluated):
    """It is recorded as truncated, and counted; one that the env ends at the horizon is not."""
    found = evaluated(counting(length=10**6), episodes=2, horizon=5)
    assert (found.facts.horizon, found.facts.cut, found["terminated"].sum()) == (5, 2, 0)
    assert found["truncated"].tolist() == [False, False, False, False, True] * 2
    whole = evaluated(counting(length=5), "whole", episodes=2, horizon=5)
    assert (whole.facts.cut, whole["terminated"].sum(), whole["truncated"].sum()) == (0, 2, 0)


def test_by_default_an_episode_is_cut_after_ten_thousand_steps(counting, evaluated):
    """So that every evaluation ends."""
    assert len(evaluated(counting(length=10**6))) == 10_000


def test_what_is_not_asked_for_is_not_in_the_file(counting, tmp_path):
    """It is as it was before these facts were known."""
    harness.RecordRewards(counting(), tmp_path, **GIVEN).close()
    assert {"horizon", "cut", "bounds", "pay"}.isdisjoint(json.loads((tmp_path / "recording-0.json").read_text()))


def test_a_recording_that_goes_on_keeps_its_horizon(counting, tmp_path):
    """Cut episodes are counted on; another horizon would be another recording."""
    for _ in range(2):
        env = harness.RecordRewards(counting(length=10**6), tmp_path, horizon=1, resume=True, **GIVEN)
        env.reset()
        env.step(still(None))
        env.close()
    assert read_recording(tmp_path).facts.cut == 2
    with pytest.raises(UsageError, match="its horizon differ: 1, now 3"):
        harness.RecordRewards(counting(), tmp_path, horizon=3, resume=True, **GIVEN)


def test_bounds_of_measures_are_recorded(evaluated, tmp_path):
    """Infinite ones too, which JSON has not."""
    bounds = {"left": (0, math.inf), "success": (0.0, 1.0)}
    found = evaluated(behaviour={"left": "left", "success": lambda *step: 0.5}, bounds=bounds)
    assert found.facts.bounds == bounds
    assert json.loads((tmp_path / "it" / "recording-0.json").read_text())["bounds"]["left"] == [0.0, None]


def test_the_folder_gets_its_name_when_all_episodes_are_there(counting, tmp_path):
    """Until then it grows beside it, and says how many were asked for; the next evaluation takes its place."""
    path, seen = tmp_path / "evaluation", []

    def leave(observation):
        seen.append(path.exists())
        if len(seen) > 7:
            raise OSError("the power went")
        return still(observation)

    with pytest.raises(OSError, match="the power went"):
        harness.evaluate_policy(leave, counting(), path, episodes=4, **GIVEN)
    assert not any(seen)
    left = read_recording(tmp_path / ".evaluation.partial")
    assert (left.facts.episodes_asked, left["terminated"].sum()) == (4, 2)
    harness.evaluate_policy(still, counting(), path, episodes=4, **GIVEN)
    assert [it.name for it in tmp_path.iterdir()] == ["evaluation"]
    assert read_recording(path)["terminated"].sum() == 4


def test_what_lies_in_the_folder_stays(evaluated, tmp_path):
    """A model beside the recording, for one."""
    (tmp_path / "it").mkdir()
    (tmp_path / "it" / "model.zip").write_text("weights")
    assert evaluated().facts.closed
    assert (tmp_path / "it" / "model.zip").read_text() == "weights"
    assert [path.name for path in tmp_path.iterdir()] == ["it"]


def test_an_evaluation_at_work_is_left_alone(evaluated):
    """Another one of the same name is refused, and the first one ends as if it had not been asked for."""

    def meanwhile(observation):
        with pytest.raises(UsageError, match="is being recorded by another process"):
            evaluated()
        return still(observation)

    assert evaluated(policy=meanwhile).facts.closed


def test_the_first_observations_are_summed_up(counting, evaluated):
    """Two envs that the seed decides sum up to the same; one with a generator of its own to something else."""

    class Seeded(counting):
        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            return self.np_random.random(1, np.float32), {}

    class Own(counting):
        generator = np.random.default_rng(0)

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            return self.generator.random(1, np.float32), {}

    def starts(env, path, **given):
        return evaluated(env, path, episodes=3, **given).facts.starts

    assert starts(Seeded(), "a") == starts(Seeded(), "b") != 0
    assert starts(Seeded(), "c", first_seed=7) != starts(Seeded(), "d")
    assert starts(Own(), "e") != starts(Own(), "f")


def test_normalised_observations_say_nothing_of_starts(counting, evaluated):
    """Equal starts look different after other steps."""
    env = gymnasium.wrappers.NormalizeObservation(counting())
    env.update_running_mean = False
    assert evaluated(env, episodes=3).facts.starts == 0
