import re
from dataclasses import replace

import numpy as np
import pytest

from harness.eta import Estimate, Split
from harness.eta.splits import SplitPath
from harness.report import FactsTable, Report, format_number, what_decides
from harness.report.rows.comparison import advice
from harness.report.rows.ratios import index_grid, path_grid, ratio_grid, split_grid, sum_grid
from harness.report.rows.returns import number_grids
from tests.report.conftest import NO_PAIR, printed, squeezed
from tests.results.folders import only


def told(results):
    """What goes to a terminal, all words of it."""
    return squeezed(printed(FactsTable(Report(results).full)))


def make_split(eta, first, second, **given):
    """A split with these paths, (ruler, behaviour) each; every ratio is 10 % wide to both sides."""
    paths = tuple(SplitPath(*map(wide, path)) for path in (first, second))
    means = [wide((one * other) ** 0.5) for one, other in zip(first, second, strict=True)]
    return replace(Split(wide(eta), wide(eta), *means, wide(first[0] / second[0]), paths), **given)


def wide(value):
    """A ratio with an interval."""
    return Estimate(value, 0.9 * value, 1.1 * value)


def test_ratio_stands_beside_what_it_is_to_be_held_against():
    """Its interval, what seeds give one by one, what noise gives, the corrected p alone, and the side called better."""
    split = make_split(6.0, (2.0, 3.0), (1.5, 4.0), per_seed=wide(5.0), noise=wide(1.0), p=0.01, corrected=0.04)
    grid = ratio_grid({"eta_N": split, "eta_P": replace(split, corrected=None)})
    row = ("6.00", "[5.40, 6.60]", "5.00", "[0.900, 1.10]")
    assert grid.rows == [("eta_N", *row, "0.040", "below 1"), ("eta_P", *row, "n/a", "above 1")]
    assert (grid.title, len(grid.headings)) == ("proposed / baseline", 7)


def test_flags_stand_under_the_ratios():
    """Where the paths say opposite things of the behaviour, and where single seeds say something else."""
    split = make_split(6.0, (2.0, 3.0), (12.0, 0.5), per_seed=wide(2.0))
    one, other = ratio_grid({"eta_N": split}).notes[-2:]
    assert one == "eta_N: 6 of the mean curve is not what seeds show one by one: their geometric mean is 2"
    assert other.startswith("eta_N: the behaviour depends on who judges it: x 3 under the baseline reward, x 0.5 ")


def test_noise_is_told_where_it_comes_from(build):
    """Once for both etas; without enough runs, why there is none."""
    notes = ratio_grid(only(build(seeds=4)).number.splits).notes
    assert "eta_N noise, eta_P noise: halves of 4 runs, scaled to all" in notes
    notes = ratio_grid(only(build(seeds=3)).number.splits).notes
    assert "eta_N noise n/a, eta_P noise n/a: 3 runs of the baseline: halves of them need at least 4" in notes


def test_all_of_equal_runs_is_ruler(one):
    """The same runs under both rewards: whatever eta is, the ruler is too, and the behaviour is 1."""
    splits = one.number.splits
    for grid, parts in ((split_grid(splits), 1), (path_grid(splits), 2)):
        expected = [(*row[1:3], "1.00", "[1.00, 1.00]") for row in ratio_grid(splits).rows for _ in range(parts)]
        assert [row[1:5] for row in grid.rows] == expected
        assert grid.notes == []


def test_each_part_stands_in_its_place():
    """Ruler, then behaviour, each with its interval, then the interaction."""
    splits = {"eta_N": make_split(6.0, (4.0, 1.5), (1.0, 6.0))}
    assert split_grid(splits).rows == [("eta_N", "2.00", "[1.80, 2.20]", "3.00", "[2.70, 3.30]", "4.00")]
    assert path_grid(splits).rows == [
        ("eta_N on proposed runs", "4.00", "[3.60, 4.40]", "1.50", "[1.35, 1.65]"),
        ("eta_N on baseline's runs", "1.00", "[0.900, 1.10]", "6.00", "[5.40, 6.60]"),
    ]


