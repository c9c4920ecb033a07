from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.errors import UsageError
from harness.log import LogFacts, in_memory
from harness.results.logs.labels import labelled
from harness.results.logs.read_logs import runs_of
from harness.results.logs.trainings import Sorted, Training

RUNS = Path("/runs")
NAMES = ("base/0", "base/1", "arp/0", "arp/1")


@pytest.fixture
def found():
    """Two trainings of two rewards, three episodes each."""

    def log(name):
        facts = LogFacts(path=RUNS / name, format="Monitor", unit="episode")
        return in_memory(
            facts, {"time": np.array([4.0, 8.0, 12.0]), "reward/recorded": np.array([1.0, 2.0, len(name)])}
        )

    return Sorted(
        tuple(Training(name, seed, (log(f"{name}/{seed}.csv"),)) for name in ("base", "arp") for seed in range(2)), ()
    )


@pytest.fixture(name="label")
def _label(tmp_path):
    """Trainings with the labels of a table."""

    def read(header, rows, trainings):
        (tmp_path / "l.csv").write_text("\n".join([header, *rows, ""]))
        return labelled(Sorted(tuple(trainings), ()), RUNS, tmp_path / "l.csv")

    return read


def _told(runs):
    return [run.evaluation.whole.behaviour["success"] for run in runs.members.values()]


LAST = [f"{name},{success}" for name, success in zip(NAMES, (0, 0, 1, 1), strict=True)]


def test_a_label_for_each_training(found, label):
    """By its reward and seed, or by its path: it stands as the final policy's only episode."""
    runs = runs_of(label("run,success", ["base/0,0", "base/1.csv,1", "arp/0,true", "arp/1,1"], found.trainings))
    assert _told(runs) == [0.0, 1.0, 1.0, 1.0]


def test_a_label_of_a_longer_training_counts(found, label):
    """Trainings seldom end with an episode: a label tells of the final policy, wherever the rows are cut."""
    shorter = [replace(it, logs=(it.logs[0].part(slice(2)),)) if it.reward == "base" else it for it in found.trainings]
    runs = runs_of(label("run,success", LAST, shorter))
    assert (runs.steps, {run.steps for run in runs.members.values()}) == (8, {8, 12})
    assert _told(runs) == [0.0, 0.0, 1.0, 1.0]
    assert not any("of labels" in line for line in runs.said)


def test_a_label_counts_where_evaluations_alone_were_kept(found, label):
    """Which tell returns alone."""
    alone = [
        replace(it, logs=(replace(log, facts=replace(log.facts, evaluation=True)),))
        for it in found.trainings
        for log in it.logs
    ]
    assert _told(runs_of(label("run,success", LAST, alone))) == [0.0, 0.0, 1.0, 1.0]


def test_a_label_for_each_episode(found, label):
    """Every episode of every training, in any order."""
    rows = [f"{run},{episode},{int(episode == 2)}" for run in NAMES for episode in (2, 0, 1)]
    runs = runs_of(label("run,episode,success", rows, found.trainings))
    assert all(run.episodes.behaviour["success"].tolist() == [0.0, 0.0, 1.0] for run in runs.members.values())


def test_one_training_needs_no_name(found, label):
    """The file that is made for a data set: a line for each episode."""
    (training,) = label("episode,success", ["0,1", "1,0", "2,-1"], found.trainings[:1]).trainings
    np.testing.assert_array_equal(training.logs[0]["behaviour/success"], [1.0, 0.0, np.nan])


@pytest.mark.parametrize(
    ("header", "rows", "told"),
    [
        ("run,success", ["base/0,1"], "says nothing of 3 of 4 trainings, such as '/runs/base/1.csv'"),
        ("run,success", ["base/9,1"], "no training is called 'base/9'; they are called 'base/0'"),
        ("seed,success", ["0,1"], "it needs run and success"),
        ("run,success", ["base/0,0", "base/0,1"], "line 3: 'base/0' has another label above"),
        (
            "run,episode,success",
            [f"{run},{episode},0" for run in NAMES for episode in (0, 1)],
            "lacks episode 2 of '/runs/base/0.csv', which has 3",
        ),
        ("run,success", [*LAST, "base/0.csv,1"], "calls '/runs/base/0.csv' by two names"),
    ],
)
def test_labels_that_do_not_fit_are_refused(found, label, header, rows, told):
    """A training or an episode without a label, an unknown one, a probability, a contradiction: it says which."""
    with pytest.raises(UsageError) as refused:
        label(header, rows, found.trainings)
    assert told in str(refused.value)
