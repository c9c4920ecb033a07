"""What a comparison comes to, in words: behaviour first, then how much of each eta is only ruler."""

import math
from collections.abc import Sequence

from harness.eta.behaviour_change import Change
from harness.eta.decompose import Decomposition, Split
from harness.eta.index import Ratio

NO_CHANGE = 1.05
"""An eta within this factor of 1 has nothing to be split."""
SUCCESS = "success_rate"
ALPHA = 0.05
OPPOSED = 1.1
"""Beyond this share of one part the other pulls the other way."""


def verdict(decomposition: Decomposition, changes: Sequence[Change] = (), corrected: float | None = None) -> str:
    """One line for people.

    Args:
        decomposition: Of both etas.
        changes: Measures of behaviour, success first in weight; empty where only rewards were recorded.
        corrected: p-value of the change in success, corrected for all comparisons of the experiment.
    """
    parts = [_behaviour(changes, corrected)] if changes else []
    return " ".join([*parts, *(_split(name, split) for name, split in decomposition.splits.items())])


def basis(decomposition: Decomposition, changes: Sequence[Change], episodes: int) -> str:
    """What the verdict rests on, and what would make it firmer."""
    seeds = max((change.seeds for change in changes), default=0)
    evaluated = "1 evaluation episode" if episodes == 1 else f"{episodes} evaluation episodes"
    each = "" if seeds == 1 else " each"
    traces = "re-scored" if decomposition.is_split else "as recorded"
    parts = [f"Rests on {_count(seeds, 'paired ')}, {evaluated}{each}, and the training traces {traces}."]
    for name, split in decomposition.splits.items():
        if split.seeds_needed is not None and split.seeds_needed > seeds:
            parts.append(f"About {split.seeds_needed} seeds would decide whether {name} differs from 1.")
    return " ".join(parts)


def _behaviour(changes: Sequence[Change], corrected: float | None) -> str:
    """The robot's behaviour: success decides; where it does not, the measures that differ are named."""
    success = next((change for change in changes if change.name == SUCCESS), None)
    others = [change for change in changes if change is not success and change.direction]
    if success is None or success.baseline is None or success.proposed is None:
        return "How the robot behaves was not measured."
    rates = f"success {success.proposed:.0%} against {success.baseline:.0%}"
    if success.direction:
        return _clear_success(success, rates, corrected)
    if success.low is None and not others:
        return f"Whether the robot behaves differently cannot be told from {_count(success.seeds)} ({rates})."
    if not others:
        return f"The robot behaves no differently as far as {_count(success.seeds)} tell ({rates})."
    told = ", ".join(
        f"{change.name.replace('_', ' ')} {change.direction} ({change.proposed:.3g} against {change.baseline:.3g}"
        f"{' ' + change.unit if change.unit else ''})"
        for change in others
    )
    return f"The robot succeeds as often as far as {_count(success.seeds)} tell ({rates}); {told}."


def _clear_success(success: Change, rates: str, corrected: float | None) -> str:
    """A success rate with a direction, and why that is not sure where it is not."""
    if not success.sure:
        return f"The robot seems to behave {success.direction} ({rates}, {_count(success.seeds)} only)."
    if corrected is None or corrected >= ALPHA:
        doubt = "which among all comparisons may be chance"
        return f"The robot seems to behave {success.direction} ({rates}, {doubt})."
    return f"The robot behaves {success.direction} ({rates})."


def _count(seeds: int, kind: str = "") -> str:
    return f"1 {kind}seed" if seeds == 1 else f"{seeds} {kind}seeds"


def _split(name: str, split: Split) -> str:
    eta = split.eta
    if eta.value is None:
        return f"{name} n/a: {eta.note}."
    if eta.near_zero is not None:
        return f"{name} says little: {eta.near_zero}."
    told = f"{name} {eta.value:.3g}"
    if split.ruler.value is None and split.other_ruler.value is None:
        return f"{told}: not split, {split.ruler.note}."
    if eta.value > 0.0 and abs(math.log(eta.value)) < math.log(NO_CHANGE):
        return f"{told}: next to no change{_hidden_ruler(split.other_ruler)}."
    if eta.low is not None and eta.high is not None and eta.low <= 1.0 <= eta.high:
        told += ", which these runs cannot tell from 1"
    return f"{told}: {_parts(split)}."


def _parts(split: Split) -> str:
    """What the eta is made of, as far as both paths agree."""
    paths = ((split.ruler, split.behaviour), (split.other_ruler, split.other_behaviour))
    usable = [(ruler, behaviour) for ruler, behaviour in paths if _is_usable(split.eta, ruler, behaviour)]
    if not usable:
        return "not split, its parts rest on indices near zero or of unlike sign"
    shares = [_share(split.eta, ruler) for ruler, _ in usable]
    words = next((words for words, low, high in WORDS if low <= min(shares) and max(shares) <= high), None)
    if words is None:
        unlike = split.disagreement if split.paths_disagree else "the two paths give the ruler unlike shares"
        return f"not split, {unlike}"
    told = words + _opposition(shares[0], *usable[0])
    if len(usable) == 1:
        return f"{told}; the other path rests on an index near zero"
    return f"{told}; the two paths disagree on how much" if split.paths_disagree else told


WORDS = (
    ("all of it ruler", 0.9, math.inf),
    ("all of it behaviour", -math.inf, 0.1),
    ("mostly ruler", 0.5, math.inf),
    ("mostly behaviour", -math.inf, 0.5),
    ("about half ruler, half behaviour", 0.25, 0.75),
)
"""How much of the logarithm of eta is the ruler's, along every path that can be used; the first that fits."""


def _opposition(share: float, ruler: Ratio, behaviour: Ratio) -> str:
    """The part that pulls the other way, where one does."""
    if share > OPPOSED:
        return f" (x {ruler.value:.3g}, against behaviour x {behaviour.value:.3g})"
    if share < 1.0 - OPPOSED:
        return f" (x {behaviour.value:.3g}, against ruler x {ruler.value:.3g})"
    return ""


def _is_usable(eta: Ratio, ruler: Ratio, behaviour: Ratio) -> bool:
    """Whether a path says something: no part missing, not positive, or near zero."""
    parts = (eta, ruler, behaviour)
    return all(part.value is not None and part.value > 0.0 and part.near_zero is None for part in parts)


def _share(eta: Ratio, ruler: Ratio) -> float:
    """Share of the ruler in the logarithm of eta; both are positive."""
    assert ruler.value is not None
    assert eta.value is not None
    return math.log(ruler.value) / math.log(eta.value)


def _hidden_ruler(ruler: Ratio) -> str:
    """What an eta of next to 1 may hide."""
    if ruler.value is None or ruler.value <= 0.0 or ruler.near_zero is not None:
        return ""
    if abs(math.log(ruler.value)) < math.log(NO_CHANGE):
        return ""
    return f", though the ruler alone gives {ruler.value:.3g}"
