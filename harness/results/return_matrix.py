"""What each reward would have paid the policies that each reward trained. Reads results only."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from harness.errors import Unscored
from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.record.folder import EVALUATION
from harness.registry.choice import Choice
from harness.results.cell_results import CellResults
from harness.results.comparison import Group
from harness.score.installed_reward import InstalledReward

UNFINISHED = "no finished episode in some seeds"

Scored = Mapping[Choice, Sequence[CellResults]]
"""The cells of each seed, by the reward that they were trained with."""


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


def return_matrices(
    scoring: Sequence[Choice], groups: Mapping[Group, Scored], installed: Callable[[Choice], InstalledReward]
) -> tuple[ReturnMatrix, ...]:
    """One matrix per group of cells that are done.

    Args:
        scoring: Every reward of the experiment.
        groups: The cells of an arm.
        installed: Gives what pays them again by a reward.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    return tuple(_matrix(installed, group, scoring, trainings) for group, trainings in groups.items())


def _matrix(
    installed: Callable[[Choice], InstalledReward], group: Group, scoring: Sequence[Choice], found: Scored
) -> ReturnMatrix:
    trainings = {choice: found[choice] for choice in scoring if choice in found}
    rewards = _unchanged(installed, scoring, trainings)
    rows: dict[str, dict[str, SeedMean]] = {choice.label: {} for choice in scoring}
    events = {}
    for training, cells in trainings.items():
        column = _Column(rewards)
        for cell in cells:
            column.add(cell)
            cell.finish()
        for choice in scoring:
            rows[choice.label][training.label] = column.mean(choice)
        events[training.label] = _mean(column.events)
    return ReturnMatrix(group, tuple(choice.label for choice in trainings), rows, events)


Scoring = Mapping[Choice, InstalledReward | str]
"""What pays again, by reward; the reason if a reward cannot pay any more."""


def _unchanged(installed: Callable[[Choice], InstalledReward], scoring: Sequence[Choice], trainings: Scored) -> Scoring:
    """The rewards that still pay what they paid in the experiment. A reward without a done cell is not checked."""
    rewards: dict[Choice, InstalledReward | str] = {}
    for choice in scoring:
        rewards[choice] = reward = installed(choice)
        try:
            if choice in trainings:
                reward.require_unchanged(trainings[choice][0].pays_recorded(reward, EVALUATION))
        except Unscored as unscored:
            rewards[choice] = str(unscored)
    return rewards


class _Column:
    """One column of the matrix: the cells of one training under every reward."""

    def __init__(self, rewards: Scoring) -> None:
        self._rewards = dict(rewards)
        self._returns: dict[Choice, list[float | None]] = {choice: [] for choice in rewards}
        self.events: list[float | None] = []

    def add(self, cell: CellResults) -> None:
        """Add a cell under all rewards at once, so that its evaluation is read once."""
        self.events.append(cell.evaluation_events())
        for choice, reward in self._rewards.items():
            if isinstance(reward, str):
                continue
            try:
                self._returns[choice].append(cell.evaluation_return(reward))
            except Unscored as unscored:
                self._rewards[choice] = str(unscored)

    def mean(self, choice: Choice) -> SeedMean:
        """The mean over the cells, or the reason why there is none."""
        reward = self._rewards[choice]
        return SeedMean(None, notes=(reward,)) if isinstance(reward, str) else _mean(self._returns[choice])


def _mean(values: list[float | None]) -> SeedMean:
    known = [value for value in values if value is not None]
    return mean_over_seeds(known, None if len(known) == len(values) else UNFINISHED)


def _to_json(row: Mapping[str, SeedMean]) -> dict[str, Any]:
    return {label: mean.to_json() for label, mean in row.items()}
