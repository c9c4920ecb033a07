"""Trials, seed by seed."""

from typing import ClassVar

import pytest

from harness_plugins.tune.search import Searcher
from harness_plugins.tune.study import Study, open_storage
from harness_plugins.tune.trial import Outcome


class Bench:
    """Measures without training: success is what `effort` says; notes what was asked for."""

    def __init__(self, outcome=lambda cell: Outcome(dict(cell.algorithm.params)["effort"], 0.0)):
        self.outcome, self.stages = outcome, []

    def __call__(self, plan, cells):
        """One stage."""
        self.stages.append(list(cells))
        return {cell: self.outcome(cell) for cell in cells}

    @property
    def cells(self):
        """All that were asked for."""
        return [cell for stage in self.stages for cell in stage]


@pytest.fixture
def search(toys, make_setup, tmp_path):
    """Search with a bench; returns the trials. The same folder goes on where it stopped."""

    def run(bench, **keys):
        setup = make_setup(**keys)
        study = Study(open_storage(tmp_path), "s", setup.space, seed=setup.tuning.seed, pruner=setup.tuning.pruner)
        Searcher(setup, setup.rewards, study, toys, bench).run()
        return study.trials

    return run


def test_every_stage_trains_every_reward_alike(search):
    """Equal budget: in each stage each setting is trained with the same seed and steps under every reward."""
    bench = Bench()
    search(bench, trials=8, seeds=3, reward="arp,potential")
    for stage in bench.stages:
        by_reward = {}
        for cell in stage:
            by_reward.setdefault(cell.reward.label, []).append((cell.algorithm, cell.seed, cell.steps))
        assert set(by_reward) == {"baseline", "arp", "potential"}
        assert by_reward["baseline"] == by_reward["arp"] == by_reward["potential"]


def test_first_trial_is_the_algorithm_as_it_was_given(search):
    """So that the best is no worse; where the space does not hold it, all are drawn."""
    assert search(Bench(), algo="sweep:effort=0.3", trials=1)[0].params == {"effort": 0.3}


def test_first_trial_is_drawn_where_the_space_does_not_hold_the_given_one(search):
    """A setting out of the range is not tried."""
    assert 0.5 <= search(Bench(), search={"effort": "0.5..1"}, trials=1)[0].params["effort"] <= 1.0


def test_hopeless_trials_get_no_more_seeds(search):
    """Below the median after a seed: pruned, with the cells of that seed alone."""
    bench = Bench()
    trials = search(bench, trials=12, seeds=3)
    pruned = [trial for trial in trials if trial.status == "pruned"]
    assert pruned
    assert {trial.cells for trial in pruned} <= {2, 4}
    assert {trial.cells for trial in trials if trial.status == "complete"} == {6}
    assert len(bench.cells) == sum(trial.cells for trial in trials)


def test_without_a_pruner_every_trial_has_all_seeds(search):
    """Then the budgets are equal to the cell."""
    assert {trial.cells for trial in search(Bench(), trials=12, seeds=3, pruner="none")} == {6}


def test_failed_cell_fails_its_trial_alone(search):
    """With the reason, and no more seeds; the others go on."""

    def outcome(cell):
        effort = dict(cell.algorithm.params)["effort"]
        return "it fell off" if effort > 0.5 and cell.reward.label == "arp" else Outcome(effort, 0.0)

    trials = search(Bench(outcome), trials=8)
    failed = [trial for trial in trials if trial.status == "failed"]
    assert failed == [trial for trial in trials if trial.params["effort"] > 0.5]
    assert {trial.reason for trial in failed} == {"it fell off"}
    assert len(trials) == 8


@pytest.mark.parametrize(
    ("keys", "reason"),
    [
        ({"search": {"mode": "calm|wild", "turns": "6..9"}}, "wild with more than 5 turns"),
        ({"search": {"num_envs": "1|2|3"}, "steps": 4}, "steps=4 is not a multiple of the 3 envs"),
    ],
)
def test_settings_that_do_not_go_together_are_refused(search, keys, reason):
    """They cost a trial, no cell, and say why."""
    bench = Bench(lambda cell: Outcome(0.0, 0.0))
    refused = [trial for trial in search(bench, trials=10, **keys) if trial.status == "refused"]
    assert refused
    assert all(reason in trial.reason for trial in refused)
    assert {trial.cells for trial in refused} == {0}


def test_a_stop_in_any_stage_changes_nothing(search, tmp_path):
    """Stopped after every stage, a search has the trials that it has in one go; a batch is the same batch again."""
    keys = {"trials": 9, "batch": 2, "seeds": 2}
    whole = search(Bench(), **keys)
    (tmp_path / "study.log").unlink()

    class Stop(Exception):
        pass

    class Stopping(Bench):
        """Does one stage that was not done before."""

        done: ClassVar = set()

        def __call__(self, plan, cells):
            if len({cell.id for cell in self.cells} - self.done) > 0:
                raise Stop
            self.stages.append(list(cells))
            return {cell: self.outcome(cell) for cell in cells}

    stops = 0
    while True:
        bench = Stopping()
        try:
            trials = search(bench, **keys)
            break
        except Stop:
            stops += 1
            Stopping.done |= {cell.id for cell in bench.cells}
    assert stops > 8
    assert trials == whole


def test_batch_is_drawn_at_once(search):
    """Its cells are one stage, whatever their number at once."""
    bench = Bench()
    search(bench, trials=5, batch=2, seeds=1)
    assert [len({cell.algorithm for cell in stage}) for stage in bench.stages] == [2, 2, 1]


def test_more_trials_go_on_with_the_first(search):
    """What was done stays, and is not asked for again."""
    first = search(Bench(), trials=3)
    bench = Bench()
    both = search(bench, trials=5)
    assert both[:3] == first
    known = {trial.params["effort"] for trial in first}
    assert known.isdisjoint({dict(cell.algorithm.params)["effort"] for cell in bench.cells})
    assert len(bench.stages) == 2


def test_equal_behaviour_is_told_apart_by_the_distance(search):
    """Where no trial succeeds, the one that ends nearest is worth most."""
    bench = Bench(lambda cell: Outcome(0.0, 1.0 - dict(cell.algorithm.params)["effort"]))
    trials = search(bench, trials=6, pruner="none")
    assert max(trials, key=lambda trial: trial.value) == max(trials, key=lambda trial: trial.params["effort"])
