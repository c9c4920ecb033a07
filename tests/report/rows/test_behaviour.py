"""Measures of behaviour as text."""

from dataclasses import replace

from harness.report import along_grid, behaviour_grids
from tests.report.conftest import NO_PAIR
from tests.results.folders import only
from tests.results.test_comparison import measured


def rows_of(combination):
    """The rows of the manner that decides."""
    return behaviour_grids(combination)[0].rows


def test_behaviour_of_random_actions_stands_beside(one):
    """Shares are percentages, lengths have three digits, and random actions are the floor; success comes first."""
    rows = rows_of(one)
    assert rows[0][:3] == ("success rate", "75.0%", "75.0%")
    assert rows[0][4:] == ("0.0%", "higher", "1.000", "")
    told = [(*row[:3], *row[4:]) for row in rows]
    assert ("final distance [m]", "0.0400", "0.0400", "0.900", "lower", "1.000", "") in told
    assert ("steps to target", "9.00", "9.00", "n/a", "lower", "1.000", "") in told


def test_result_needs_a_test_that_says_so(build):
    """And an interval without 0: twenty seeds that all differ say better; six have a small p alone."""
    reached = {"arp": lambda seed: [6, 6, 6]}
    rows = {row[0]: row[6:] for row in rows_of(only(build(seeds=20, reached=reached)))}
    assert rows["steps to target"][1] == "better"
    assert rows["success rate"] == ("1.000", "")
    rows = {row[0]: row[6:] for row in rows_of(only(build(seeds=6, reached=reached)))}
    assert rows["steps to target"] == ("0.031", "")


def test_interval_of_a_share_is_in_percentage_points(one):
    """It allows for failures that were not seen: no point where all seeds are alike."""
    low, high = (float(end) for end in rows_of(one)[0][3].removesuffix(" pp").strip("[]").split(", "))
    assert low == -high < -10.0


def test_number_without_unit_above_one_is_no_percentage(one):
    """A metric without a unit is shown as a percentage only while it is a share."""
    combination = one
    change = combination.measured.changes[0]
    measure = change.measure._replace(name="jerks", unit="", better="lower")
    count = replace(change, measure=measure, baseline=0.5, proposed=2.0, random=None, low=1.0, high=2.0, corrected=None)
    told = ("jerks", "0.500", "2.00", "[1.00, 2.00]", "n/a", "lower", "n/a", "")
    assert rows_of(measured(combination, changes=(count,))) == [told]


def test_manner_that_decides_comes_first(build):
    """Whatever the order in which they were measured; the title says how policies acted, and how often."""
    combination = only(build(learned={10: 1}))
    assert [grid.title for grid in behaviour_grids(combination)] == [
        "Behaviour of the trained policies, deterministic, 4 episodes per seed",
        "Behaviour while training, 1 episode or more per seed",
        "Behaviour while learning",
    ]
    changes = tuple(
        replace(it, measure=it.measure._replace(manner="stochastic")) if it.measure.manner == "while training" else it
        for it in combination.measured.changes
    )
    drawn = measured(combination, changes=changes, episodes={"deterministic": 1, "stochastic": 100})
    assert [grid.title.split(", ", 1)[-1] for grid in behaviour_grids(drawn)] == [
        "stochastic, 100 episodes per seed",
        "deterministic, 1 episode per seed",
        "Behaviour while learning",
    ]


def test_seeds_without_a_value_are_counted(build):
    """A metric of successful episodes is not defined where there is none."""
    grid = behaviour_grids(only(build(reached={"arp": lambda seed: [6] * (seed % 3)})))[0]
    assert "steps to target: 3 seeds against 2 compared, 1 without a value" in grid.notes


def test_no_finished_pair_has_no_behaviour(build):
    """No grids at all."""
    combination = only(build(**NO_PAIR))
    assert behaviour_grids(combination) == []
    assert along_grid(combination).rows == []


def test_every_evaluation_has_its_hint(build):
    """The last one after the training; a lead that is gone by then does not count there."""
    rows = along_grid(only(build(seeds=16, learned={10: 1, 20: 2}))).rows
    assert [row[0] for row in rows] == ["after 10 steps", "after 20 steps", "after 40 steps"]
    assert [row[1:3] for row in rows] == [("25.0%", "50.0%"), ("50.0%", "75.0%"), ("75.0%", "75.0%")]
    assert [row[4] for row in rows] == ["better", "better", "cannot tell"]


def test_all_of_the_budget_is_told_in_one_manner(build):
    """That of the evaluations while learning, whatever decides after the training."""
    drawn = measured(only(build(learned={10: 1})), episodes={"deterministic": 4, "stochastic": 100})
    grid = along_grid(drawn)
    assert grid.title == "Along the budget of training, deterministic"
    assert grid.rows[-1][1] == "75.0%"


def test_nothing_along_the_budget_without_evaluations(one):
    """The end alone is no curve."""
    assert along_grid(one).rows == []
