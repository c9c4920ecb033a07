"""What every metric says of one cell."""

import pytest

from harness.results.metrics import Moment, learning_values


@pytest.fixture(name="measure")
def _measure(make_cell, made):
    """Measures a cell that left what is given; see `tests.results.folders.finish`."""

    def measure_one(*, deterministic=True, **given):
        cell = make_cell(deterministic=deterministic)
        return made([cell], lambda cell: given).measured(cell)

    return measure_one


def test_policy_is_measured_in_both_manners(measure):
    """Its own first, then the other, then the training itself, each with its episodes; random actions are the floor."""
    found = measure(trained=[True, False], otherwise=[True, True, True], floor=[True, False, False, False])
    assert list(found.manners) == ["deterministic", "stochastic", "while training"]
    assert found.episodes == {"deterministic": 2, "stochastic": 3, "while training": 0}
    assert [values["success_rate"] for values in found.manners.values()] == [0.5, 1.0, None]
    assert found.own == found.manners["deterministic"]
    assert found.random["success_rate"] == 0.25


def test_drawn_actions_are_the_own_manner_of_a_stochastic_run(measure):
    """Then the other one is deterministic."""
    found = measure(deterministic=False, trained=[True], otherwise=[False])
    assert list(found.manners) == ["stochastic", "deterministic", "while training"]
    assert found.own["success_rate"] == 1.0


def test_cell_of_version_0_1_has_one_manner(measure):
    """It left no second evaluation."""
    assert list(measure().manners) == ["deterministic", "while training"]


@pytest.mark.parametrize(
    ("shares", "area", "steps"),
    [
        ({10: 0.0, 20: 0.5, 30: 1.0}, 0.5, 30.0),
        ({10: 0.89, 20: 0.9, 30: 0.0}, pytest.approx(1.79 / 3), 20.0),
        ({10: 0.5, 30: 0.8}, pytest.approx(0.65), 30.0),
        ({}, None, None),
        ({30: 1.0}, None, None),
        ({10: None, 30: 1.0}, None, None),
    ],
    ids=["the last one counts", "the first with 9 of 10", "never: the budget", "none", "the end alone", "not defined"],
)
def test_how_fast_was_learned(shares, area, steps):
    """The mean success over the evaluations, and the steps to the goal; no number that rests on one point."""
    moments = [Moment(at, {"success_rate": share}) for at, share in shares.items()]
    assert learning_values(moments, 30) == {"success_area": area, "steps_to_goal": steps}
