"""What stands beside the answers over all places."""

from types import SimpleNamespace

from harness.record import Terms
from harness.report.rows.pools import grown_text, joined_text


def of_terms(**given):
    """Results of a plan with these terms."""
    return SimpleNamespace(plan=SimpleNamespace(terms=Terms(**given)))


def test_rewards_that_came_later_are_named():
    """With what that does to answers that stood before."""
    told = joined_text(of_terms(joined=("arp", "dense")))
    assert told.startswith("arp and dense came later, when results of other rewards could be seen.")
    assert "an earlier answer may have changed" in told


def test_where_none_came_later_nothing_is_said():
    """Of the rewards that the plan began with."""
    assert joined_text(of_terms(grown=(4,))) == ""


def test_added_seeds_are_told_with_what_they_cost():
    """As `tests/eta/verdict/test_later.py` measures it."""
    assert "false in 6 to 11 % of the cases" in grown_text(of_terms(grown=(4,)))


def test_each_number_of_seeds_after_which_some_were_added_is_told():
    """In words."""
    assert grown_text(of_terms(grown=(1, 4))).startswith("Seeds were added after 1 seed and 4 seeds had been trained")
