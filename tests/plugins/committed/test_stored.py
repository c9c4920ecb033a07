"""Comparisons as the records tell them."""

import json

from harness.report.document import report_to_json
from harness_plugins.committed.stored import comparison_of, learning_in, stored_comparisons

NOT_KEPT = ("noise", "p", "p_corrected")
"""What no figure shows."""


def stored(results):
    """The only combination, and what its record says of it."""
    (combination,) = results.combinations
    (told,) = stored_comparisons(json.loads(json.dumps(report_to_json(results))))
    return combination, told


def shown(split):
    """What figures show of a split."""
    return {name: value for name, value in split.to_json().items() if name not in NOT_KEPT}


def test_numbers_are_those_of_the_results(build):
    """Every ratio of both etas with its interval and remarks, the indices, the labels."""
    combination, told = stored(build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=2))
    again = comparison_of(told, combination.manner)
    for name, split in combination.number.splits.items():
        assert shown(again.number.splits[name]) == shown(split)
        assert again.number.splits[name].eta.near_zero == split.eta.near_zero
    assert again.group.labels == combination.group.labels
    assert again.number.decomposition.baseline.crossover == combination.number.decomposition.baseline.crossover
    assert again.manner == combination.manner


def test_learning_is_that_of_the_results(build):
    """Every point with its interval."""
    results = build(learned={10: 1})
    combination, told = stored(results)
    assert learning_in(told).to_json()["metrics"] == results.learning(combination).to_json()["metrics"]


def test_nothing_finished_is_nothing(build):
    """Without a finished pair."""
    combination, told = stored(build(seeds=1, ended={("arp", 0): ("failed", "it broke")}))
    assert learning_in(told) is None
    assert comparison_of(told, combination.manner).number.decomposition is None


def test_version_1_told_learning_by_measure_alone():
    """In environments."""
    point = {"steps": 10, "mean": 0.5, "low": None, "high": None, "seeds": 1, "note": "one seed"}
    told = {"baseline": "a", "proposed": "b", "learning": {"success": {"baseline": [point], "proposed": [point]}}}
    learning = learning_in(told)
    assert (learning.proposed.reward, learning.random) == ("b", {"success": None})
    assert learning.baseline.points["success"][0].value.note == "one seed"


def test_version_1_told_what_each_reward_paid_each_training():
    """What a training's own reward paid it is one of these curves."""

    def points(mean):
        return [{"steps": 10, "mean": mean, "low": None, "high": None, "seeds": 1, "note": ""}]

    paid = {f"return paid by {name}": {"baseline": points(1.0), "proposed": points(2.0)} for name in "ab"}
    learning = learning_in({"baseline": "a", "proposed": "b", "learning": paid})
    own = [it.points["return, as paid"][0].value.mean for it in (learning.baseline, learning.proposed)]
    assert own == [1.0, 2.0]
