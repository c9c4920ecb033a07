from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from harness.report.table import (
    behaviour_rows,
    comparison_table,
    format_number,
    index_rows,
    ratio_notes,
    ratio_rows,
)


def printed(results, width=80, **console):
    """The table as it goes to a pipe, unless `console` says otherwise."""
    output = StringIO()
    Console(file=output, width=width, **console).print(comparison_table(results))
    return output.getvalue()


def squeezed(text):
    """The text with its line breaks undone."""
    return " ".join(text.split())


def large(seed):
    """Rewards with indices of ten and more digits, both signs."""
    reward = np.full(40, 9.87654321e7)
    reward[:20] *= -1.0
    return reward


@pytest.mark.parametrize("width", [80, 100])
def test_no_number_is_cut(build, width):
    """Every number stands whole in the table, indices of ten and more digits included."""
    results = build(baseline=large, proposed={"arp": large})
    (combination,) = results.combinations
    text = printed(results, width)
    for row in [*ratio_rows(combination), *index_rows(combination), *behaviour_rows(combination)]:
        assert all(value in text for value in row[1:])
    assert "…" not in text
    assert max(map(len, text.splitlines())) <= width


def test_combination_says_what_was_compared(build):
    """A block names the simulator, the algorithm, both rewards and the seeds."""
    text = printed(build(seeds=2))
    assert "mujoco · sac · fd100 · fd100-reach" in text
    assert "proposed arp against baseline" in text
    assert "2 seeds (0, 1) compared" in text


def test_ratio_has_its_interval(build):
    """Equal runs under both rewards give 1 with an interval of no width."""
    (combination,) = build().combinations
    assert [row[1:3] for row in ratio_rows(combination)] == [("1.00", "[1.00, 1.00]")] * 2


def test_missing_ratio_has_its_reason(build):
    """A ratio that is not defined is n/a, and the reason stands below the table."""
    text = printed(build(baseline=lambda seed: np.full(40, -1.0)))
    assert squeezed("eta_P n/a: I_P of the baseline is 0: its mean accumulated reward is never positive") in squeezed(
        text
    )


def test_one_seed_has_no_interval(build):
    """With one seed there is a ratio, no interval, and the note says why, once for both ratios."""
    (combination,) = build(seeds=1).combinations
    assert [row.interval for row in ratio_rows(combination)] == ["n/a", "n/a"]
    assert ratio_notes(combination) == ["eta_N, eta_P: one seed: no interval"]


def test_no_finished_pair_is_said(build):
    """A combination without a finished pair shows n/a and why, and no empty tables."""
    text = printed(build(seeds=1, ended={("arp", 0): ("failed", "it broke")}))
    assert "no seed is done under both baseline and arp" in squeezed(text)
    assert "success rate" not in text


def test_curve_that_never_crosses_over_says_so(build):
    """A step that does not exist is 'never'."""
    (combination,) = build(proposed={"arp": lambda seed: np.ones(40)}).combinations
    assert [row.proposed for row in index_rows(combination)[:2]] == ["never", "never"]


def test_behaviour_of_random_actions_stands_beside(build):
    """Shares are percentages, lengths have three digits, and random actions are the floor; success comes first."""
    (combination,) = build().combinations
    rows = behaviour_rows(combination)
    assert rows[0] == ("success rate", "75.0%", "75.0%", "0.0%", "higher")
    assert ("final distance [m]", "0.0400", "0.0400", "0.900", "lower") in rows
    assert ("steps to target", "9.00", "9.00", "n/a", "lower") in rows


def test_number_without_unit_above_one_is_no_percentage(build):
    """A metric without a unit is shown as a percentage only while it is a share."""
    (combination,) = build().combinations
    count = replace(combination.behaviour[0], name="jerks", unit="", baseline=0.5, proposed=2.0, random=None)
    (row,) = behaviour_rows(replace(combination, behaviour=(count,)))
    assert row == ("jerks", "0.500", "2.00", "n/a", count.better)


def test_failed_cell_is_listed_with_its_reason(build):
    """A failed cell has a line with its title and its reason."""
    text = printed(build(ended={("arp", 1): ("failed", "SimulationDiverged: qpos is not finite")}))
    assert "failed: mujoco · sac · arp · seed 1: SimulationDiverged: qpos is not finite" in squeezed(text)
    assert "6 cells: 5 done, 1 failed" in text


def test_pending_and_skipped_cells_are_counted(build):
    """Cells that did not run are counted by reason."""
    ended = {("arp", 1): ("pending", ""), ("arp", 2): ("pending", ""), ("arp", 0): ("skipped", "sac cannot")}
    text = printed(build(ended=ended))
    assert "2 pending: not run yet" in text
    assert "1 skipped: sac cannot" in text


def test_markup_in_a_reason_is_text(build):
    """What looks like rich markup is printed as it is."""
    assert "[bold]no[/bold] [m]" in printed(build(ended={("arp", 1): ("failed", "[bold]no[/bold] [m]")}))


def test_piped_output_has_no_escape_codes(build):
    """Into a pipe goes plain text; in a terminal the titles are bold."""
    results = build()
    assert "\x1b" not in printed(results)
    assert "\x1b" in printed(results, force_terminal=True)


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
        (1e12, "1.00e+12"),
        (None, "n/a"),
    ],
)
def test_numbers_have_three_significant_digits(value, text):
    """Three significant digits, an exponent only far from 1, and n/a for what is no number."""
    assert format_number(value) == text
