"""Committed records, judged by the rule of this version: their seeds' values are all that it needs."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from harness.eta.behaviour_change import Change, Measure
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.interval import share_variance, variance_of
from harness.record.cell import NO_ROBOT, NO_SIMULATOR
from harness.record.terms import FIRST, Terms
from harness.registry.choice import Choice
from harness.results.comparison import Comparison, Group
from harness.results.verdicts import with_verdicts


def judged_anew(combinations: Sequence[Mapping[str, Any]], terms: Terms = FIRST) -> tuple[Comparison, ...]:
    """Comparisons with answers, of what ``harness report --json`` says of them.

    They hold the measures of behaviour and their seeds' values, and nothing of the rewards.

    Args:
        combinations: The key of that name.
        terms: What was agreed on before the first training.
    """
    return with_verdicts([_comparison(it) for it in combinations], terms)


def _comparison(told: Mapping[str, Any]) -> Comparison:
    seeds = tuple(told["seeds"])
    return Comparison(
        _group(told),
        told["baseline"],
        told["proposed"],
        seeds,
        None,
        tuple(_change(it, seeds) for it in told["behaviour"]),
        {},
        episodes=told["episodes"],
        deciding=tuple(told.get("deciding") or _deciding(told)),
        decided_in=told.get("decided_in") or "",
    )


def _deciding(told: Mapping[str, Any]) -> Sequence[str]:
    """The measures that decide, where the records do not name them: those of an arm, or the one of an environment."""
    named = told.get("deciding_measure")
    return DECIDING if named is None else (named,)


def _group(told: Mapping[str, Any]) -> Group:
    def choice(kind: str, missing: Choice | None = None) -> Choice:
        label = told.get(kind)
        return Choice(label, (), label) if label else missing or Choice("", (), "")

    return Group(
        told.get("robot", NO_ROBOT),
        choice("task"),
        choice("algorithm"),
        told.get("steps", 0),
        0,
        deterministic=told.get("deterministic", True),
        simulator=choice("simulator", NO_SIMULATOR),
    )


def _change(told: Mapping[str, Any], seeds: tuple[int, ...]) -> Change:
    """One measure; what the test of version 0.1 said of it is left out."""
    name, episodes = told["name"], told.get("episodes")
    if episodes is None and name == SUCCESS:
        episodes = 100
    measure = Measure(name, told["unit"], told["better"], told["manner"], episodes, told.get("title", ""))
    values = tuple((float(one), float(other)) for one, other in told["values"])
    differences = [other - one for one, other in values]
    variance = None
    if len(values) > 1:
        means = np.mean(values, axis=0).tolist()
        variance = variance_of(differences) if episodes is None else share_variance(differences, means, episodes)
    of_seeds = seeds if len(seeds) == len(values) else tuple(range(len(values)))
    return Change(
        measure, told["baseline"], told["proposed"], told["random"], told["seeds"], told["left_out"], told["low"],
        told["high"], told["p"], told["p_corrected"], values, variance, reason=told.get("reason", ""),
        of_seeds=of_seeds,
    )  # fmt: skip
