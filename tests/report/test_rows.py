from dataclasses import replace

import numpy as np
import pytest

from harness.eta.decompose import Split
from harness.eta.index import Ratio
from harness.report.rows import (
    behaviour_grid,
    behaviour_rows,
    corrected_text,
    format_number,
    index_grid,
    interval_text,
    ratio_grid,
    ratio_text,
    rewards_text,
    split_grid,
)

NOTE = "3 seeds: the interval is rough below 5"


def only(results):
    """The only combination."""
    (combination,) = results.combinations
    return combination


def with_splits(combination, negative, positive=None):
    """The combination with these splits in place of its own."""
    given = replace(combination.decomposition, negative=negative, positive=positive or negative)
    return replace(combination, decomposition=given)


def make_split(*values, notes=("",) * 5, disagreement=""):
    """A split of eta, ruler, behaviour, other ruler and other behaviour, each 10 % wide to both sides."""
    ratios = [
        Ratio(value, value and 0.9 * value, value and 1.1 * value, note)
        for value, note in zip(values, notes, strict=True)
    ]
    return Split(*ratios, disagreement, Ratio(None, note="none"), None, None)


def test_ratio_has_its_interval(build):
    """Both etas stand with interval and the side that is called better; what holds for both is said once."""
    combination = only(build())
    grid = ratio_grid(combination)
    etas = (("eta_N", combination.eta_n, "below 1"), ("eta_P", combination.eta_p, "above 1"))
    assert grid.rows == [(name, ratio_text(eta), interval_text(eta), better) for name, eta, better in etas]
    assert grid.notes == [f"eta_N, eta_P: {NOTE}"]


def test_all_of_equal_runs_is_ruler(build):
    """The same runs under both rewards: whatever eta is, the ruler is too, and the behaviour is 1."""
    combination = only(build())
    eta_n, eta_p = (row[1:3] for row in ratio_grid(combination).rows)
    one = ("1.00", "[1.00, 1.00]")
    grid = split_grid(combination)
    assert [row[1:] for row in grid.rows] == [(*eta_n, *one)] * 2 + [(*eta_p, *one)] * 2
    assert [row[0] for row in grid.rows] == [
        f"eta_N = {eta_n[0]}",
        "  other path",
        f"eta_P = {eta_p[0]}",
        "  other path",
    ]
    assert grid.notes == []  # that there are 3 seeds stands beside the etas


def test_each_part_stands_in_its_place(build):
    """A row is a path: its ruler, then its behaviour, each with its interval."""
    grid = split_grid(with_splits(only(build()), make_split(6.0, 2.0, 3.0, 1.5, 4.0)))
    assert grid.rows[:2] == [
        ("eta_N = 6.00", "2.00", "[1.80, 2.20]", "3.00", "[2.70, 3.30]"),
        ("  other path", "1.50", "[1.35, 1.65]", "4.00", "[3.60, 4.40]"),
    ]


def test_paths_that_disagree_say_so(build):
    """Where a long dip changes the ruler's weight, the paths differ, and a note has both."""
    grid = split_grid(only(build(baseline=(9, 12), proposed={"arp": (1, 20)})))
    (note,) = grid.notes
    assert note.startswith("eta_P: the two paths disagree: ruler 1.55 and behaviour 20.7 on the proposed runs")


def test_near_zero_is_no_big_number(build):
    """A ratio with an index near zero is called that, in both grids and every note; the JSON keeps it."""
    combination = only(build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=2))
    assert combination.to_json()["eta_p"]["value"] > 1e6
    ratios, parts = ratio_grid(combination), split_grid(combination)
    assert ratios.rows[1][1:3] == ("near zero", "n/a")
    assert parts.rows[2][0] == "eta_P = near zero"
    assert parts.rows[2][3:] == ("near zero", "n/a")
    assert any(note.startswith("eta_P: I_P of the baseline is near zero") for note in ratios.notes)
    assert "eta_P: the two paths cannot be compared, a part is near zero" in parts.notes
    assert not any("e+" in text or "000" in text for text in [*parts.notes, *map(str, parts.rows)])


def test_missing_ratio_has_its_reason(build):
    """A ratio that is not defined is n/a, wherever it stands, and a note says why."""
    combination = only(build(baseline=(39, 0)))
    reason = "I_P of the baseline is 0: its mean accumulated reward is never positive"
    assert ratio_grid(combination).rows[1][1:3] == ("n/a", "n/a")
    assert f"eta_P n/a: {reason}" in ratio_grid(combination).notes
    parts = split_grid(combination)
    assert parts.rows[2][0] == "eta_P = n/a"
    assert f"eta_P behaviour n/a, eta_P other ruler n/a: {reason}" in parts.notes


def test_reward_that_cannot_score_leaves_no_split(build):
    """A reward whose plugin is not installed: the etas stand, and one note says why they are not split."""
    combination = only(build(proposed={"gone": (9, 30)}))
    assert [row[1] for row in ratio_grid(combination).rows] == ["1.00", "1.00"]
    grid = split_grid(combination)
    assert grid.rows == []
    (note,) = grid.notes
    assert note.startswith("Not split into ruler x behaviour: No reward 'gone'.")


def test_one_seed_has_no_interval(build):
    """With one seed there are ratios, no interval and no result, and a note says why, once."""
    combination = only(build(seeds=1, reached={"arp": lambda seed: (5,)}))
    assert ratio_grid(combination).notes == ["eta_N, eta_P: one seed: no interval"]
    assert {row[2] for row in ratio_grid(combination).rows + split_grid(combination).rows} == {"n/a"}
    assert {(row.difference, row.direction) for row in behaviour_rows(combination)} == {("n/a", "")}
    assert "one seed: no interval" in behaviour_grid(combination).notes


