"""Splits descriptions of several things into what they share, which is said once, and what differs."""

from collections.abc import Sequence
from typing import NamedTuple

BETWEEN = " · "


class Apart(NamedTuple):
    """Several descriptions, split into what they share and what differs."""

    shared: str
    """The parts that are the same in all."""
    names: list[str]
    """For each description, the parts that differ. It is empty if there is only one description."""


def tell_apart(descriptions: Sequence[Sequence[str]], keep: int | None = None) -> Apart:
    """Split descriptions, each with its parts in the same order. The part number `keep` always counts as different."""
    is_shared = [len(set(column)) == 1 for column in zip(*descriptions, strict=True)]
    if keep is not None and is_shared:
        is_shared[keep] = False
    shared = [part for part, same in zip(descriptions[0], is_shared, strict=True) if same] if descriptions else []
    names = [
        BETWEEN.join(part for part, same in zip(parts, is_shared, strict=True) if not same) for parts in descriptions
    ]
    return Apart(BETWEEN.join(shared), names)
