from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.errors import SchemaError, UsageError
from harness.log import LogFacts, in_memory
from harness.results.logs.read_logs import runs_of
from harness.results.logs.told import Deciding, parse_deciding
from harness.results.logs.trainings import Sorted, Training

PAY, SUCCESS = "reward/recorded", "behaviour/success"


def episodes(name: str, count: int = 10, length: int = 5, **columns):
    """A log of episodes, each of so many steps."""
    told = {
        key: columns.pop(key)
        for key in ("unit", "env", "algorithm", "declared", "asked", "thinned", "format")
        if key in columns
    }
    facts = LogFacts(path=Path("/runs") / name, **{"format": "Monitor", "unit": "episode", **told})
    rows = {"time": np.arange(1.0, count + 1) * length, "length": np.full(count, float(length))}
    return in_memory(facts, {**rows, PAY: np.arange(float(count)), **columns})


def trainings(*of: Training) -> Sorted:
    """They, sorted."""
    return Sorted(of, ())


def pair(**columns) -> Sorted:
    """Two trainings of two rewards each, with these columns."""
    return trainings(
        *(
            Training(name, seed, (episodes(f"{name}{seed}", **columns),))
            for name in ("base", "arp")
            for seed in range(2)
        )
    )


def test_a_training_is_cut_to_the_shortest():
    """Episodes that ended later count for nothing, and the note tells whose budget it was."""
    long = episodes("long", 20, **{SUCCESS: np.repeat([0.0, 1.0], 10)})
    short = episodes("short", 10, **{SUCCESS: np.repeat([0.0, 1.0], 5)})
    runs = runs_of(trainings(Training("base", 0, (long,)), Training("arp", 0, (short,))), is_told=True)
    assert runs.steps == 50
    assert runs.members["base", 0].parts(runs.steps)["over the training"].behaviour["success"] == 0.0
    assert runs.members["arp", 0].parts(runs.steps)["in its last fifth"].behaviour["success"] == 1.0
    assert any("All are cut to the 50 steps of the shortest, '/runs/short'" in line for line in runs.said)


@given(st.lists(st.integers(1, 6), min_size=2, max_size=4))
def test_environments_of_a_batch_are_one_training(counts):
    """Their episodes in the order in which they ended, at as many steps as all of them took together."""
    logs = [
        episodes(f"run/{env}.monitor.csv", count, **{SUCCESS: np.full(count, env % 2.0)})
        for env, count in enumerate(counts)
    ]
    run = runs_of(trainings(Training("base", 0, tuple(logs))), is_told=True).members["base", 0]
    ends = sorted(5.0 * number * len(counts) for count in counts for number in range(1, count + 1))
    assert (run.episodes.last + 1).tolist() == ends
    assert run.steps == 5 * max(counts) * len(counts)


def evaluated(name: str, count: int = 10) -> Training:
    """Of so many episodes of 5 steps each, evaluated after 20, 40 and 60 steps."""
    at = {"time": np.repeat([20.0, 40.0, 60.0], 2), SUCCESS: np.array([0.0, 0, 1, 0, 1, 1])}
    facts = LogFacts(path=Path(f"/runs/{name}.npz"), format="E", unit="episode", evaluation=True)
    return Training(name[:-1], int(name[-1]), (episodes(name, count),), in_memory(facts, at))


def test_evaluations_stand_beside_the_training_that_they_belong_to():
    """The last one up to the shortest budget counts as the final policy's; those before it are moments."""
    short = Training("base", 0, (episodes("base0"),))
    runs = runs_of(trainings(short, *map(evaluated, ("base1", "arp0", "arp1"))))
    run = runs.members["base", 1]
    assert run.evaluation is not None
    assert run.evaluation.whole.behaviour == {"success": 0.5}
    assert [(it.steps, it.values["success"]) for it in run.moments(runs.steps)] == [(20, 0.0), (50, 0.5)]
    assert runs.group.evaluation_episodes == 2
    assert "As final count policies after 40 steps, which were evaluated last" in runs.said


