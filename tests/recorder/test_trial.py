"""Functions with a memory that nobody restarts are found in the first steps, and others are not."""

import random

import gymnasium
import numpy as np
import pytest

import harness
from harness.errors import UsageError
from harness.record import read_recording
from harness.recorder.recorder import GivenUp, Noted
from tests.recorder.conftest import ACTION, recorder, take

MEMORY = {}
GENERATOR = np.random.default_rng(0)


@pytest.fixture(autouse=True)
def forgotten():
    """The memory is empty."""
    MEMORY.update(count=0, best=-9.0, last=0.0, seen=[])


def counts(observation, action, next_observation, info):
    """How often anybody called it."""
    MEMORY["count"] += 1
    return float(MEMORY["count"])


def best(observation, action, next_observation, info):
    """The greatest so far: asked twice at once, it says the same."""
    MEMORY["best"] = max(MEMORY["best"], float(next_observation[0]))
    return MEMORY["best"]


def jumps(observation, action, next_observation, info):
    """The change since the call before."""
    change, MEMORY["last"] = float(next_observation[0]) - MEMORY["last"], float(next_observation[0])
    return change


def since_first(observation, action, next_observation, info):
    """The change since the first call of all: asked again from the first step on, it says the same."""
    if not MEMORY["seen"]:
        MEMORY["seen"].append(float(next_observation[0]))
    return float(next_observation[0]) - MEMORY["seen"][0]


def since_default(observation, action, next_observation, info, seen=[]):  # noqa: B006
    """The same, in a default."""
    seen += [] if seen else [float(next_observation[0])]
    return float(next_observation[0]) - seen[0]


def since_attribute(observation, action, next_observation, info):
    """The same, in an attribute of its own."""
    if not hasattr(since_attribute, "seen"):
        since_attribute.seen = float(next_observation[0])  # type: ignore[attr-defined] # that is the fault
    return float(next_observation[0]) - since_attribute.seen  # type: ignore[attr-defined]


TABLE = {}


def remembers_answers(observation, action, next_observation, info):
    """Keeps what it has computed, and says what it would say anyway."""
    return TABLE.setdefault(float(next_observation[0]), 2.0 * float(next_observation[0]))


def noisy(observation, action, next_observation, info):
    """A draw from a generator of its own that nobody restarts."""
    return float(GENERATOR.random())


class Change:
    """The change since the call before, without ``reset()``: the first answer is 0, asked once or twice."""

    last = None

    def __call__(self, observation, action, next_observation, info):
        """The change."""
        last, self.last = self.last, float(next_observation[0])
        return 0.0 if last is None else self.last - last


class Shared:
    """Keeps its sum in the class, so that all copies have one."""

    total = 0.0

    def reset(self):
        """Begin anew."""
        type(self).total = 0.0

    def __call__(self, observation, action, next_observation, info):
        """The sum of what was seen."""
        type(self).total += float(next_observation[0])
        return self.total


class Beside:
    """Keeps its sum in the class, where no ``reset()`` sees it."""

    sums = [0.0]  # noqa: RUF012 # that is the fault

    def reset(self):
        """Begin nothing anew."""

    def __call__(self, observation, action, next_observation, info):
        """The sum of what was seen."""
        self.sums[0] += float(next_observation[0])
        return self.sums[0]


class Sums:
    """As it should be."""

    def reset(self):
        """Begin anew."""
        self.total, self.rng = 0.0, np.random.default_rng(3)

    def __call__(self, observation, action, next_observation, info):
        """The sum of what was seen, and noise of its own."""
        self.total += float(next_observation[0])
        return self.total + self.rng.normal()


class Begins:
    """Sets anew in its first step what the last episode has left, as an arm's reward for Unity does."""

    def reset(self):
        """An episode starts."""
        self.is_begun = False

    def __call__(self, observation, action, next_observation, info):
        """How much more than in the first step."""
        if not self.is_begun:
            self.first, self.is_begun = {"seen": np.asarray(next_observation)}, True
        return float(next_observation[0] - self.first["seen"][0])


class Curriculum(Sums):
    """Counts the steps of the training too."""

    def __init__(self) -> None:
        self.steps = 0

    def __call__(self, observation, action, next_observation, info):
        """Another reward after 50,000 steps."""
        self.steps += 1
        return float(next_observation[0]) if self.steps < 50_000 else 0.0


def _record(rewards, path, env, steps=7, **given):
    take(recorder([lambda: env], None, path, rewards=rewards, **given), [ACTION] * steps, None)
    return read_recording(path)


