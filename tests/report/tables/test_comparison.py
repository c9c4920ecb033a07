import re
from dataclasses import replace
from functools import cache

import pytest

from harness.report import SPLIT, FactsTable, Report, along_grid, behaviour_grids, what_decides
from harness.report.rows.ratios import index_grid, ratio_grid, split_grid, sum_grid
from tests.report import conftest
from tests.report.conftest import MIXTURE, NO_PAIR, squeezed

CASES = {
    "plain": {},
    "large": {"baseline": (20, 19, 1e8), "proposed": {"arp": (20, 19, 1e8)}},
    "noise": {"seeds": 5},
    "one seed": {"seeds": 1},
    "along the budget": {"learned": {10: 1, 20: 2}},
    "null control": {"a_a": True, "proposed": {}},
    "not scorable": {"proposed": {"gone": (9, 30)}},
    "near zero": {"baseline": (9, 9), "proposed": {"arp": (1, 3_000)}, "seeds": 2},
    "paths disagree": {"baseline": (9, 12), "proposed": {"arp": (1, 20)}},
    "never positive": {"baseline": (39, 0)},
    "wide returns": {"proposed": dict.fromkeys(["arp", "relative", "adaptive", "sparse"], (9, 30))},
}


def printed(results, *console, **given):
    """What goes to a terminal."""
    return conftest.printed(FactsTable(Report(results).full), *console, **given)


def grids_of(combination):
    """All that stand in a combination's block."""
    decomposition, splits = combination.number.decomposition, combination.number.splits
    numbers = [ratio_grid(splits), split_grid(splits), sum_grid(decomposition.total), index_grid(decomposition)]
    return [behaviour_grids(combination)[0], along_grid(combination), *numbers]


@pytest.fixture(scope="module")
def built(build):
    """The results of a case, written and compared once for all widths."""
    return cache(lambda case: build(**CASES[case]))


def test_nothing_is_cut(built, subtests):
    """Every value stands whole in the table, indices of ten and more digits included, and so does every note."""
    for case in CASES:
        for width in [60, 80, 100]:
            with subtests.test(case=case, width=width):
                results = built(case)
                combination, *_ = results.combinations
                text = printed(results, width)
                for grid in grids_of(combination):
                    assert all(value in text for row in grid.rows for value in row[1:])
                    assert all(heading in text for heading in grid.headings[1:] if grid.rows)
                    assert all(squeezed(note) in squeezed(text) for note in grid.notes)
                assert "…" not in text
                assert max(map(len, text.splitlines())) <= width


def test_names_stay_readable_in_a_narrow_window(build):
    """At 60 columns every measure of behaviour has its whole name, word by word, beside each of its values."""
    results = build()
    words = [word for row in behaviour_grids(results.combinations[0])[0].rows for word in row[0].split()]
    text = printed(results, width=60)
    text = text[text.index("Behaviour of") : text.index("Behaviour while")]
    _, *tables = re.split("^─+$", text, flags=re.MULTILINE)
    assert len(tables) == 2
    for table in tables:
        assert all(word in table for word in words)


def test_wide_behaviour_is_not_cut(build):
    """Where the numbers of behaviour are as wide as they get, they stand in two tables."""
    results = build(reached={"arp": lambda seed: [9] * seed})
    (combination,) = results.combinations
    wide = {"baseline": 0.000123, "proposed": 0.000123, "random": -0.000123}
    changes = [
        replace(
            change, measure=change.measure._replace(unit="m"), **wide, low=-0.000123, high=-0.000123, corrected=0.01
        )
        for change in combination.measured.changes_of("deterministic")
    ]
    results.__dict__["combinations"] = (
        replace(combination, measured=replace(combination.measured, changes=tuple(changes))),
    )
    text = printed(results)
    assert text.count("[-0.000123, -0.000123]") == len(changes)
    assert len(re.findall(r" 0\.010\b", text)) >= len(changes)


def test_answer_comes_first(build):
    """The robot, then the number, in words; then behaviour, the etas, their parts, and the indices."""
    results = build()
    (combination,) = results.combinations
    text = squeezed(printed(results))
    words = ["The robot: CANNOT TELL", combination.headline.robot, "The pay of an episode", combination.pay_sentence]
    titles = [
        "The note's eta_N",
        "Behaviour of the",
        "eta_P: proposed",
        "eta_P: ruler x",
        "I_N + I_P, proposed",
        "accumulated reward",
    ]
    places = [text.index(squeezed(part)) for part in (*words, *titles)]
    assert places == sorted(places)


def test_answer_is_bold(build):
    """In a terminal the answer stands out; into a pipe goes plain text."""
    results = build()
    assert "\x1b[1mThe robot: CANNOT TELL" in printed(results, force_terminal=True)
    assert "\x1b" not in printed(results)


def test_ruler_and_behaviour_are_explained_once(build):
    """However many combinations there are, one sentence says what ruler and behaviour mean, one what p does."""
    results = build(simulators=("mujoco", "pybullet"))
    text = squeezed(printed(results))
    assert text.count(SPLIT) == text.count(what_decides(results)) == 1
    assert SPLIT not in squeezed(printed(build(proposed={"gone": (9, 30)})))


def test_no_finished_pair_is_said(build):
    """A combination without a finished pair shows n/a and why, and no empty tables."""
    results = build(**NO_PAIR)
    text = printed(results)
    assert results.combinations[0].number.eta_n.note in squeezed(text)
    assert "success rate" not in text
    assert "ruler" not in text


def test_cells_that_are_not_done_are_told(build):
    """A failed one with its title and its reason, which is no markup; others are counted by reason."""
    reason = "SimulationDiverged: [bold]no[/bold] [m]"
    ended = {("arp", 1): ("pending", ""), ("arp", 2): ("failed", reason), ("arp", 0): ("skipped", "sac cannot")}
    text = printed(build(ended=ended))
    assert f"failed: mujoco · sac · arp · seed 2: {reason}" in squeezed(text)
    assert "6 cells: 3 done" in text
    assert "1 pending: not run yet" in text
    assert "1 skipped: sac cannot" in text


def test_returns_under_every_reward_are_shown(build):
    """Below the combinations, with what rows and columns are."""
    text = squeezed(printed(build()))
    assert "evaluation return, scored by baseline arp" in text
    assert "events, paid on top" in text
    assert "Compare within a row: down a column the scale changes, not the behaviour." in text


def test_mixture_is_marked(mixed):
    """Above what was found."""
    text = squeezed(printed(mixed))
    assert text.index(MIXTURE) < text.index("The robot:")
