"""What one behaviour earned under every reward."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from harness.audit.recorded.pair import mean_json
from harness.eta.seed_mean import SeedMean


@dataclass(frozen=True)
class Earned:
    """What one behaviour earned.

    Attributes:
        behaviour: Who acted, in words.
        episodes: How many episodes.
        returns: By reward, the mean return of an episode; without a value where the reward is not known.
    """

    behaviour: str
    episodes: int
    returns: Mapping[str, SeedMean]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        returns = {name: mean_json(mean) for name, mean in self.returns.items()}
        return {"behaviour": self.behaviour, "episodes": self.episodes, "returns": returns}


def best_paid(rows: Sequence[Earned], reward: str) -> Earned | None:
    """Which behaviour earned most under a reward; None where it is known of none."""
    known = [(mean, row) for row in rows if (mean := row.returns[reward].mean) is not None]
    return max(known, key=lambda it: it[0])[1] if known else None