WRONG = {"counts": counts, "best": best, "jumps": jumps, "noisy": noisy, "no reset": Change(), "shared": Shared()}
WRONG |= {"beside": Beside(), "first": since_first, "default": since_default, "attribute": since_attribute}
WRONG |= {"of a step": lambda step: counts(step.observation, None, None, None)}
DRAWN = np.random.default_rng(3).normal(size=2)
RIGHT = {
    "kept answers, the same in every order": (remembers_answers, 4, 7, [2, 4, 6, 8, 2, 4, 6]),
    "told of each of many short episodes when asked again": (Sums(), 2, 150, [1 + DRAWN[0], 3 + DRAWN[1]] * 75),
    "set anew in the first step, though reset leaves it": (Begins(), 4, 120, [0, 1, 2, 3] * 30),
}


@pytest.mark.parametrize("name", WRONG)
def test_hidden_memory_is_named(counting, tmp_path, name):
    """In the first episode; it is given up, and what to write instead is said."""
    with pytest.warns(GivenUp, match=rf"reward '{name}' failed in env 0, episode 0, .*(a class with reset|Keep it in)"):
        found = _record({name: WRONG[name]}, tmp_path / "run", counting(4))
    assert np.isnan(found[f"reward/{name}"][4:]).all()
    assert found["reward/own"].tolist() == [1, 2, 3, 4, 1, 2, 3]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("reward", "length", "steps", "paid"), RIGHT.values(), ids=RIGHT)
def test_what_remembers_nothing_of_earlier_episodes_is_left_alone(counting, tmp_path, reward, length, steps, paid):
    """In whatever order it is asked."""
    found = _record({"it": reward}, tmp_path / "run", counting(length), steps)
    assert found["reward/it"].tolist() == paid


@pytest.mark.parametrize("name", ["counts", "best"])
def test_hidden_memory_does_not_pay(counting, tmp_path, name):
    """A learner that is paid by it would learn something else."""
    with pytest.raises(UsageError, match=r"a class with reset\(\).*It pays the learner"):
        _record({name: WRONG[name]}, tmp_path / "run", counting(4), trained_with=name, pay=True)


def test_trial_ends_with_the_recording(counting, tmp_path):
    """In the middle of the first episode."""
    with pytest.warns(GivenUp, match="reward 'best' failed"):
        _record({"best": best}, tmp_path / "run", counting(99), 3)


def test_first_episode_of_one_step_is_not_all_that_is_tried(counting, tmp_path):
    """The first hundred steps are, in as many episodes as that takes."""
    env = gymnasium.wrappers.TransformObservation(counting(1), lambda seen: seen + next(steps), None)
    steps = iter(range(100))
    with pytest.warns(GivenUp, match="reward 'change' failed in env 0, episode 1, step 0"):
        _record({"change": Change()}, tmp_path / "run", env)


def test_memory_that_shows_late_is_told_at_the_end(counting, tmp_path):
    """A curriculum in a global: its first steps are paid otherwise then. The training is over, and nothing is lost."""

    def stages(observation, action, next_observation, info):
        MEMORY["count"] += 1
        return 1.0 if MEMORY["count"] < 450 else 0.5

    with pytest.warns(Noted, match="reward 'stages': it said 1, and said 0.5 when it was asked about step 0"):
        found = _record({"stages": stages}, tmp_path / "run", counting(4), 300, trained_with="stages", pay=True)
    assert np.isfinite(found["reward/stages"]).all()


def test_memory_in_a_batch_is_found_in_its_first_step(tmp_path):
    """One function for all envs remembers what others did."""
    envs = gymnasium.make_vec("CartPole-v1", num_envs=3, vectorization_mode="sync")
    recorded = harness.RecordVectorRewards(
        envs, tmp_path / "run", trained_with="own", rewards={"jumps": jumps, "all": _all_sum}, batched=["all"]
    )
    recorded.reset(seed=0)
    with pytest.warns(GivenUp) as told:
        recorded.step(np.zeros(3, np.int64))
    recorded.close()
    assert sorted(str(it.message).split("'")[1] for it in told) == ["all", "jumps"]
    assert np.isnan(read_recording(tmp_path / "run")["reward/jumps"]).all()


def _all_sum(observations, actions, next_observations, infos):
    MEMORY["count"] += 1
    return np.full(len(actions), MEMORY["count"])


@pytest.mark.filterwarnings("error")
def test_memory_with_reset_is_no_hidden_memory(counting, tmp_path):
    """Nor is a function, nor one that says NaN, nor one that looks at the env."""
    env = counting(4)
    right = {
        "sums": Sums(),
        "count": lambda s, a, n, i: env.count,
        "gain": lambda s, a, n, i: n[0] - s[0],
        "tiny": lambda s, a, n, i: 1e-12 * np.float32(n[0]),
    }
    found = _record(right, tmp_path / "run", env)
    assert (found.facts.failures, found.facts.notes) == ((), ())
    assert found["reward/count"].tolist() == [1, 2, 3, 4, 1, 2, 3]


