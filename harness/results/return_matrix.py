"""Return under every reward: what each would have paid the trained policies of each. Reads results only."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.record.folder import EVALUATION
from harness.record.returns import EVENTS, mean_over_episodes, mean_return
from harness.record.trace import Trace, read_trace
from harness.registry.choice import Choice
from harness.results.combination import Group
from harness.results.results import Results
from harness.score.scored_runs import score_runs
from harness.score.scorer import SCORED

COLUMNS = [*SCORED, "episode", "reward", *EVENTS]
UNFINISHED = "no finished episode in some seeds"

Trainings = Mapping[Choice, list[Trace]]
"""The final evaluation of each seed, by the reward that it was trained with."""


@dataclass(frozen=True)
class ReturnMatrix:
    """Returns of the final evaluations, of one simulator, robot, task and algorithm.

    Attributes:
        group: What the trainings share.
        trained_with: Labels of the rewards that taught.
        returns: Shaped return of an episode, mean over episodes and seeds: by the label of the scoring reward, then
            that of the training reward.
        events: What the events of an episode paid on top, the same under every reward, by training reward.
    """

    group: Group
    trained_with: tuple[str, ...]
    returns: Mapping[str, Mapping[str, SeedMean]]
    events: Mapping[str, SeedMean]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.group.to_json(),
            "returns": {scoring: _to_json(row) for scoring, row in self.returns.items()},
            "events": _to_json(self.events),
        }


def return_matrices(results: Results) -> list[ReturnMatrix]:
    """One matrix per group of cells that are done, scored by every reward of the experiment.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    scoring = dict.fromkeys(manifest.cell.reward for manifest in results.manifests if manifest.status != "skipped")
    groups: dict[Group, dict[Choice, list[Trace]]] = {}
    for cell in sorted(results.done_cells, key=lambda cell: cell.seed):
        trace = read_trace(results.store.cell_folder(cell) / EVALUATION, COLUMNS)
        groups.setdefault(Group.of(cell), {}).setdefault(cell.reward, []).append(trace)
    return [_matrix(results, group, list(scoring), trainings) for group, trainings in groups.items()]


def _matrix(results: Results, group: Group, scoring: list[Choice], found: Trainings) -> ReturnMatrix:
    trainings = {choice: found[choice] for choice in scoring if choice in found}
    return ReturnMatrix(
        group,
        tuple(choice.label for choice in trainings),
        {choice.label: _row(results, choice, trainings) for choice in scoring},
        {choice.label: _mean([mean_return(trace, EVENTS) for trace in traces]) for choice, traces in trainings.items()},
    )


def _row(results: Results, scoring: Choice, trainings: Trainings) -> dict[str, SeedMean]:
    """Every training under one reward."""
    own = trainings[scoring][0] if scoring in trainings else None
    row = {}
    for training, traces in trainings.items():
        scored = score_runs(scoring, results.registry, own, traces)
        if scored.values is None:
            row[training.label] = SeedMean(None, notes=(scored.reason,))
        else:
            pairs = zip(scored.values, traces, strict=True)
            row[training.label] = _mean([mean_over_episodes(values, trace) for values, trace in pairs])
    return row


def _mean(values: list[float | None]) -> SeedMean:
    known = [value for value in values if value is not None]
    return mean_over_seeds(known, None if len(known) == len(values) else UNFINISHED)


def _to_json(row: Mapping[str, SeedMean]) -> dict[str, Any]:
    return {label: mean.to_json() for label, mean in row.items()}
