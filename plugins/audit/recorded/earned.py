"""What one behaviour was like, and what it earned under every reward."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.eta import UNBOUNDED, mean_over_seeds
from harness.eta.interval import Bounds
from harness.files.plain import Plain

from .pair import Mean

if TYPE_CHECKING:
    from harness.results.recordings.episodes import Episodes, Part

RANDOM = "random actions"


@dataclass(frozen=True)
class Earned(Plain):
    """What one behaviour was like, and what it earned.

    Attributes:
        behaviour: Who acted, in words.
        episodes: How many episodes.
        returns: By reward, the mean return of an episode; without a value where the reward is not known.
        measures: By measure, its mean in an episode; no reward enters it.
    """

    behaviour: str
    episodes: int
    returns: Mapping[str, Mean]
    measures: Mapping[str, Mean] = field(default_factory=dict)


def earned_by(
    behaviour: str, each: "Sequence[Part | Episodes]", rewards: Sequence[str], measures: Mapping[str, Bounds]
) -> Earned:
    """Means over trainings, of each of which there is a part; or over episodes that are independent of one another.

    Intervals are over what the means are over, and within what a measure can be, its bounds. There is no mean where it
    is not known of an episode.
    """
    from harness.results.recordings.episodes import Part

    def mean(name: str, of: Sequence[Mapping[str, Any]], bounds: Bounds = UNBOUNDED) -> Mean:
        known = [np.atleast_1d(values[name]) for values in of if values.get(name) is not None]
        whole = np.concatenate([np.zeros(0), *known])
        return Mean(**vars(mean_over_seeds([] if np.isnan(whole).any() else whole.tolist(), bounds=bounds)))

    return Earned(
        behaviour,
        sum(it.episodes if isinstance(it, Part) else len(it.last) for it in each),
        {name: mean(name, [it.returns for it in each]) for name in rewards},
        {name: mean(name, [it.behaviour for it in each], bounds) for name, bounds in measures.items()},
    )


def best_paid(rows: Sequence[Earned], reward: str) -> Earned | None:
    """Which behaviour earned most under a reward; None where it is known of none."""
    known = [(mean, row) for row in rows if (mean := row.returns[reward].value) is not None]
    return max(known, key=lambda it: it[0])[1] if known else None
