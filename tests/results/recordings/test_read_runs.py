"""Recordings below a folder: which training each evaluation belongs to, and what does not belong there."""

from dataclasses import replace

import pytest

from harness.errors import UsageError
from harness.record import TrainingFacts
from harness.record.recording.recorded_training import facts_name
from harness.results.logs.told import Told
from harness.results.recordings.recordings import read_all, read_runs
from tests.results.recordings.conftest import PAYS, PULLS, record


def evaluated(folder, acted, after):
    """A training by each reward, and one evaluation of both policies."""
    for reward in PAYS:
        record(folder / reward, reward, 0, [0.1, 0.2, 0.3])
        record(folder / reward / "evaluation", reward, 0, [0.5] * 3, evaluation=True, acted=acted, after=after)
    return folder


@pytest.mark.parametrize("after", [1, 2, 1000])
def test_an_evaluation_during_the_training_is_no_final_one(tmp_path, after):
    """However early it was: after one step too."""
    run = read_runs(evaluated(tmp_path, "deterministic", after)).members["plain", 0]
    assert (run.evaluation, run.other) == (None, None)
    assert [it.facts.after for it in run.before] == [after]


@pytest.mark.parametrize("acted", ["deterministic", "stochastic"])
def test_one_manner_alone_decides(tmp_path, acted):
    """Where the policy was evaluated in no other."""
    run = read_runs(evaluated(tmp_path, acted, 0)).members["plain", 0]
    assert run.evaluation is not None
    assert run.evaluation.facts.acted == acted
    assert run.other is None


def test_an_experiment_itself_is_read(tmp_path):
    """Its own plan lies in the folder, not below it."""
    record(tmp_path / "cells" / "one", "plain", 0, [0.1])
    (tmp_path / "plan.json").touch()
    runs, damaged = read_all(tmp_path)
    assert (len(runs), damaged) == (1, [])


def told(folder):
    """The notes on the recordings."""
    return "\n".join(read_runs(folder).notes)


def test_an_evaluation_that_was_cut_off_does_not_count(tmp_path):
    """It is told by name, and how much of it there is; a whole one counts."""
    evaluated(tmp_path, "deterministic", 0)
    assert "left out" not in told(tmp_path)
    cut = record(tmp_path / "plain" / ".evaluation.partial", "plain", 0, [0.5] * 3, evaluation=True, episodes_asked=20)
    assert f"'{cut}' is left out: it has 3 of 20 episodes. It ended early" in told(tmp_path)
    assert read_runs(tmp_path).members["plain", 0].evaluation is not None
    record(tmp_path / "thrice" / "killed", "thrice", 0, [0.5], evaluation=True, episodes_asked=2, after=5)
    (missing,) = read_runs(tmp_path).missing
    assert (missing.path, "it has 1 of 2 episodes" in missing.why) == (tmp_path / "thrice", True)
    whole = record(tmp_path / "thrice" / "whole", "thrice", 0, [0.5] * 2, evaluation=True, episodes_asked=2, after=5)
    assert [run.path for run in read_runs(tmp_path).members["thrice", 0].before] == [whole]


def test_a_training_that_was_cut_off_is_not_compared(tmp_path):
    """Nor is its evaluation, and it is missing; a repetition with the same seed takes its place."""
    evaluated(tmp_path, "deterministic", 0)
    short = record(tmp_path / "thrice" / "2", "thrice", 2, [0.1], asked=15)
    record(tmp_path / "thrice" / "2" / "evaluation", "thrice", 2, [0.5], evaluation=True)
    assert f"'{short}' is missing: it has 5 of 15 steps" in told(tmp_path)
    assert [it.path for it in read_runs(tmp_path).missing] == [short]
    assert not read_runs(tmp_path, told=Told(leave_out=(short,))).missing
    assert ("thrice", 2) not in read_runs(tmp_path).members
    record(tmp_path / "thrice" / "again", "thrice", 2, [0.1] * 3, asked=15)
    assert read_runs(tmp_path).members["thrice", 2].evaluation is not None


def test_where_nothing_whole_is_left_the_reasons_are_told(tmp_path):
    """In the line that says that there is nothing to report."""
    record(tmp_path / "plain", "plain", 0, [0.1], closed=False, asked=15)
    record(tmp_path / "thrice", "thrice", 0, [0.1], asked=15)
    with pytest.raises(UsageError, match=r"nothing to report.* it has 5 of 15 steps\. It ended early"):
        read_runs(tmp_path)


def test_an_old_evaluation_that_was_never_closed_is_missing(tmp_path):
    """How many episodes it was to have is not known."""
    evaluated(tmp_path, "deterministic", 0)
    facts = tmp_path / "plain" / "evaluation" / facts_name(0)
    replace(TrainingFacts.read(facts), closed=False).write(facts)
    assert "evaluation': it is still going on, or was killed" in told(tmp_path)


def test_trainings_of_unequal_length_are_told_with_what_evaluates_them(tmp_path):
    """They are cut to the shortest, and their evaluations cannot be."""
    evaluated(tmp_path, "deterministic", 0)
    for seed, episodes in ((0, 3), (1, 4)):  # each has all that was asked for
        record(tmp_path / f"long-{seed}", "plain", 1 + seed, [0.1] * episodes, asked=episodes * PULLS)
    facts = tmp_path / "plain" / facts_name(0)
    replace(TrainingFacts.read(facts), asked=15).write(facts)
    assert "All are cut to the 15 steps of the shortest" in told(tmp_path)
    assert "which were not of one length" in told(tmp_path)


@pytest.mark.parametrize(("other", "episodes", "is_told"), [(7, 3, False), (8, 3, True), (8, 2, False)])
def test_policies_that_met_other_starts_are_told(tmp_path, other, episodes, is_told):
    """Where as many episodes began otherwise."""
    for reward, starts, count in (("plain", 7, 3), ("thrice", other, episodes)):
        record(tmp_path / reward, reward, 0, [0.1, 0.2, 0.3])
        record(tmp_path / reward / "evaluation", reward, 0, [0.5] * count, evaluation=True, starts=starts)
    assert ("did not meet the same starts" in told(tmp_path)) is is_told
