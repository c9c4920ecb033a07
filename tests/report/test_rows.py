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
    ratio_with_interval,
    rewards_text,
    split_grid,
)


def only(results):
    """The only combination."""
    (combination,) = results.combinations
    return combination


def make_split(*values, **weak):
    """A split of eta, ruler, behaviour, other ruler and other behaviour, each 10 % wide to both sides.

    `weak` are the parts that rest on an index near zero, by name, and beside what.
    """
    ratios = [Ratio(value, 0.9 * value, 1.1 * value) for value in values]
    split = Split(*ratios, True, Ratio(None, notes=("none",)), None, None)
    return split._replace(**{name: replace(getattr(split, name), near_zero=beside) for name, beside in weak.items()})


def test_ratio_has_its_interval(build):
    """Both etas stand with interval and the side that is called better; what holds for both is said once."""
    combination = only(build())
    grid = ratio_grid(combination.splits)
    etas = (("eta_N", combination.eta_n, "below 1"), ("eta_P", combination.eta_p, "above 1"))
    assert grid.rows == [(name, ratio_text(eta), interval_text(eta), better) for name, eta, better in etas]
    (note,) = grid.notes
    assert note.startswith("eta_N, eta_P: 3 seeds")


def test_all_of_equal_runs_is_ruler(build):
    """The same runs under both rewards: whatever eta is, the ruler is too, and the behaviour is 1."""
    combination = only(build())
    eta_n, eta_p = (row[1:3] for row in ratio_grid(combination.splits).rows)
    one = ("1.00", "[1.00, 1.00]")
    grid = split_grid(combination.splits)
    assert [row[1:] for row in grid.rows] == [(*eta_n, *one)] * 2 + [(*eta_p, *one)] * 2
    assert [row[0] for row in grid.rows] == [
        f"eta_N = {eta_n[0]}",
        "  other path",
        f"eta_P = {eta_p[0]}",
        "  other path",
    ]
    assert grid.notes == []  # that there are 3 seeds stands beside the etas


def test_each_part_stands_in_its_place():
    """A row is a path: its ruler, then its behaviour, each with its interval."""
    grid = split_grid({"eta_N": make_split(6.0, 2.0, 3.0, 1.5, 4.0)})
    assert grid.rows[:2] == [
        ("eta_N = 6.00", "2.00", "[1.80, 2.20]", "3.00", "[2.70, 3.30]"),
        ("  other path", "1.50", "[1.35, 1.65]", "4.00", "[3.60, 4.40]"),
    ]


def test_paths_that_disagree_say_so(build):
    """Where a long dip changes the ruler's weight, the paths differ, and a note has the numbers of both."""
    combination = only(build(baseline=(9, 12), proposed={"arp": (1, 20)}))
    (note,) = split_grid(combination.splits).notes
    split = combination.decomposition.positive
    assert note.startswith("eta_P: ")
    assert all(f"{part.value:.3g}" in note for part in split[1:5])


def test_paths_with_a_part_near_zero_are_not_compared():
    """Its number would be a big one: the note says near zero instead."""
    split = make_split(6.0, 2.0, 3e6, 6.0, 1.0, behaviour="I_P of the baseline is near zero beside I_N")
    notes = split_grid({"eta_P": split}).notes
    assert any(note.startswith("eta_P: ") and "near zero" in note for note in notes)
    assert not any("e+06" in note for note in notes)


def test_near_zero_is_no_big_number(build):
    """A ratio with an index near zero is called that, in both grids and every note; the JSON keeps it."""
    combination = only(build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=2))
    assert combination.to_json()["eta_p"]["value"] > 1e6
    ratios, parts = ratio_grid(combination.splits), split_grid(combination.splits)
    assert ratios.rows[1][1:3] == ("near zero", "n/a")
    assert parts.rows[2][0] == "eta_P = near zero"
    assert parts.rows[2][3:] == ("near zero", "n/a")
    assert any(note.startswith(f"eta_P: {combination.eta_p.near_zero}") for note in ratios.notes)
    assert not any("e+" in text or "000" in text for text in [*parts.notes, *map(str, parts.rows)])


def test_missing_ratio_has_its_reason(build):
    """A ratio that is not defined is n/a, wherever it stands, and a note says why."""
    combination = only(build(baseline=(39, 0)))
    (reason,) = combination.eta_p.notes
    ratios, parts = ratio_grid(combination.splits), split_grid(combination.splits)
    assert ratios.rows[1][1:3] == ("n/a", "n/a")
    assert f"eta_P n/a: {reason}" in ratios.notes
    assert parts.rows[2][0] == "eta_P = n/a"
    assert f"eta_P behaviour n/a, eta_P other ruler n/a: {reason}" in parts.notes