def test_memory_beyond_reset_is_told(counting, tmp_path):
    """It is recorded as it pays; an evaluation starts it anew, and can be given the object that was trained with."""
    env = harness.RecordRewards(counting(4), tmp_path / "run", trained_with="own", rewards={"stages": Curriculum()})
    env.reset(seed=0)
    with pytest.warns(Noted, match=r"reward 'stages': it remembers something beyond reset\(\)"):
        _ = [env.step(ACTION) for _ in range(4)]
    env.close()
    (note,) = read_recording(tmp_path / "run").facts.notes
    assert note.startswith("reward 'stages'")
    assert env.functions["stages"].steps == 4


@pytest.mark.filterwarnings("ignore::harness.recorder.recorder.Noted")
def test_evaluation_goes_on_with_the_memory_of_the_training(counting, tmp_path):
    """Given the trained env's object, and a copy of it counts on; without it, from 0."""
    stages = Curriculum()
    env = harness.RecordRewards(counting(4), tmp_path / "run", trained_with="own", rewards={"stages": stages})
    env.functions["stages"].steps = 50_000
    for name, given in (("new", stages), ("trained", env.functions["stages"])):
        harness.evaluate_policy(
            lambda seen: ACTION, counting(4), tmp_path / name, trained_with="own", seed=0, rewards={"stages": given},
            episodes=1,
        )  # fmt: skip
    paid = {name: read_recording(tmp_path / name)["reward/stages"].tolist() for name in ("new", "trained")}
    assert paid == {"new": [1, 2, 3, 4], "trained": [0, 0, 0, 0]}


def _late(observation, action, next_observation, info):
    return float(next_observation[0] if next_observation[0] < 1_000 else next_observation[0] + np.random.rand())


def test_draw_in_a_late_step_does_not_reach_the_training(counting, tmp_path):
    """It is named, with the step; the learner draws what it would have drawn."""
    np.random.seed(4), random.seed(4)
    right = np.random.rand(), random.random()
    np.random.seed(4), random.seed(4)
    with pytest.warns(Noted, match=r"reward 'late': it draws from numpy.random, first in env 0, episode 0, step 999"):
        found = _record({"late": _late}, tmp_path / "run", counting(2_000), 1_001)
    assert (np.random.rand(), random.random()) == right
    assert np.isfinite(found["reward/late"]).all()
    assert found.facts.notes[0].startswith("reward 'late': it draws")


def test_late_draw_of_a_reward_that_pays_is_named_too(counting, tmp_path):
    """It is asked alone by then."""
    with pytest.warns(Noted, match="first in env 0, episode 0, step 999. It pays the learner"):
        _record({"late": _late}, tmp_path / "run", counting(2_000), 1_001, trained_with="late", pay=True)


def test_draw_of_a_reward_that_pays_is_part_of_the_training(counting, tmp_path):
    """It is named, and drawn once for each step."""
    paid = {"drawn": lambda s, a, n, i: random.random()}
    random.seed(4)
    right = [random.random() for _ in range(5)]
    random.seed(4)
    with pytest.warns(Noted, match="It pays the learner, so this is part of the training"):
        found = _record(paid, tmp_path / "run", counting(9), 4, trained_with="drawn", pay=True)
    assert [*found["reward/drawn"], random.random()] == right


def test_order_of_functions_does_not_matter(counting, tmp_path):
    """Those that spoil what they are given, and those that do not: the same numbers in each order."""

    def halves(observation, action, next_observation, info):
        action /= 2
        return 0.0

    rewards = {
        "halves": halves,
        "pops": lambda s, a, n, i: float(i.pop("left")),
        "reads": lambda s, a, n, i: float(a[0] + i["left"] + n[0]),
    }
    found = []
    for number, names in enumerate((sorted(rewards), sorted(rewards)[::-1])):
        with pytest.warns(GivenUp) as told:
            one = _record({name: rewards[name] for name in names}, tmp_path / str(number), counting(4))
        assert sorted(str(it.message).split("'")[1] for it in told) == ["halves", "pops"]
        assert any("it writes into its info, which others read too: change a copy" in str(it.message) for it in told)
        found.append(one["reward/reads"].tolist())
    assert found == [[4.5] * 7] * 2
    assert ACTION.tolist() == [0.5]
    assert ACTION.flags.writeable
