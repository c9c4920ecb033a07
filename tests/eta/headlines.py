"""The answers of a comparison of an arm, from its parts."""

from collections.abc import Sequence

from harness.eta.behaviour_change import Change
from harness.eta.headline import DECIDING, Headline, Names, judge, number_sentence
from harness.eta.splits import Decomposition


def headline_of(
    names: Names, decomposition: Decomposition, changes: Sequence[Change] = (), claims: int = 1
) -> Headline:
    """As `harness.results.comparison.Comparison` gives them, with the measures of one manner."""
    deciding = [change for name in DECIDING for change in changes if change.name == name and change.seeds]
    return judge(names, deciding, number_sentence(names, decomposition.splits), claims)
