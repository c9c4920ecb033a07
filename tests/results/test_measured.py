"""What every metric says of one cell."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.store import Store
from harness.registry.registry import Registry
from harness.results.measured import (
    AREA,
    STEPS_TO_GOAL,
    Measured,
    Moment,
    learning_values,
    moments_by_due,
)
from harness.results.results import Results
from tests.results.folders import finish

MakeCell = Callable[..., Cell]
Measure = Callable[..., Measured]


@pytest.fixture(name="measure")
def _measure(make_cell: MakeCell, make_plan: Callable[..., Plan], registry: Registry, tmp_path: Path) -> Measure:
    """Measures a cell that left what is given; see `tests.results.folders.finish`."""

    def measure_one(*, deterministic: bool = True, **given: object) -> Measured:
        cell = make_cell(deterministic=deterministic)
        store = Store.create(tmp_path, make_plan(cell))
        finish(store, cell, [1.0, 0.5], **given)
        return Results(store.folder, registry).measured(cell)

    return measure_one


def test_policy_is_measured_in_both_manners(measure: Measure):
    """Its own first, then the other, then the training itself, each with its episodes."""
    found = measure(trained=[True, False], otherwise=[True, True, True])
    assert list(found.manners) == ["deterministic", "stochastic", "while training"]
    assert found.episodes == {"deterministic": 2, "stochastic": 3, "while training": 0}
    assert [values["success_rate"] for values in found.manners.values()] == [0.5, 1.0, None]
    assert found.own == found.manners["deterministic"]


def test_drawn_actions_are_the_own_manner_of_a_stochastic_run(measure: Measure):
    """Then the other one is deterministic."""
    found = measure(deterministic=False, trained=[True], otherwise=[False])
    assert list(found.manners) == ["stochastic", "deterministic", "while training"]
    assert found.own["success_rate"] == 1.0


def test_cell_of_version_0_1_has_one_manner(measure: Measure):
    """It left no second evaluation."""
    assert list(measure().manners) == ["deterministic", "while training"]


def test_random_actions_are_measured(measure: Measure):
    """The floor."""
    assert measure(floor=[True, False, False, False]).random["success_rate"] == 0.25


def _moments(shares: dict[int, float | None]) -> list[Moment]:
    return [Moment(steps, {"success_rate": share}) for steps, share in shares.items()]


def test_area_is_the_mean_success_over_the_evaluations():
    """The last one, after the training, included."""
    assert learning_values(_moments({10: 0.0, 20: 0.5, 30: 1.0}), 30)[AREA] == 0.5


def test_steps_to_goal_are_those_of_the_first_evaluation_with_nine_of_ten():
    """Whatever follows."""
    moments = _moments({10: 0.89, 20: 0.9, 30: 0.0})
    assert learning_values(moments, 30)[STEPS_TO_GOAL] == 20.0


def test_training_that_never_reaches_the_goal_counts_with_its_budget():
    """As in a restricted mean: it took that long at least."""
    assert learning_values(_moments({10: 0.5, 30: 0.8}), 30)[STEPS_TO_GOAL] == 30.0


@pytest.mark.parametrize("shares", [{}, {30: 1.0}, {10: None, 30: 1.0}], ids=["none", "the end alone", "not defined"])
def test_learning_has_no_values_without_evaluations(shares: dict[int, float | None]):
    """Rather than a number that rests on one point."""
    assert learning_values(_moments(shares), 30) == {AREA: None, STEPS_TO_GOAL: None}


def test_evaluations_are_told_by_when_they_were_due():
    """An algorithm may step over a multiple; the end is the budget, also where it was overshot."""
    moments = _moments({30: 0.0, 66: 0.0, 97: 0.0, 104: 0.0})
    assert [due for due, _ in moments_by_due(moments, 30, 100)] == [30, 60, 90, 100]
