"""Whether the rewards of an experiment come in the same order in all its places. Reads results only."""

from harness.eta.ranking import Ranking, rank_agreement
from harness.results.combination import Group
from harness.results.results import Results


def ranking_of(results: Results) -> Ranking:
    """The agreement over all simulators and algorithms of the order that rewards have by their success rate."""
    places: dict[Group, dict[str, list[float]]] = {}
    for combination in results.combinations:
        success = combination.success
        if success is None or combination.is_control:
            continue
        runs = places.setdefault(combination.group, {})
        runs.setdefault(combination.baseline, [one for one, _ in success.values])
        runs[combination.proposed] = [other for _, other in success.values]
    return rank_agreement(list(places.values()))
