"""Whether pay rises while behaviour falls, within one training: a hint for who watches it, and no verdict."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, log2

import numpy as np
from scipy import stats

from harness.arrays import Float
from harness.authoring.commands import Block

ERROR = 0.05
"""Of trainings in which pay does not rise or behaviour does not fall, at most this share ever has a hint."""
WIDTHS = (4, 8, 16)
"""Blocks of the windows that are compared."""
LEAST_SHARE = 0.1
"""Of success: a smaller fall does not matter."""
LEAST_OF_RANGE = 0.2
"""The same, as a share of the range of all blocks; of pay too."""


@dataclass(frozen=True)
class Hint:
    """Between two windows of a training pay rose and behaviour fell.

    Attributes:
        since: Environment steps at the end of the earlier window.
        pay: Mean of an episode, earlier and last.
        behaviour: The same.
        measure: Name of the behaviour.
        is_share: Whether each episode succeeds or fails.
        lower_is_better: Whether less of the measure is better, so that it rose.
    """

    since: int
    pay: tuple[float, float]
    behaviour: tuple[float, float]
    measure: str
    is_share: bool
    lower_is_better: bool

    @property
    def text(self) -> str:
        """One line."""
        before, now = (f"{100 * it:.0f} %" if self.is_share else f"{it:.3g}" for it in self.behaviour)
        paid, pays = (f"{it:.3g}" for it in self.pay)
        moved = "rose" if self.lower_is_better else "fell"
        return (
            f"Pay rose from {paid} to {pays} since step {self.since:,} while {self.measure} {moved} from {before} to "
            f"{now}. It is a hint, not a verdict."
        )


def hint_of(blocks: Sequence[Block], lower_is_better: bool, measure: str = "success") -> Hint | None:
    """What a training's blocks hint at, or None.

    The last blocks are compared with all earlier ones, in windows of `WIDTHS`. A hint needs two t tests at once: pay
    has risen, so that something was learned, and behaviour has fallen, if only below what an untrained robot does.
    Their level is shared out, so that all looks of a training of any length together err in `ERROR`: each size of block
    has its part, and of that each pair of windows that blocks of this size can ever make (Bonferroni).

    Args:
        blocks: Of one training; the last one is left out while it has fewer episodes than the others.
        lower_is_better: Whether less of the behaviour is better.
        measure: Name of the behaviour.
    """
    whole = [it for it in blocks if it.episodes == blocks[0].episodes]
    pay, behaviour = _Series.of(whole, "pay", 1.0), _Series.of(whole, "behaviour", 1.0 if lower_is_better else -1.0)
    if not (np.isfinite(pay.means).all() and np.isfinite(behaviour.means).all()):
        return None
    least, is_share = LEAST_OF_RANGE * np.ptp(behaviour.means, initial=0.0), behaviour.is_share
    level = ERROR / _parts(blocks[0].episodes if blocks else 1)
    found = [
        (min(one, other), pair)
        for pair in _pairs(len(whole))
        if behaviour.rise(pair) >= max(least, LEAST_SHARE * is_share)
        and pay.rise(pair) >= LEAST_OF_RANGE * np.ptp(pay.means)
        and (one := pay.surprise(pair)) > -np.log(level)
        and (other := behaviour.surprise(pair)) > -np.log(level)
    ]
    if not found:
        return None
    _, (begin, last, width) = max(found)
    windows = slice(begin, begin + width), slice(last, last + width)
    return Hint(
        since=whole[begin + width - 1].steps,
        pay=tuple(float(pay.means[it].mean()) for it in windows),
        behaviour=tuple(float(abs(behaviour.means[it].mean())) for it in windows),
        measure=measure,
        is_share=is_share,
        lower_is_better=lower_is_better,
    )
