from dataclasses import replace
from itertools import starmap
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.errors import SchemaError, UsageError
from harness.log import LogFacts, in_memory
from harness.results.logs.read_logs import runs_of
from harness.results.logs.told import Deciding
from harness.results.logs.trainings import Sorted, Training

LENGTHS = (("base", 20), ("arp", 10))
PAY, SUCCESS = "reward/recorded", "behaviour/success"


def episodes(name, count=10, length=5, **columns):
    """A log of episodes, each of so many steps."""
    told = {
        key: columns.pop(key)
        for key in ("unit", "env", "algorithm", "declared", "asked", "thinned", "format")
        if key in columns
    }
    facts = LogFacts(path=Path("/runs") / name, **{"format": "Monitor", "unit": "episode", **told})
    rows = {"time": np.arange(1.0, count + 1) * length, "length": np.full(count, float(length))}
    return in_memory(facts, {**rows, PAY: np.arange(float(count)), **columns})


def of(reward, seed, *, evaluation=None, **more):
    """A training of such a log."""
    return Training(reward, seed, (episodes(f"{reward}{seed}", **more),), evaluation)


def runs(*found, deciding=None, **more):
    """The runs of trainings."""
    given = () if deciding is None else (deciding,)
    return runs_of(Sorted(found, ()), *given, **more)


def pair(**more):
    """Two trainings of two rewards each."""
    return [of(name, seed, **more) for name in ("base", "arp") for seed in range(2)]


def evaluations(name, **columns):
    """A log of evaluations."""
    told = LogFacts(path=Path(f"/runs/{name}.npz"), format="E", unit="episode", evaluation=True)
    return in_memory(told, {key: np.asarray(values, float) for key, values in columns.items()})