def test_reward_that_cannot_score_leaves_no_split(build):
    """A reward whose plugin is not installed: the etas stand, and one note says why they are not split."""
    combination = only(build(proposed={"gone": (9, 30)}))
    assert [row[1] for row in ratio_grid(combination.splits).rows] == ["1.00", "1.00"]
    grid = split_grid(combination.splits)
    assert grid.rows == []
    (note,) = grid.notes
    assert "No reward 'gone'" in note


def test_one_seed_has_no_interval(build):
    """With one seed there are ratios, no interval and no result, and a note says why, once."""
    combination = only(build(seeds=1, reached={"arp": lambda seed: (5,)}))
    ratios, parts = ratio_grid(combination.splits), split_grid(combination.splits)
    (note,) = ratios.notes
    assert note.startswith("eta_N, eta_P: one seed")
    assert {row[2] for row in ratios.rows + parts.rows} == {"n/a"}
    assert {(row.difference, row.direction) for row in behaviour_rows(combination)} == {("n/a", "")}
    assert any("one seed" in note for note in behaviour_grid(combination).notes)


def test_noise_floor_stands_where_there_is_one(build):
    """Four seeds are enough for halves against each other: their interval stands beside eta's own."""
    assert "A/A noise" not in ratio_grid(only(build(seeds=3)).splits).headings
    combination = only(build(seeds=4))
    grid = ratio_grid(combination.splits)
    assert grid.headings[3] == "A/A noise"
    assert grid.rows[0][3] == interval_text(combination.decomposition.negative.noise) != "n/a"
    assert any(note.startswith("A/A noise of eta_N, eta_P: ") and "4 seeds" in note for note in grid.notes)
    assert {len(row) for row in grid.rows} == {len(grid.headings)}


def test_null_control_is_named(build):
    """The baseline against itself is marked as A/A and gives 1 everywhere."""
    control, _ = build(a_a=True).combinations
    assert "A/A" in rewards_text(control)
    assert {text for row in split_grid(control.splits).rows for text in row[1::2]} == {"1.00"}


def test_curve_that_never_crosses_over_says_so(build):
    """A step that does not exist is 'never'."""
    rows = index_grid(only(build(proposed={"arp": (0, 39)})).decomposition).rows
    assert [row[2] for row in rows[:2]] == ["never", "never"]


def test_indices_are_rounded_as_published(build):
    """I_N and I_P of the mean curve have one decimal, computed here by hand."""
    curve = np.concatenate([[0.0], -np.arange(1.0, 10.0), -9.0 + 1.1 * np.arange(1, 31)])  # seeds 0 to 2
    rows = {row[0]: row[1] for row in index_grid(only(build()).decomposition).rows}
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
    assert "2 combinations" in text
    assert text.endswith("eta_N 0.002, eta_P 0.002, success rate 0.002")


def test_no_finished_pair_has_no_grids(build):
    """Without a finished pair there is the reason, and nothing else."""
    combination = only(build(seeds=1, ended={("arp", 0): ("failed", "it broke")}))
    (note,) = ratio_grid(combination.splits).notes
    assert note == f"eta_N n/a, eta_P n/a: {combination.eta_n.note}"
    rest = [split_grid(combination.splits), index_grid(combination.decomposition), behaviour_grid(combination)]
    assert [(grid.rows, grid.notes) for grid in rest] == [([], [])] * 3


def test_interval_stands_behind_its_ratio_where_there_is_one():
    """A ratio without an interval, or with one that says little, stands alone."""
    assert ratio_with_interval(Ratio(2.0, 1.5, 3.0)) == "2.00 [1.50, 3.00]"
    assert ratio_with_interval(Ratio(2.0)) == "2.00"
    assert ratio_with_interval(Ratio(None)) == "n/a"
    assert ratio_with_interval(Ratio(2e9, 1e9, 3e9, near_zero="I_P")) == "near zero"


def test_heading_says_which_curve_the_indices_are_of(build):
    """Accumulated, unless a reader asked for the other."""
    decomposition = only(build()).decomposition
    headings = [index_grid(decomposition, kind).headings[0] for kind in ("accumulated", "per-step")]
    assert headings == ["accumulated reward", "per-step reward"]


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
