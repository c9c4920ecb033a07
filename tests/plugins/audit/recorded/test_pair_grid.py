"""Two rewards as a terminal shows them."""

from io import StringIO

import pytest
from rich.console import Console

from harness.eta.seed_mean import SeedMean
from harness_plugins.audit.recorded.earned import Earned, best_paid
from harness_plugins.audit.recorded.pair import Apart, mean_within, pair_of
from harness_plugins.audit.recorded.pair_grid import earned_grid, pair_grid

NOTHING = Apart(None, None, None, None)
SOME = Apart(0.25, 0.5, 0.125, 0.5)


def shown(what) -> str:
    """As words."""
    text = StringIO()
    Console(file=text, width=200).print(what)
    return " ".join(text.getvalue().split())


def test_numbers_stand_beside_what_they_mean():
    """Below three there is no interval."""
    text = shown(pair_grid(pair_of("a", "b", [SOME, SOME], [])))
    assert "distance by steps 0.250 of what both pay for the same steps distance by episodes 0.500 of" in text
    assert "opposite order 12.5% of the pairs of episodes that both tell apart; these are 50% of all pairs" in text


def test_what_is_not_defined_says_why():
    """Where it is defined in some only, in how many."""
    assert "distance by steps n/a one of the two pays every step the same, or no steps were kept" in shown(
        pair_grid(pair_of("a", "b", [NOTHING], []))
    )
    assert "for the same steps; defined in 2 of 3" in shown(pair_grid(pair_of("a", "b", [SOME, NOTHING, SOME], [])))


def test_interval_of_a_distance_stays_between_0_and_1():
    """Student's alone would not."""
    mean = mean_within([0.0, 0.1, None, 0.0])
    assert (mean.low, mean.seeds) == (0.0, 3)
    assert mean.high > mean.mean == pytest.approx(0.1 / 3)


def test_best_paid_behaviour_is_marked():
    """Under each reward by itself."""
    rows = [
        Earned("early", 2, {"a": SeedMean(1.0), "b": SeedMean(None)}),
        Earned("late", 3, {"a": SeedMean(2.0), "b": SeedMean(None)}),
    ]
    assert (best_paid(rows, "a"), best_paid(rows, "b")) == (rows[1], None)
    assert "early 2 1 n/a late 3 2 (most) n/a" in shown(earned_grid(rows, ["a", "b"]))