def test_remark_names_the_parts_that_it_holds_for():
    """In words, once; what holds for a split is not said again of its paths."""
    weak = {"near_zero": "I_P of the baseline is near zero beside I_N"}
    split = make_split(6.0, (2.0, 3.0), (1.5, 4.0))
    path = replace(split.paths[0].ruler, notes=("one thing",))
    split = replace(
        split,
        ruler=replace(split.ruler, **weak),
        behaviour=replace(split.behaviour, **weak),
        paths=(SplitPath(path, replace(split.paths[0].behaviour, **weak)), split.paths[1]),
    )
    remark = f"{weak['near_zero']}: the ratio says little"
    assert split_grid({"eta_P": split}).notes == [f"ruler of eta_P, behaviour of eta_P: {remark}"]
    assert path_grid({"eta_P": split}).notes == ["ruler of eta_P on proposed runs: one thing"]


def test_near_zero_is_no_big_number(build):
    """A ratio with an index near zero is called that, in every grid and note; the JSON keeps it."""
    combination = only(build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=3))
    assert combination.to_json()["eta_P"]["eta"]["value"] > 1e6
    ratios, parts = ratio_grid(combination.number.splits), split_grid(combination.number.splits)
    assert ratios.rows[1][1:3] == ("near zero", "n/a")
    assert parts.rows[1][3:] == ("near zero", "n/a", "near zero")
    assert any(note.startswith(f"eta_P: {combination.number.eta_p.near_zero}") for note in ratios.notes)
    assert not any("e+" in text for text in [*parts.notes, *map(str, parts.rows)])


def test_missing_ratio_has_its_reason(build):
    """A ratio that is not defined is n/a, wherever it stands, and a note says why."""
    combination = only(build(baseline=(39, 0)))
    (reason,) = combination.number.eta_p.notes
    ratios, parts = ratio_grid(combination.number.splits), split_grid(combination.number.splits)
    assert ratios.rows[1][1:3] == ("n/a", "n/a")
    assert f"eta_P n/a: {reason}" in ratios.notes
    assert parts.rows[1] == ("eta_P", *["n/a"] * 5)
    assert f"ruler of eta_P n/a, behaviour of eta_P n/a: {reason}" in parts.notes


def test_reward_that_cannot_score_leaves_no_split(build):
    """A reward whose plugin is not installed: the etas stand, and one note says why they are not split."""
    combination = only(build(proposed={"gone": (9, 30)}))
    assert [row[1] for row in ratio_grid(combination.number.splits).rows] == ["1.00", "1.00"]
    grid = split_grid(combination.number.splits)
    assert (grid.rows, path_grid(combination.number.splits).rows) == ([], [])
    total = sum_grid(combination.number.decomposition.total)
    assert [row[0] for row in total.rows] == ["change"]
    for (note,) in (grid.notes, total.notes):
        assert "No reward 'gone'" in note


def test_change_of_the_sum_is_a_sum(build):
    """I_N + I_P: ruler and behaviour add up to the change, each with its interval."""
    total = only(build(proposed={"arp": (5, 34)})).number.decomposition.total
    grid = sum_grid(total)
    assert [row[0].strip() for row in grid.rows] == ["change", "of it ruler", "of it behaviour"]
    assert total.change.value == pytest.approx(total.ruler.value + total.behaviour.value)
    assert [row[1] for row in grid.rows] == [
        format_number(it.value) for it in (total.change, total.ruler, total.behaviour)
    ]
    assert all(row[2].startswith("[") for row in grid.rows)


def test_indices_are_rounded_as_published(build):
    """I_N and I_P of the mean curve have one decimal, computed here by hand; so has their sum."""
    curve = np.concatenate([[0.0], -np.arange(1.0, 10.0), -9.0 + 1.1 * np.arange(1, 31)])  # seeds 0 to 2
    combination = only(build(proposed={"arp": (0, 39)}))
    grid = index_grid(combination.number.decomposition)
    assert [row[2] for row in grid.rows[:2]] == ["never", "never"]
    rows = {row[0]: row[1] for row in grid.rows}
    assert float(rows["I_N"]) == pytest.approx(np.minimum(curve, 0).sum(), abs=0.05)
    assert float(rows["I_P"]) == pytest.approx(np.maximum(curve, 0).sum(), abs=0.05)
    assert float(rows["I_N + I_P"]) == pytest.approx(curve.sum(), abs=0.05)