def test_noise_floor_stands_where_there_is_one(build):
    """Four seeds are enough for halves against each other: their interval stands beside eta's own."""
    assert "A/A noise" not in ratio_grid(only(build(seeds=3))).headings
    combination = only(build(seeds=4))
    grid = ratio_grid(combination)
    assert grid.headings[3] == "A/A noise"
    assert grid.rows[0][3] == interval_text(combination.decomposition.negative.noise) != "n/a"
    assert "A/A noise of eta_N, eta_P: halves of 4 seeds against each other" in grid.notes
    assert {len(row) for row in grid.rows} == {len(grid.headings)}


def test_null_control_is_named(build):
    """The baseline against itself is marked as A/A and gives 1 everywhere."""
    control, _ = build(a_a=True).combinations
    assert rewards_text(control) == "baseline against baseline (A/A, the null control)"
    assert {text for row in split_grid(control).rows for text in row[1::2]} == {"1.00"}


def test_curve_that_never_crosses_over_says_so(build):
    """A step that does not exist is 'never'."""
    rows = index_grid(only(build(proposed={"arp": (0, 39)}))).rows
    assert [row[2] for row in rows[:2]] == ["never", "never"]


def test_indices_are_rounded_as_published(build):
    """I_N and I_P of the mean curve have one decimal, computed here by hand."""
    curve = np.concatenate([[0.0], -np.arange(1.0, 10.0), -9.0 + 1.1 * np.arange(1, 31)])  # seeds 0 to 2
    rows = {row[0]: row[1] for row in index_grid(only(build())).rows}
    assert float(rows["I_N"]) == pytest.approx(np.minimum(curve, 0).sum(), abs=0.05)
    assert float(rows["I_P"]) == pytest.approx(np.maximum(curve, 0).sum(), abs=0.05)


def test_behaviour_of_random_actions_stands_beside(build):
    """Shares are percentages, lengths have three digits, and random actions are the floor; success comes first."""
    rows = behaviour_rows(only(build()))
    assert rows[0] == ("success rate", "75.0%", "75.0%", "[0.0, 0.0] pp", "0.0%", "higher", "")
    assert ("final distance [m]", "0.0400", "0.0400", "[0.00, 0.00]", "0.900", "lower", "") in rows
    assert ("steps to target", "9.00", "9.00", "[0.00, 0.00]", "n/a", "lower", "") in rows


def test_direction_needs_an_interval_without_zero(build):
    """Better or worse is said of what differs in every seed, and of nothing else."""
    combination = only(build(reached={"arp": lambda seed: [6] * (seed % 3)}))
    rows = {row.name: row for row in behaviour_rows(combination)}
    assert rows["success rate"][3::3] == ("[-75.0, -25.0] pp", "worse")
    assert rows["steps to target"][3::3] == ("[-3.00, -3.00]", "better")
    assert rows["final distance [m]"].direction == ""


def test_difference_across_zero_has_no_direction(build):
    """Seeds that contradict each other decide nothing."""
    combination = only(build(reached={"arp": lambda seed: [9] * (4 - 2 * (seed % 2))}, seeds=4))
    assert behaviour_rows(combination)[0][3::3] == ("[-25.0, 25.0] pp", "")


def test_number_without_unit_above_one_is_no_percentage(build):
    """A metric without a unit is shown as a percentage only while it is a share."""
    combination = only(build())
    count = replace(combination.changes[0], name="jerks", unit="", baseline=0.5, proposed=2.0, random=None)
    count = replace(count, low=1.0, high=2.0, better="lower")
    (row,) = behaviour_rows(replace(combination, changes=(count,)))
    assert row == ("jerks", "0.500", "2.00", "[1.00, 2.00]", "n/a", "lower", "worse")


def test_corrected_p_values_need_several_combinations(build):
    """One combination has nothing to correct; of several each has its p-values, and for how many they hold."""
    assert corrected_text(only(build()), 1) == ""
    results = build(simulators=("mujoco", "pybullet"), reached={"arp": lambda seed: (9,)})
    text = corrected_text(results.combinations[0], 2)
    assert text.startswith("p of no change, corrected for 2 combinations: eta_N 0.002, eta_P 0.002, success rate 0.002")


def test_no_finished_pair_has_no_grids(build):
    """Without a finished pair there is the reason, and nothing else."""
    combination = only(build(seeds=1, ended={("arp", 0): ("failed", "it broke")}))
    reason = "no seed is done under both baseline and arp"
    assert ratio_grid(combination).notes == [f"eta_N n/a, eta_P n/a: {reason}"]
    rest = [make(combination) for make in (split_grid, index_grid, behaviour_grid)]
    assert [(grid.rows, grid.notes) for grid in rest] == [([], [])] * 3


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.21173264, "0.212"),
        (9.996, "10.0"),
        (25.6, "25.6"),
        (1234.5, "1,230"),
        (-0.00021, "-0.000210"),
        (0.0, "0.00"),
        (-0.0, "0.00"),
        (-1e-300, "-1.00e-300"),
        (999_400.0, "999,000"),
        (1e6, "1.00e+06"),
        (None, "n/a"),
    ],
)
def test_numbers_have_three_significant_digits(value, text):
    """Three significant digits, an exponent only far from 1, and n/a for what is no number."""
    assert format_number(value) == text
