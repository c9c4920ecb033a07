"""What stands beside the answers over all places."""

from types import SimpleNamespace

import pytest

from harness.record import Terms
from harness.report.rows.comparison import grown_text, joined_text


def of_terms(**given):
    """Results of a plan with these terms."""
    return SimpleNamespace(plan=SimpleNamespace(terms=Terms(**given)))


@pytest.mark.parametrize(
    ("told", "terms", "parts"),
    [
        (joined_text, {"joined": ("arp", "dense")}, ("arp and dense came later", "answer may have changed")),
        (joined_text, {"grown": (4,)}, ()),
        (grown_text, {"grown": (4,)}, ("intervals that decide have 98 %",)),
        (grown_text, {"grown": (1, 4)}, ("Seeds were added after 1 seed and 4 seeds had been trained",)),
    ],
)
def test_what_came_later_is_told(told, terms, parts):
    """Rewards, and seeds with what they cost; else nothing."""
    text = told(of_terms(**terms))
    assert all(part in text for part in parts)
    assert bool(text) == bool(parts)
