"""The agreement of rankings, in words."""

from harness.eta.ranking import Ranking
from harness.results.overview import NOTHING

TITLE = "Do the rewards keep their order?"
EXPLANATION = (
    "Kendall's tau-b between the orders that the rewards have by their success rate, mean over all pairs of places: 1 "
    "the same order everywhere, 0 unrelated orders, -1 opposite ones. The interval draws seeds again (bootstrap, 95%); "
    "with few seeds it is too narrow. It is a description: no claim rests on it, and it enters no correction."
)


def ranking_sentence(ranking: Ranking) -> str:
    """The number with its interval, or why there is none."""
    if ranking.tau is None:
        return f"Kendall's tau {NOTHING}: {ranking.note}."
    interval = f"[{ranking.low:.2f}, {ranking.high:.2f}]" if ranking.low is not None else f"({ranking.note})"
    return f"Kendall's tau {ranking.tau:.2f} {interval}: {ranking.rewards} rewards in {ranking.places} places."
