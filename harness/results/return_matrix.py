"""What each reward would have paid the policies that each reward trained. Reads results only."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from harness.eta.index import SeedMean
from harness.results.comparison import Group


@dataclass(frozen=True)
class ReturnMatrix:
    """Returns of the final evaluations with one simulator, robot, task and algorithm.

    Attributes:
        group: What the trainings share.
        trained_with: Labels of the rewards that the policies were trained with.
        returns: Shaped return of an episode, mean over episodes and seeds: by the label of the scoring reward, then
            that of the training reward.
        events: What the events of an episode paid on top, the same under every reward, by training reward; empty if
            there are none.
        manner: Where the episodes are taken from; empty for the final evaluation.
    """

    group: Group
    trained_with: tuple[str, ...]
    returns: Mapping[str, Mapping[str, SeedMean]]
    events: Mapping[str, SeedMean]
    manner: str = ""

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.group.to_json(),
            "returns": {scoring: _to_json(row) for scoring, row in self.returns.items()},
            "events": _to_json(self.events),
            **({"manner": self.manner} if self.manner else {}),
        }


def _to_json(row: Mapping[str, SeedMean]) -> dict[str, Any]:
    return {label: mean.to_json() for label, mean in row.items()}