def test_a_training_is_cut_to_the_shortest():
    """Episodes that ended later count for nothing, and the note tells whose budget it was."""
    long, short = (of(name, 0, count=count, **{SUCCESS: np.repeat([0.0, 1.0], count // 2)}) for name, count in LENGTHS)
    found = runs(long, short)
    assert found.steps == 50
    assert found.members["base", 0].parts(50)["over the training"].behaviour["success"] == 0.0
    assert found.members["arp", 0].parts(50)["in its last fifth"].behaviour["success"] == 1.0
    assert any("All are cut to the 50 steps of the shortest, '/runs/arp0'" in line for line in found.said)


@given(st.lists(st.integers(5, 6), min_size=2, max_size=4))
def test_environments_of_a_batch_are_one_training(counts):
    """Their episodes in the order in which they ended, at as many steps as all of them took together."""
    logs = [
        episodes(f"run/{env}.monitor.csv", count, **{SUCCESS: np.full(count, env % 2.0)})
        for env, count in enumerate(counts)
    ]
    run = runs(Training("base", 0, tuple(logs))).members["base", 0]
    ends = sorted(5.0 * number * len(counts) for count in counts for number in range(1, count + 1))
    assert (run.episodes.last + 1).tolist() == ends
    assert run.steps == 5 * max(counts) * len(counts)


def evaluated(reward, seed):
    """Of ten episodes of 5 steps each, evaluated after 20, 40 and 60 steps."""
    at = {"time": np.repeat([20.0, 40.0, 60.0], 2), SUCCESS: [0, 0, 1, 0, 1, 1]}
    return of(reward, seed, evaluation=evaluations("e", **at))


BESIDE = [("base", 1), ("arp", 0), ("arp", 1)]


def test_evaluations_stand_beside_the_training_that_they_belong_to():
    """The last one up to the shortest budget counts as the final policy's; those before it are moments."""
    found = runs(of("base", 0), *starmap(evaluated, BESIDE))
    run = found.members["base", 1]
    assert run.evaluation.whole.behaviour == {"success": 0.5}
    moments = replace(run, cut=found.steps).moments
    assert [(it.steps, it.values["success"]) for it in moments] == [(20, 0.0), (50, 0.5)]
    assert found.group.evaluation_episodes == 2
    assert found.counted["in evaluations"] == ("episode", (40, 40))


def test_a_policy_that_was_evaluated_later_was_trained_for_longer():
    """The last episode had not ended, and has no row: the evaluation at the end is the final policy's."""
    found = runs(*starmap(evaluated, [("base", 0), *BESIDE]))
    assert (found.steps, found.group.evaluate_every) == (60, 20)
    assert {run.evaluation.whole.behaviour["success"] for run in found.members.values()} == {1.0}
    assert found.counted == {"in evaluations": ("episode", None)}
    assert not any("cut to" in line for line in found.said)


def test_trainings_that_do_not_tell_success_are_counted():
    """Not their files: evaluations of a training tell it too."""
    found = runs(evaluated("base", 0), of("base", 1), *starmap(evaluated, BESIDE[1:]))
    assert "success decides, which 1 of 4 trainings do not tell" in found.said[0]


def test_returns_decide_where_one_reward_paid_all():
    """Only the user can know that; then more is better."""
    found = runs(*pair(), deciding=Deciding("return"))
    assert (found.measures, found.offered) == (("return", "length"), ("length",))
    assert found.members["base", 0].whole.behaviour["return"] == pytest.approx(4.5)


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
    base = [of("base", seed, env="Toy-v0", algorithm="PPO") for seed in range(2)]
    with pytest.raises(UsageError, match=told) as refused:
        runs(*base, *(of("arp", seed, **other) for seed in range(2)))
    assert "/runs/arp0" in str(refused.value)


def test_several_logs_of_the_steps_of_one_training_are_refused():
    """Nothing says in which order their steps were taken, and the first alone would be another training."""
    logs = tuple(episodes(name, unit="step") for name in ("first", "second"))
    with pytest.raises(UsageError, match="has 2 logs of the steps of one training, which are not joined"):
        runs(Training("base", 0, logs))


@pytest.mark.parametrize(
    "short",
    [
        {"declared": {"episodes": 12}},
        {"asked": 100},
        {"declared": {"steps": 100}},
        {"count": 9},
        {SUCCESS: np.array([*[1.0] * 9, np.nan])},
    ],
)
def test_a_training_that_lacks_what_it_declares_is_missing(short):
    """Twelve episodes are promised and ten are there, or fewer than beside it; or its success is no number at last."""
    told = {SUCCESS: np.ones(10)}
    found = runs(
        of("base", 0, **told),
        of("base", 1, **told),
        of("base", 2, **{**told, **short, SUCCESS: short.get(SUCCESS, np.ones(short.get("count", 10)))}),
    )
    assert [seed for _, seed in found.members] == [0, 1]
    assert [it.path.name for it in found.missing] == ["base2"]
    assert any(line.startswith("'/runs/base2' is missing: ") for line in found.said)
    assert any("--leave-out '/runs/base2' leaves it out" in line for line in found.said)


def test_the_last_episode_need_not_end_with_the_training():
    """A budget of 52 steps and episodes of 5: the one that had not ended is no row."""
    assert len(runs(of("base", 0, asked=52)).members) == 1


@pytest.mark.parametrize("times", [np.tile([5.0, 10.0, 15.0, 20.0, 25.0], 2), 1.7e18 + 1e9 * np.arange(10)])
def test_rows_out_of_order_are_damage(times):
    """Steps that go back say that two trainings were written into one file; a clock counts none."""
    log = episodes("twice").add({"time": times})
    with pytest.raises(SchemaError, match="/runs/twice: its rows are not in the order of their steps"):
        runs(Training("base", 0, (log,)))


def test_logs_without_steps_are_counted_in_episodes():
    """Nobody told lengths: the budget is a number of episodes. One that has fewer than another one is missing."""
    facts = LogFacts(path=Path("/runs/x"), format="T", unit="episode")
    logs = [in_memory(facts, {PAY: np.arange(float(count))}) for count in (4, 6)]
    found = runs(*(Training("base", seed, (log,)) for seed, log in enumerate(logs)))
    assert found.steps == 6
    assert [it.why for it in found.missing] == ["it ends after 4 episodes, and another one of base after 6"]