def test_a_policy_that_was_evaluated_later_was_trained_for_longer():
    """The last episode had not ended, and has no row: the evaluation at the end is the final policy's."""
    runs = runs_of(trainings(*map(evaluated, ("base0", "base1", "arp0", "arp1"))))
    assert (runs.steps, runs.group.evaluate_every) == (60, 20)
    assert {key: run.evaluation.whole.behaviour["success"] for key, run in runs.members.items()} == dict.fromkeys(
        runs.members, 1.0
    )
    assert not any("As final" in line for line in runs.said)


def test_trainings_that_do_not_tell_success_are_counted():
    """Not their files: evaluations of a training tell it too."""
    silent = Training("base", 1, (episodes("base1"),))
    runs = runs_of(trainings(evaluated("base0"), silent, *map(evaluated, ("arp0", "arp1"))))
    assert "success decides, which 1 of 4 trainings do not tell" in runs.said[0]


def test_an_evaluation_after_the_last_episode_belongs_to_the_training():
    """All were trained for 60 steps, though their last episodes ended after 50: the final policy is that of 60."""
    at = {"time": np.array([30.0, 60.0]), SUCCESS: np.array([0.0, 1.0])}
    evaluation = in_memory(LogFacts(path=Path("/runs/e.npz"), format="E", unit="episode", evaluation=True), at)
    found = [
        Training(name, seed, (episodes(f"{name}{seed}"),), evaluation) for name in ("base", "arp") for seed in (0, 1)
    ]
    runs = runs_of(trainings(*found))
    assert runs.steps == 60
    assert runs.members["base", 0].evaluation.whole.behaviour == {"success": 1.0}
    assert not any("cut to" in line for line in runs.said)


def test_returns_of_two_rewards_are_not_compared():
    """Each reward paid its own trainings alone: no success, no verdict, and it is said first."""
    runs = runs_of(pair())
    assert runs.measures == ()
    assert "every reward has its own scale" in runs.returns_apart
    assert "only returns are told" in runs.said[0]
    assert "needs the reward of each environment step" in runs.notes[0]


def test_returns_decide_where_one_reward_paid_all():
    """Only the user can know that; then more is better."""
    runs = runs_of(pair(), Deciding("return"))
    assert runs.measures == ("return",)
    assert runs.members["base", 0].whole.behaviour["return"] == pytest.approx(4.5)


def test_what_decides_needs_a_direction():
    """Nobody knows whether long episodes are good; what the user says is believed."""
    with pytest.raises(UsageError, match="length:better=lower or better=higher"):
        runs_of(pair(), Deciding("length"))
    assert runs_of(pair(), parse_deciding("length:better=lower")).lower_is_better == {"length"}


def test_a_measure_without_a_direction_is_offered_and_does_not_decide():
    """A column that somebody kept, such as a distance, may be good or bad."""
    runs = runs_of(pair(**{"behaviour/distance": np.arange(10.0)}))
    assert runs.measures == ()
    assert "The logs tell `distance` too" in runs.said[0]


@pytest.mark.parametrize(
    ("other", "told"),
    [
        ({"env": "Hopper-v5"}, "mixes trainings in several envs: Toy-v0"),
        ({"env": "Toy-v0", "algorithm": "SAC"}, "mixes trainings by several algorithms: PPO"),
        ({"env": "Toy-v0", "unit": "point"}, "cannot compare logs of several kinds: episodes of Monitor"),
        ({"env": "Toy-v0", "format": "RLlib"}, "cannot compare logs of several kinds"),
        ({"env": "Toy-v0", "thinned": "means of 100"}, "cannot compare logs of several kinds"),
    ],
)
def test_unlike_trainings_are_refused(other, told):
    """Another env, algorithm, unit or program, or smoothed: the message names a file of each."""
    found = trainings(
        *(Training("base", seed, (episodes(f"b{seed}", env="Toy-v0", algorithm="PPO"),)) for seed in range(2)),
        *(Training("arp", seed, (episodes(f"a{seed}", **other),)) for seed in range(2)),
    )
    with pytest.raises(UsageError, match=told) as refused:
        runs_of(found)
    assert "/runs/a0" in str(refused.value)