def advised(results, needed=(8, 20)):
    """The advice where so many seeds would tell."""
    combination = results.combinations[-1]
    combination.__dict__["headline"] = replace(combination.headline, seeds_to_decide=needed)
    return advice(results, combination)


def test_advice_is_a_command_that_trains_until_there_is_an_answer(build):
    """In a new folder: seeds that are added after a look give luck another chance. The plugins are those of before."""
    results = build()
    results.plan = replace(results.plan, experiment={"plugins": [{"path": "/mine/my_reward.py", "sha256": "0"}]})
    assert advised(results) == (
        f"For an answer with the fewest trainings: harness run {results.folder / 'experiment.toml'} --out NEW "
        "--until decided --plugin /mine/my_reward.py"
    )


def test_no_advice_where_it_would_not_help(build):
    """Nothing needed or known; seeds that no count gives; the null control, which asks nothing."""
    assert advised(build(), None) == ""
    assert advised(build(ended={("arp", 0): ("failed", "it broke")})) == ""
    assert advised(build(a_a=True)) == ""


def test_no_finished_pair_has_no_grids(build):
    """Without a finished pair there is the reason, and nothing else."""
    combination = only(build(**NO_PAIR))
    note, *_ = ratio_grid(combination.number.splits).notes
    assert note == f"eta_N n/a, eta_P n/a: {combination.number.eta_n.note}"
    splits = combination.number.splits
    assert [(grid.rows, grid.notes) for grid in (split_grid(splits), path_grid(splits))] == [([], [])] * 2
    shown = [grid.rows for grid in number_grids(combination, "accumulated") if grid.rows]
    assert shown == [ratio_grid(splits).rows]


def test_heading_says_which_curve_the_indices_are_of(one):
    """Accumulated, unless a reader asked for the other."""
    decomposition = one.number.decomposition
    headings = [index_grid(decomposition, kind).headings[0] for kind in ("accumulated", "per-step")]
    assert headings == ["accumulated reward", "per-step reward"]


def test_numbers_have_three_significant_digits(subtests):
    """Three significant digits, an exponent only far from 1, and n/a for what is no number."""
    for value, text in [
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
    ]:
        with subtests.test(value=value):
            assert format_number(value) == text


def test_what_is_asked_is_said(build):
    """How many questions there are, and that all else decides nothing."""
    asked = r"1 question about the robot is tested\. \d+ exploratory comparisons do not affect the verdict"
    assert re.search(asked, told(build(seeds=4)))


def test_a_plan_that_is_not_trained_to_its_end_says_so_first(build):
    """With what that does to every p; where all trainings ended there is no such line."""
    interim = build(ended={("arp", 2): ("pending", "")})
    line = "Interim: 1 training is missing. Nothing here says yet what is better or worse."
    assert told(interim).startswith(line)
    assert "Trainings are missing, so nothing is tested about the robot:" in told(interim)
    ended = told(build())
    assert "Interim" not in ended
    assert "AHEAD and BEHIND SO FAR are about these trainings alone" in ended


def test_what_is_compared_are_all_trainings(build):
    """The seeds, where both rewards have the same ones; else how many there are of each."""
    assert "3 seeds (0, 1, 2) compared," in told(build())
    assert "3 trainings with baseline, 2 with arp compared," in told(build(ended={("arp", 2): ("failed", "it broke")}))


def test_a_reward_that_has_not_begun_makes_no_test_of_an_unfinished_plan(build):
    """One reward is compared, the other one has no training yet."""
    begun = build(ended={("arp", seed): ("pending", "") for seed in range(3)})
    assert told(begun).startswith("Interim: 3 trainings")
    assert what_decides(begun).startswith("Trainings are missing, so nothing is tested")
