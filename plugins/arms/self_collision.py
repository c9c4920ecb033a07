"""Which links of an arm may touch one another, for engines to which its shapes are added by hand.

A group is a set of links that move together. Group 0 is the base. Group k is what the k-th joint moves and no later
joint moves.
"""

from collections.abc import Iterable
from itertools import combinations

Pair = tuple[int, int]
"""Two groups, the lower number first."""


def pairs_apart(dof: int) -> frozenset[Pair]:
    """All pairs of groups of an arm with `dof` joints, except those that a joint connects."""
    return frozenset((a, b) for a, b in combinations(range(dof + 1), 2) if b - a > 1)


def pair(one: int, other: int) -> Pair:
    """Two groups as a `Pair`."""
    return min(one, other), max(one, other)


def partners(group: int, pairs: Iterable[Pair]) -> set[int]:
    """The groups that stand together with `group` in one of `pairs`."""
    return {a if b == group else b for a, b in pairs if group in (a, b)}
