"""What one behaviour was like, and what it earned under every reward."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from harness import Float
from harness.eta import Estimate, mean_over_seeds

from .pair import mean_json

if TYPE_CHECKING:
    from harness.results.recordings.episodes import Episodes, Part

RANDOM = "random actions"


@dataclass(frozen=True)
class Earned:
    """What one behaviour was like, and what it earned.

    Attributes:
        behaviour: Who acted, in words.
        episodes: How many episodes.
        returns: By reward, the mean return of an episode; without a value where the reward is not known.
        measures: By measure, its mean in an episode; no reward enters it.
    """

    behaviour: str
    episodes: int
    returns: Mapping[str, Estimate]
    measures: Mapping[str, Estimate] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        returns, measures = (
            {name: mean_json(mean) for name, mean in of.items()} for of in (self.returns, self.measures)
        )
        return {"behaviour": self.behaviour, "episodes": self.episodes, "returns": returns, "measures": measures}


def earned_in_parts(behaviour: str, parts: "Sequence[Part]", rewards: Sequence[str], measures: Sequence[str]) -> Earned:
    """Means over trainings, of each of which there is a part, with intervals over them."""
    return Earned(
        behaviour,
        sum(part.episodes for part in parts),
        {name: _mean([part.returns.get(name) for part in parts]) for name in rewards},
        {name: _mean([part.behaviour.get(name) for part in parts]) for name in measures},
    )


def earned_in_episodes(
    behaviour: str, each: "Sequence[Episodes]", rewards: Sequence[str], measures: Sequence[str]
) -> Earned:
    """Means over episodes that are independent of one another, with intervals over them."""

    def mean(name: str, of: Sequence[Mapping[str, Float]]) -> Estimate:
        found = [values[name] for values in of if name in values]
        whole = np.concatenate([np.zeros(0), *found])
        return mean_over_seeds([] if np.isnan(whole).any() else whole.tolist())

    return Earned(
        behaviour,
        sum(len(episodes.last) for episodes in each),
        {name: mean(name, [episodes.returns for episodes in each]) for name in rewards},
        {name: mean(name, [episodes.behaviour for episodes in each]) for name in measures},
    )


def _mean(values: Sequence[float | None]) -> Estimate:
    return mean_over_seeds([value for value in values if value is not None])


def best_paid(rows: Sequence[Earned], reward: str) -> Earned | None:
    """Which behaviour earned most under a reward; None where it is known of none."""
    known = [(mean, row) for row in rows if (mean := row.returns[reward].value) is not None]
    return max(known, key=lambda it: it[0])[1] if known else None
