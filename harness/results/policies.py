"""What the final policies of a reward did, cell by cell, with an arm or in an environment."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from harness.eta.behaviour_change import Quantity
from harness.log.log import BEHAVIOUR
from harness.record.cell import Cell
from harness.results.comparison import Comparison
from harness.results.metrics import measure_of
from harness.results.recordings.results import RecordedResults
from harness.results.recordings.runs import Runs
from harness.results.results import Results


class Did(NamedTuple):
    """What one policy did, in the episodes of one manner."""

    values: Mapping[str, float | None]
    """By measure."""
    episodes: int
    """How many finished episodes these are means over."""
    reasons: Mapping[str, str]
    """Why there is no value, by measure."""


class Policies(NamedTuple):
    """The policies that one reward trained, in one group of cells."""

    names: tuple[str, ...]
    """The names of the measures."""
    measure: Callable[[str, int], Quantity]
    """A function of a measure's name and of how many episodes it is a share of, if it is a share."""
    did: Mapping[int, Did]
    """By seed."""
    code: Mapping[str, str] = {}
    """By measure of an environment: its code. Metrics are computed anew, by one code for all experiments."""


def policies_of(results: Results, combination: Comparison, manner: str) -> Policies:
    """The policies of a combination's proposed reward, as far as they acted in a manner."""
    if isinstance(results, RecordedResults):
        runs = next(it.study.runs for it in results.studies if it.study and it.group == combination.group)
        return _in_environment(runs, combination.proposed, manner)
    return _of_arms(results, combination, manner)


def _of_arms(results: Results, combination: Comparison, manner: str) -> Policies:
    cells: Sequence[Cell] = results.groups.get(combination.group, [])
    measured = {it.seed: results.measured(it) for it in cells if it.reward.label == combination.proposed}
    did = {
        seed: Did(it.manners[manner], it.episodes[manner], it.reasons)
        for seed, it in measured.items()
        if manner in it.manners
    }

    def measure(name: str, episodes: int) -> Quantity:
        return measure_of(name, results.metrics[name], manner, episodes, results.manifest(cells[0]))

    return Policies(tuple(results.metrics), measure, did)


def _in_environment(runs: Runs, reward: str, manner: str) -> Policies:
    parts = {run.seed: run.parts(runs.steps) for run in runs.of(reward)}
    did = {
        seed: Did(it[manner].behaviour, it[manner].episodes, it[manner].reasons)
        for seed, it in parts.items()
        if manner in it
    }

    def measure(name: str, episodes: int) -> Quantity:
        return runs.measure(name, manner, episodes)

    sources = {name: run.facts.sources.get(f"{BEHAVIOUR}{name}") for name in runs.measures for run in runs.of(reward)}
    return Policies(runs.measures, measure, did, {name: source.text for name, source in sources.items() if source})