def test_several_logs_of_the_steps_of_one_training_are_refused():
    """Nothing says in which order their steps were taken, and the first alone would be another training."""
    logs = tuple(episodes(name, unit="step") for name in ("first", "second"))
    with pytest.raises(UsageError, match="has 2 logs of the steps of one training, which are not joined"):
        runs_of(trainings(Training("base", 0, logs)), is_told=True)


def test_one_training_of_a_reward_is_refused_unless_it_was_named():
    """Names that were mistaken look like that; whoever named the files knows what they are."""
    found = trainings(*(Training(name, 0, (episodes(name),)) for name in ("base", "arp")))
    with pytest.raises(UsageError, match="one training alone of base and arp"):
        runs_of(found)
    assert len(runs_of(found, is_told=True).members) == 2


@pytest.mark.parametrize("short", [{"declared": {"episodes": 12}}, {"asked": 100}, {"declared": {"steps": 100}}])
def test_a_training_that_lacks_what_it_declares_is_left_out(short):
    """Twelve episodes are promised and ten are there, or half of the steps: it is told, and not compared."""
    whole = [Training("base", seed, (episodes(f"b{seed}"),)) for seed in range(2)]
    runs = runs_of(trainings(*whole, Training("base", 2, (episodes("short", **short),))))
    assert [seed for _, seed in runs.members] == [0, 1]
    assert any("'/runs/short' is left out: it has" in line for line in runs.said)


def test_the_last_episode_need_not_end_with_the_training():
    """A budget of 52 steps and episodes of 5: the one that had not ended is no row."""
    runs = runs_of(trainings(Training("base", 0, (episodes("b", asked=52),))))
    assert len(runs.members) == 1


def test_rows_out_of_order_are_damage():
    """Steps that go back say that two trainings were written into one file."""
    log = episodes("twice").add({"time": np.tile([5.0, 10.0, 15.0, 20.0, 25.0], 2)})
    with pytest.raises(SchemaError, match="/runs/twice: its rows are not in the order of their steps"):
        runs_of(trainings(Training("base", 0, (log,))))


def test_logs_without_steps_are_counted_in_episodes():
    """Nobody told lengths: the budget is a number of episodes."""
    facts = LogFacts(path=Path("/runs/x"), format="T", unit="episode")
    logs = [in_memory(facts, {PAY: np.arange(float(count))}) for count in (4, 6)]
    runs = runs_of(trainings(*(Training("base", seed, (log,)) for seed, log in enumerate(logs))))
    assert runs.steps == 4
    assert any("All are cut to the 4 episodes of the shortest" in line for line in runs.said)


def test_equal_trainings_of_two_rewards_are_told():
    """The same rows under both names: between them there is nothing to compare."""
    assert any("are equal bit for bit" in line for line in runs_of(pair()).said)


def test_evaluations_alone_are_trainings():
    """Nobody kept the episodes of the training: its length is that of its last evaluation, which decides."""
    at = {"time": np.repeat([20.0, 40.0], 2), SUCCESS: np.array([0.0, 0, 1, 0])}
    facts = [LogFacts(path=Path(f"/runs/{seed}.npz"), format="E", unit="episode", evaluation=True) for seed in range(2)]
    logs = [in_memory(it, {**at, PAY: np.full(4, float(seed))}) for seed, it in enumerate(facts)]
    runs = runs_of(trainings(*(Training("base", seed, (log,)) for seed, log in enumerate(logs))))
    assert runs.steps == 40
    parts = runs.members["base", 1].parts(runs.steps)
    assert parts["in evaluations"].behaviour == {"success": 0.5}
    assert parts["over the training"].episodes == 0
