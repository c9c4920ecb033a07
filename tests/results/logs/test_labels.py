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


def test_a_label_for_each_training(found, tmp_path):
    """By its reward and seed, or by its path: it stands as the final policy's only episode."""
    (tmp_path / "l.csv").write_text("run,success\nbase/0,0\nbase/1.csv,1\narp/0,true\narp/1,1\n")
    runs = runs_of(labelled(found, RUNS, tmp_path / "l.csv"))
    told = {key: run.evaluation.whole.behaviour["success"] for key, run in runs.members.items()}
    assert told == {("base", 0): 0.0, ("base", 1): 1.0, ("arp", 0): 1.0, ("arp", 1): 1.0}


def test_a_label_of_a_longer_training_counts(found, tmp_path):
    """Trainings seldom end with an episode: a label tells of the final policy, wherever the rows are cut."""
    shorter = replace(found.trainings[0], logs=(found.trainings[0].logs[0].part(slice(2)),))
    (tmp_path / "l.csv").write_text("run,success\nbase/0,0\nbase/1,0\narp/0,1\narp/1,1\n")
    runs = runs_of(labelled(Sorted((shorter, *found.trainings[1:]), ()), RUNS, tmp_path / "l.csv"))
    assert (runs.steps, {run.steps for run in runs.members.values()}) == (8, {8, 12})
    told = {key: run.evaluation.whole.behaviour["success"] for key, run in runs.members.items()}
    assert told == {("base", 0): 0.0, ("base", 1): 0.0, ("arp", 0): 1.0, ("arp", 1): 1.0}
    assert not any("of labels" in line for line in runs.said)


def test_a_label_counts_where_evaluations_alone_were_kept(found, tmp_path):
    """Which tell returns alone."""
    alone = [
        replace(it, logs=(replace(log, facts=replace(log.facts, evaluation=True)),))
        for it in found.trainings
        for log in it.logs
    ]
    (tmp_path / "l.csv").write_text("run,success\nbase/0,0\nbase/1,0\narp/0,1\narp/1,1\n")
    runs = runs_of(labelled(Sorted(tuple(alone), ()), RUNS, tmp_path / "l.csv"))
    assert [run.evaluation.whole.behaviour["success"] for run in runs.members.values()] == [0.0, 0.0, 1.0, 1.0]


def test_a_label_for_each_episode(found, tmp_path):
    """Every episode of every training, in any order."""
    rows = [
        f"{run},{episode},{int(episode == 2)}"
        for run in ("base/0", "base/1", "arp/0", "arp/1")
        for episode in (2, 0, 1)
    ]
    (tmp_path / "l.csv").write_text("run,episode,success\n" + "\n".join(rows))
    runs = runs_of(labelled(found, RUNS, tmp_path / "l.csv"))
    assert all(run.episodes.behaviour["success"].tolist() == [0.0, 0.0, 1.0] for run in runs.members.values())


def test_one_training_needs_no_name(found, tmp_path):
    """The file that is made for a data set: a line for each episode."""
    (tmp_path / "l.csv").write_text("episode,success\n0,1\n1,0\n2,-1\n")
    (training,) = labelled(Sorted(found.trainings[:1], ()), RUNS, tmp_path / "l.csv").trainings
    np.testing.assert_array_equal(training.logs[0]["behaviour/success"], [1.0, 0.0, np.nan])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("run,success\nbase/0,1\n", "says nothing of 3 of 4 trainings, such as '/runs/base/1.csv'"),
        ("run,success\nbase/9,1\n", "no training is called 'base/9'; they are called 'base/0'"),
        ("seed,success\n0,1\n", "it needs run and success"),
        ("run,success\nbase/0,0.4\n", "0.4"),
        ("run,success\nbase/0,0\nbase/0,1\n", "line 3: 'base/0' has another label above"),
        ("run,episode,success\nbase/0,x,0\n", "'x' is no number of an episode"),
    ],
)
def test_labels_that_do_not_fit_are_refused(found, tmp_path, text, told):
    """A training without a label, an unknown one, a probability, a contradiction: the message says which."""
    (tmp_path / "l.csv").write_text(text)
    with pytest.raises(UsageError) as refused:
        labelled(found, RUNS, tmp_path / "l.csv")
    assert told in str(refused.value)


def test_labels_of_other_episodes_are_refused(found, tmp_path):
    """Two labels for three episodes: which one lacks it is told."""
    rows = [f"{run},{episode},0" for run in ("base/0", "base/1", "arp/0", "arp/1") for episode in (0, 1)]
    (tmp_path / "l.csv").write_text("run,episode,success\n" + "\n".join(rows))
    with pytest.raises(UsageError, match=r"lacks episode 2 of '/runs/base/0.csv', which has 3"):
        labelled(found, RUNS, tmp_path / "l.csv")
