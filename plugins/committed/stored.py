"""Comparisons as ``results.json`` tells them: their measures and seeds' values, their numbers, how they learned."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from harness.authoring.commands import (
    BROUGHT,
    DECIDING,
    PAID,
    SUCCESS,
    Behaviour,
    Change,
    Choice,
    Comparison,
    Decomposition,
    Group,
    Index,
    Learning,
    LearningCurve,
    Number,
    Point,
    Quantity,
    Ratio,
    ReturnSplit,
    SeedMean,
    Split,
    SplitPath,
    SumSplit,
    with_intervals,
)

WEAK = ": the ratio says little"
"""What follows the remark that an index is near zero."""
PARTS = ("eta", "per_seed", "ruler", "behaviour", "interaction")
WHO = ("baseline", "proposed")
UNKNOWN = {"mean": None, "low": None, "high": None, "seeds": 0, "note": ""}


def stored_comparisons(record: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The comparisons of ``results.json``, each once; of version 0.1 in environments those of their studies."""
    yield from record.get("combinations") or studied_comparisons(record)


def studied_comparisons(record: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The comparisons in environments, with what their study says of all of them."""
    for place in record.get("studies", ()):
        for told in place["study"]["comparisons"]:
            told.setdefault("task", place["task"])
            told.setdefault("algorithm", place["algorithm"])
            told.setdefault("steps", place["study"]["steps"])
            yield told


def behaviour_of(told: Mapping[str, Any]) -> Comparison:
    """A comparison with its measures of behaviour and their seeds' values, and nothing of the rewards."""
    seeds = tuple(told["seeds"])
    measured = Behaviour(
        tuple(_change(it, seeds) for it in told["behaviour"]),
        episodes=told["episodes"],
        deciding=tuple(told.get("deciding") or _deciding(told)),
        decided_in=told.get("decided_in") or "",
        same_steps=told.get("same_steps", False),
    )
    found = Comparison(_group(told), told["baseline"], told["proposed"], seeds, _trained(told, seeds), measured)
    return replace(found, number=Number(manner=found.manner, why_none=found.why_none))


def _trained(told: Mapping[str, Any], seeds: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """All seeds of both rewards; up to version 0.2 those that both have."""
    one, other = (tuple(told.get("trained", {}).get(who, seeds)) for who in WHO)
    return one, other


def comparison_of(told: Mapping[str, Any], manner: str) -> Comparison:
    """A comparison with its numbers too, without the curves; of the mean returns those in one manner are told."""
    found = behaviour_of(told)
    number = replace(
        found.number,
        decomposition=_decomposition(told),
        returns={manner: _returned(it) for manner, it in (told.get("returns") or {}).items()},
        number_of="indices" if found.group.subject == "robot" else "returns",
        manner=manner,
    )
    return replace(found, measured=replace(found.measured, decided_in=manner), number=number)


def learning_in(told: Mapping[str, Any]) -> Learning | None:
    """How a comparison learned; None where that was not measured."""
    learned = told.get("learning")
    if not learned:
        return None
    metrics = learned.get("metrics") or {**learned, **_as_paid(told, learned)}  # version 0.1: the measures alone
    baseline, proposed = (
        LearningCurve(told[who], (), {name: tuple(map(_point, it[who])) for name, it in metrics.items()})
        for who in ("baseline", "proposed")
    )
    return Learning(baseline, proposed, {name: it.get("random") for name, it in metrics.items()})


def _as_paid(told: Mapping[str, Any], learned: Mapping[str, Any]) -> dict[str, Any]:
    """What each training's own reward paid it, of version 0.1; empty where that is not there."""
    own = {who: learned.get(f"return paid by {told[who]}") for who in ("baseline", "proposed")}
    return {PAID: {who: it[who] for who, it in own.items() if it}} if all(own.values()) else {}


def _decomposition(told: Mapping[str, Any]) -> Decomposition | None:
    indices = told.get("indices")  # of version 0.1, in an environment
    if indices is None:
        indices = {**told, "baseline": told.get("baseline_index"), "proposed": told.get("proposed_index")}
    if indices["baseline"] is None or indices["proposed"] is None:
        return None
    baseline, proposed = (_index(indices[who]) for who in ("baseline", "proposed"))
    return Decomposition(
        baseline, proposed, _split(indices["eta_N"]), _split(indices["eta_P"]), _sum(indices.get("total") or {})
    )


def _index(told: Mapping[str, Any]) -> Index:
    return Index(told["first_negative"], told["crossover"], told["steps"], told["I_N"], told["I_P"])


def _split(told: Mapping[str, Any]) -> Split:
    paths = tuple(SplitPath(_ratio(it["ruler"]), _ratio(it["behaviour"])) for it in told["paths"])
    eta, per_seed, ruler, behaviour, interaction = (_ratio(told[name]) for name in PARTS)
    return Split(eta, per_seed, ruler, behaviour, interaction, paths)


def _ratio(told: Mapping[str, Any]) -> Ratio:
    first, *others = told["note"].split("; ")
    near_zero = first.removesuffix(WEAK) if first.endswith(WEAK) else None
    notes = tuple(filter(None, others if near_zero else [first, *others]))
    return Ratio(told["value"], told["low"], told["high"], notes, near_zero)


def _returned(told: Mapping[str, Any]) -> ReturnSplit:
    returns = {(it["paid_by"], it["trained_by"]): _mean(it) for it in told["returns"]}
    return ReturnSplit(returns, _split(told["ratio"]), _sum(told["difference"]))


def _sum(told: Mapping[str, Any]) -> SumSplit:
    return SumSplit(**{name: _mean(told.get(name) or UNKNOWN) for name in ("change", "ruler", "behaviour")})


def _mean(told: Mapping[str, Any]) -> SeedMean:
    return SeedMean(told["mean"], told["low"], told["high"], told["seeds"], tuple(filter(None, [told["note"]])))


def _point(told: Mapping[str, Any]) -> Point:
    return Point(told["steps"], _mean(told))


def _deciding(told: Mapping[str, Any]) -> Sequence[str]:
    """The measures that decide, where the records do not name them: those of an arm, or the one of an environment."""
    named = told.get("deciding_measure")
    return DECIDING if named is None else (named,)


def _group(told: Mapping[str, Any]) -> Group:
    def choice(kind: str, missing: Choice | None = None) -> Choice:
        label = told.get(kind)
        return Choice(label, (), label) if label else missing or Choice("", (), "")

    return Group(
        told.get("robot", BROUGHT.robot),
        choice("task"),
        choice("algorithm"),
        told.get("steps", 0),
        0,
        deterministic=told.get("deterministic", True),
        simulator=choice("simulator", BROUGHT.simulator),
    )


def _change(told: Mapping[str, Any], seeds: tuple[int, ...]) -> Change:
    """One measure with the p-values of its record. Its intervals are made anew."""
    name, episodes = told["name"], told.get("episodes")
    if episodes is None and name == SUCCESS:
        episodes = 100
    measure = Quantity(name, told["unit"], told["better"], told["manner"], episodes, told.get("title", ""))
    trainings = _trainings(told, seeds)
    without = told["left_out"] if trainings[0].keys() == trainings[1].keys() else 0
    found = Change(
        measure,
        told["baseline"],
        told["proposed"],
        told["random"],
        trainings,
        (0, without),
        p=told["p"],
        corrected=told["p_corrected"],
        reason=told.get("reason", ""),
    )
    return with_intervals(found)


def _trainings(told: Mapping[str, Any], seeds: tuple[int, ...]) -> tuple[dict[int, float], dict[int, float]]:
    """The values by seed; up to version 0.2 in pairs, a seed each."""
    if "trainings" in told:
        one, other = ({int(seed): value for seed, value in told["trainings"][who].items()} for who in WHO)
        return one, other
    pairs = told["values"]
    of_seeds = seeds if len(seeds) == len(pairs) else range(len(pairs))
    one, other = ({seed: float(pair[side]) for seed, pair in zip(of_seeds, pairs, strict=True)} for side in (0, 1))
    return one, other
