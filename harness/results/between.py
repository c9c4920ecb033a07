"""Compares the policies of two experiments that trained the same, one before and one after something was changed.

A seed is trained in both, so its two trainings are a pair: the tests are those that compare two rewards. See
``docs/statistics.md``.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, NamedTuple

from harness.errors import UsageError
from harness.eta.behaviour_change import Change, change_of
from harness.eta.headline import SUCCESS, margin_of
from harness.eta.swaps import Swaps, corrected_p, swaps_of
from harness.record.cell import Cell
from harness.results.comparison import Comparison, Group
from harness.results.measured import Measured
from harness.results.metrics import measure_of
from harness.results.results import Results


class Verdict(StrEnum):
    """How the success of the proposed reward's policies changed."""

    SAME = "the same"
    BETTER = "better"
    WORSE = "worse"
    NO_DIFFERENCE = "no difference"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True, eq=False)
class Pair:
    """One combination in both experiments.

    Attributes:
        before: The combination in the first experiment.
        after: The combination in the second experiment.
        changes: How the proposed reward's policies changed, by measure. The baseline and proposed values of a `Change`
            are those before and after.
    """

    before: Comparison
    after: Comparison
    changes: tuple[Change, ...]

    @property
    def success(self) -> Change | None:
        """The change of the success rate; None if no seed is done in both."""
        return next((change for change in self.changes if change.name == SUCCESS and change.seeds), None)

    @property
    def moved(self) -> tuple[Change, ...]:
        """Measures that a corrected test finds better or worse."""
        return tuple(change for change in self.changes if change.direction)

    @property
    def verdict(self) -> Verdict:
        """The verdict on the policies' success. It is "the same" only if every value of every measure is the same."""
        if self.success is None:
            return Verdict.CANNOT_TELL
        if all(one == other for change in self.changes for one, other in change.values):
            return Verdict.SAME
        if self.success.direction:
            return Verdict(self.success.direction)
        return Verdict.NO_DIFFERENCE if self.success.is_within(margin_of(self.success)) else Verdict.CANNOT_TELL

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.before.group.to_json(),
            "proposed": self.before.proposed,
            "verdict": self.verdict.value,
            "before": _side_to_json(self.before),
            "after": _side_to_json(self.after),
            "behaviour": [change.to_json() for change in self.changes],
        }


class Between(NamedTuple):
    """Two experiments."""

    pairs: tuple[Pair, ...]
    """Combinations that are in both."""
    only_before: tuple[Comparison, ...]
    only_after: tuple[Comparison, ...]

    @property
    def regressions(self) -> tuple[Pair, ...]:
        """The pairs in which a test finds that the proposed reward's policies succeed less often."""
        return tuple(pair for pair in self.pairs if pair.verdict == Verdict.WORSE)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "format": 1,
            "regressions": len(self.regressions),
            "combinations": [pair.to_json() for pair in self.pairs],
            "only_before": [_name(one) for one in self.only_before],
            "only_after": [_name(one) for one in self.only_after],
        }


def between(before: Results, after: Results) -> Between:
    """What changed from one experiment to the other. Null controls are left out.

    Raises:
        UsageError: The experiments share no combination.
    """
    one, other = ({_key(it): it for it in results.combinations if not it.is_control} for results in (before, after))
    shared = [key for key in one if key in other]
    if not shared:
        raise UsageError(
            f"'{before.folder}' and '{after.folder}' have no comparison in common: name two experiments that trained "
            "the same simulators, algorithms and rewards on the same task for as many steps"
        )
    trained = [(_policies(before, one[key]), _policies(after, other[key])) for key in shared]
    swaps = swaps_of(sorted({seed for first, second in trained for seed in first.keys() & second.keys()}))
    changes = [
        _changes(before, one[key], first, second, swaps) for key, (first, second) in zip(shared, trained, strict=True)
    ]
    pairs = zip(shared, _correct(changes), strict=True)
    return Between(
        tuple(Pair(one[key], other[key], found) for key, found in pairs),
        tuple(it for key, it in one.items() if key not in other),
        tuple(it for key, it in other.items() if key not in one),
    )


Key = tuple[Group, str, str]


def _key(combination: Comparison) -> Key:
    return combination.group, combination.baseline, combination.proposed


def _policies(results: Results, combination: Comparison) -> dict[int, Measured]:
    """The values of every metric for the proposed reward's cells, by seed."""
    cells: Iterable[Cell] = results.groups.get(combination.group, [])
    return {cell.seed: results.measured(cell) for cell in cells if cell.reward.label == combination.proposed}


def _changes(
    results: Results, combination: Comparison, before: dict[int, Measured], after: dict[int, Measured], swaps: Swaps
) -> tuple[Change, ...]:
    """The change of every metric in the combination's manner, over the seeds that both experiments measured so."""
    manner = combination.manner
    seeds = [seed for seed in sorted(before) if seed in after and _has(manner, before[seed], after[seed])]
    if not seeds:
        return ()
    episodes = min(it[seed].episodes[manner] for it in (before, after) for seed in seeds)
    manifest = results.manifest(results.groups[combination.group][0])
    found = []
    for name, metric in results.metrics.items():
        measure = measure_of(name, metric, manner, episodes, manifest)
        one, other = ({seed: it[seed].manners[manner][name] for seed in seeds} for it in (before, after))
        reasons = [it[seed].reasons[name] for it in (before, after) for seed in seeds if name in it[seed].reasons]
        found.append(replace(change_of(measure, one, other, swaps), reason=next(iter(reasons), "")))
    return tuple(found)


def _has(manner: str, *measured: Measured) -> bool:
    return all(manner in it.manners for it in measured)


def _correct(families: Sequence[tuple[Change, ...]]) -> list[tuple[Change, ...]]:
    """The changes with p-values that hold for all changes of all combinations together."""
    outcomes = [change.outcomes for changes in families for change in changes if change.outcomes is not None]
    p_values = iter(corrected_p(outcomes))
    return [
        tuple(replace(it, corrected=None if it.outcomes is None else next(p_values)) for it in changes)
        for changes in families
    ]


def _side_to_json(combination: Comparison) -> dict[str, Any]:
    etas = {"eta_N": combination.eta_n, "eta_P": combination.eta_p}
    return {
        "seeds": list(combination.seeds),
        "answer": combination.headline.answer.value,
        **{name: eta.to_json() for name, eta in etas.items()},
    }


def _name(combination: Comparison) -> str:
    return f"{combination.group.title} · {combination.proposed} against {combination.baseline}"
