"""What several things have in common, so that it is said once, and what tells them apart."""

from collections.abc import Sequence
from typing import NamedTuple

BETWEEN = " · "


class Apart(NamedTuple):
    """Descriptions of the same kind, taken apart."""

    shared: str
    """The parts that are the same in all."""
    names: list[str]
    """For each, the other parts; all of its own empty where there is but one."""


def tell_apart(descriptions: Sequence[Sequence[str]], keep: int | None = None) -> Apart:
    """Take descriptions apart, each with its parts in the same order; `keep` is a part that is always told of each."""
    is_shared = [len(set(column)) == 1 for column in zip(*descriptions, strict=True)]
    if keep is not None and is_shared:
        is_shared[keep] = False
    shared = [part for part, same in zip(descriptions[0], is_shared, strict=True) if same] if descriptions else []
    names = [
        BETWEEN.join(part for part, same in zip(parts, is_shared, strict=True) if not same) for parts in descriptions
    ]
    return Apart(BETWEEN.join(shared), names)
