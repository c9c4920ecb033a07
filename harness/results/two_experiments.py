"""Compares the policies of two experiments that trained the same, one before and one after something was changed.

A seed is trained in both, so its two trainings are a pair: the tests are those that compare two rewards. See
``docs/statistics.md``.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, NamedTuple, NoReturn

from harness.errors import UsageError
from harness.eta.behaviour_change import NO_WORD, Change, change_of
from harness.eta.headline import is_within, margin_of
from harness.eta.swaps import ALPHA, Swaps, corrected_p, swaps_of
from harness.results.comparison import Comparison, Group, still_to_come
from harness.results.results import Results
from harness.results.trainings import Policies


class Verdict(StrEnum):
    """How the measure that decides changed for the proposed reward's policies: success, or that of an environment."""

    SAME = "the same"
    BETTER = "better"
    WORSE = "worse"
    NO_DIFFERENCE = "no difference"
    CANNOT_TELL = "cannot tell"
    INTERIM = "interim"
    """Planned trainings of one of the experiments are still to come."""


@dataclass(frozen=True, eq=False)
class BeforeAfter:
    """One combination in both experiments.

    Attributes:
        before: The combination in the first experiment.
        after: The combination in the second experiment.
        changes: How the proposed reward's policies changed, by measure. The baseline and proposed values of a `Change`
            are those before and after.
        other_code: Measures of an environment whose code is not the same in both experiments.
    """

    before: Comparison
    after: Comparison
    changes: tuple[Change, ...]
    other_code: tuple[str, ...] = ()

    @property
    def decisive(self) -> Change | None:
        """The change of the first measure that decides; None if no seed is done in both."""
        deciding = self.before.measured.deciding[:1]
        return next((change for change in self.changes if change.name in deciding and change.seeds), None)

    @property
    def moved(self) -> tuple[Change, ...]:
        """Measures that a corrected test finds better or worse."""
        return tuple(change for change in self.changes if change.direction)

    @property
    def is_interim(self) -> bool:
        """Whether planned trainings of one of the experiments are still to come. Nothing is tested before."""
        return still_to_come((self.before, self.after)) > 0

    @property
    def verdict(self) -> Verdict:
        """The verdict on what decides. It is "the same" only if every value of every measure is the same."""
        if self.decisive is None:
            return Verdict.CANNOT_TELL
        if all(one == other for one, other in (change.trainings for change in self.changes)):
            return Verdict.SAME
        if self.is_interim:
            return Verdict.INTERIM
        if self.decisive.direction:
            return Verdict(self.decisive.direction)
        return Verdict.NO_DIFFERENCE if is_within(self.decisive, margin_of(self.decisive)) else Verdict.CANNOT_TELL

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.before.group.to_json(),
            "proposed": self.before.proposed,
            "verdict": self.verdict.value,
            "before": _side_to_json(self.before),
            "after": _side_to_json(self.after),
            "behaviour": [change.to_json() for change in self.changes],
            "other_code": list(self.other_code),
        }


class Between(NamedTuple):
    """Two experiments."""

    pairs: tuple[BeforeAfter, ...]
    """Combinations that are in both."""
    only_before: tuple[Comparison, ...]
    only_after: tuple[Comparison, ...]

    @property
    def regressions(self) -> tuple[BeforeAfter, ...]:
        """The pairs in which a test finds that the proposed reward's policies do worse in what decides."""
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
    one, other = (_compared(results) for results in (before, after))
    shared = [key for key in one if key in other]
    if not shared:
        raise UsageError(
            f"'{before.folder}' and '{after.folder}' have no comparison in common: name two experiments that trained "
            "the same algorithms and rewards in the same places on the same task for as many steps"
        )
    manners = {key: one[key].manner for key in shared}
    trained = [
        (_policies(before, one[key], manners[key]), _policies(after, other[key], manners[key])) for key in shared
    ]
    swaps = swaps_of(sorted({seed for first, second in trained for seed in first.did.keys() & second.did.keys()}))
    changes = [_changes(first, second, swaps) for first, second in trained]
    is_interim = still_to_come([*one.values(), *other.values()]) > 0
    pairs = zip(shared, _correct(changes, NO_WORD if is_interim else ALPHA), trained, strict=True)
    return Between(
        tuple(BeforeAfter(one[key], other[key], found, _other_code(*both)) for key, found, both in pairs),
        tuple(it for key, it in one.items() if key not in other),
        tuple(it for key, it in other.items() if key not in one),
    )


def _policies(results: Results, comparison: Comparison, manner: str) -> Policies:
    trainings = results.trainings(comparison.group)
    return NONE_TRAINED if trainings is None else trainings.policies(comparison.proposed, manner)


def _no_measure(name: str, episodes: int) -> NoReturn:
    raise KeyError(name)


NONE_TRAINED = Policies((), _no_measure, {})


def _compared(results: Results) -> dict[tuple[Group, str, str], Comparison]:
    """Comparisons with the experiment's baseline. An environment has others too, of the same policies."""
    found = (it for it in results.combinations if it.baseline == results.baseline and not it.is_control)
    return {(it.group, it.baseline, it.proposed): it for it in found}


def _changes(before: Policies, after: Policies, swaps: Swaps) -> tuple[Change, ...]:
    """The change of every measure that both experiments have, over the seeds that are done in both."""
    seeds = sorted(before.did.keys() & after.did.keys())
    if not seeds:
        return ()
    did = (before.did, after.did)
    episodes = min(it[seed].episodes for it in did for seed in seeds)
    found = []
    for name in (name for name in before.names if name in after.names):
        one, other = ({seed: it[seed].values.get(name) for seed in seeds} for it in did)
        reasons = [it[seed].reasons[name] for it in did for seed in seeds if name in it[seed].reasons]
        change = change_of(before.measure(name, episodes), one, other, swaps, is_paired=True)
        found.append(replace(change, reason=next(iter(reasons), "")))
    return tuple(found)


def _other_code(before: Policies, after: Policies) -> tuple[str, ...]:
    return tuple(name for name in before.names if name in after.names and before.code.get(name) != after.code.get(name))


def _correct(families: Sequence[tuple[Change, ...]], level: float) -> list[tuple[Change, ...]]:
    """The changes with p-values that hold for all changes of all combinations together."""
    outcomes = [change.outcomes for changes in families for change in changes if change.outcomes is not None]
    p_values = iter(corrected_p(outcomes))
    return [
        tuple(replace(it, corrected=None if it.outcomes is None else next(p_values), level=level) for it in changes)
        for changes in families
    ]


def _side_to_json(comparison: Comparison) -> dict[str, Any]:
    etas = {"eta_N": comparison.number.eta_n, "eta_P": comparison.number.eta_p}
    return {
        "seeds": list(comparison.seeds),
        "answer": comparison.headline.answer.value,
        **{name: eta.to_json() for name, eta in etas.items()},
    }


def _name(comparison: Comparison) -> str:
    return f"{comparison.group.title} · {comparison.proposed} against {comparison.baseline}"
