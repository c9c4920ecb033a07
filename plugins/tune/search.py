"""Does one search: draws trials, has their cells measured seed by seed, stops hopeless trials."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from harness.authoring.commands import Cell, Choice, Plan, Registry, choose, table_of
from harness.errors import UsageError

from .outcomes import Outcomes
from .study import Study
from .trial import Outcome, Status, TrialRecord, mean_outcome, score
from .tuning import Setup

OnTrial: TypeAlias = Callable[[TrialRecord], None]
"""A function that is told each trial that has ended."""


@dataclass
class Searcher:
    """Does the trials of one search that are not done yet.

    Attributes:
        setup: What is searched.
        rewards: Those that each trial is trained under, all of them with every seed.
        study: Where the trials are kept.
        registry: The plugins.
        outcomes: Gets cells done.
        on_trial: Told each trial that has ended.
    """

    setup: Setup
    rewards: tuple[Choice, ...]
    study: Study
    registry: Registry
    outcomes: Outcomes
    on_trial: OnTrial = lambda trial: None

    def run(self) -> None:
        """Do trials until there are as many as asked for. Interrupted trials come first."""
        while batch := self._next_batch():
            algorithms = {number: algorithm for number in batch if (algorithm := self._algorithm(number)) is not None}
            if algorithms:
                self._run_batch(algorithms)

    def _next_batch(self) -> list[int]:
        """The next batch: trials that were begun, filled up with new ones."""
        trials, size = self.study.trials, self.setup.tuning.batch
        batch = [trial.number for trial in trials if trial.status == "running"]
        for number in batch:
            self.study.complete_drawing(number)
        count = len(trials)
        while count < self.setup.tuning.trials and (count % size or not batch):
            batch.append(self.study.draw(self._first()))
            count += 1
        return batch

    def _first(self) -> dict[str, object] | None:
        """The given settings, if the space holds them. They are tried too, so that the best cannot be worse."""
        given = dict(self.setup.base.params)
        drawn = {dimension.name: dimension.locate(given[dimension.name]) for dimension in self.setup.space}
        return None if None in drawn.values() else drawn

    def _algorithm(self, number: int) -> Choice | None:
        """The algorithm with a trial's settings. If it refuses them, this ends the trial and returns None."""
        params = self.study.trials[number].params
        try:
            algorithm = choose(self.registry, "algorithms", {**table_of(self.setup.base), **params})
        except UsageError as error:
            self._end(number, "refused", reason=str(error))
            return None
        skipped = self._plan([algorithm]).skipped
        if skipped:
            self._end(number, "refused", reason=skipped[0][1])
            return None
        return algorithm

    def _plan(self, algorithms: Sequence[Choice]) -> Plan:
        """The plan of the cells. A cell must have an evaluation. It has one episode, and nothing here reads it."""
        return self.setup.plan(algorithms, self.rewards, self.registry, seeds=self.setup.seeds, evaluation_episodes=1)

    def _run_batch(self, algorithms: dict[int, Choice]) -> None:
        """Run a batch seed by seed. Every trial that goes on is trained under every reward before any is judged."""
        plan = self._plan(list(algorithms.values()))
        found: dict[int, list[Outcome]] = {number: [] for number in algorithms}
        for step, seed in enumerate(self.setup.seeds):
            if not algorithms:
                return
            told = self.outcomes(plan, _cells(plan, seed, algorithms.values()))
            for number, algorithm in list(algorithms.items()):
                own = [outcome for cell, outcome in told.items() if cell.algorithm == algorithm]
                if not self._judge(number, step, own, found[number]):
                    del algorithms[number]

    def _judge(self, number: int, step: int, own: Sequence[Outcome | str], found: list[Outcome]) -> bool:
        """Whether a trial goes on; `own` are the outcomes of this seed, `found` gathers those of all."""
        reasons = [outcome for outcome in own if isinstance(outcome, str)]
        if reasons:
            self._end(number, "failed", reason=reasons[0])
            return False
        found += [outcome for outcome in own if isinstance(outcome, Outcome)]
        mean, last = mean_outcome(found), len(self.setup.seeds) - 1
        value = score(mean, self.setup.tuning.validation_episodes * len(self.rewards) * len(self.setup.seeds))
        self.study.report(number, step, value, mean, len(found))
        if step == last:
            self._end(number, "complete", value)
        elif self.study.is_hopeless(number):
            self._end(number, "pruned")
            return False
        return step < last

    def _end(self, number: int, status: Status, value: float | None = None, reason: str = "") -> None:
        self.study.end(number, status, value, reason)
        self.on_trial(self.study.trials[number])


def _cells(plan: Plan, seed: int, algorithms: Collection[Choice]) -> list[Cell]:
    return [cell for cell in plan.cells if cell.seed == seed and cell.algorithm in algorithms]
