"""Two rewards over several sets of recorded steps: the means of their distances."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from harness.authoring.commands import SHARE, PayLine, Rescaling, SeedMean, line_of, mean_over_seeds, rescaling_of
from harness.log import BEHAVIOUR, EPISODES, REWARD, Log

from ..distance import Distance, Form, compare_forms
from .paid import Apart, compare_paid, paid_in
from .step_apart import StepApart, steps_apart


@dataclass(frozen=True)
class Pair:
    """How far apart two rewards are. Every number is a mean over recordings or over measurements.

    Attributes:
        one: A reward.
        other: Another one.
        steps: Pearson distance of what they pay for each step, see `harness_plugins.audit.recorded.paid.Apart`.
        returns: The same of the returns of episodes.
        discordant: Share of pairs of episodes that they put in opposite orders, of those that both tell apart.
        told_apart: Share of all pairs of episodes that both tell apart.
        each: What the means are made of, by recording or measurement.
        rescaling: What the other one is, if it is the first one but for scale and offset; else None.
        largest: The steps that they pay most differently; empty where they were not looked for.
        forms: By canonical form, how far apart they are without potential shaping; empty where nobody asked.
        reasons: By canonical form without a value: why.
    """

    one: str
    other: str
    steps: SeedMean
    returns: SeedMean
    discordant: SeedMean
    told_apart: SeedMean
    each: tuple[Apart, ...]
    rescaling: Rescaling | None = None
    largest: tuple[StepApart, ...] = ()
    forms: Mapping[str, SeedMean] = field(default_factory=dict)
    reasons: Mapping[str, str] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "rewards": [self.one, self.other],
            "steps": mean_json(self.steps),
            "returns": mean_json(self.returns),
            "discordant": mean_json(self.discordant),
            "told_apart": mean_json(self.told_apart),
            "rescaled": self.rescaling and self.rescaling.to_json(),
            "each": [{"steps": it.steps, "returns": it.returns, "discordant": it.discordant} for it in self.each],
            "largest": [step.to_json() for step in self.largest],
            **{form: mean_json(mean) for form, mean in self.forms.items()},
            **({"reasons": dict(self.reasons)} if self.forms else {}),
        }


def pair_of(
    one: str,
    other: str,
    each: Sequence[Apart],
    lines: Sequence[PayLine | None],
    largest: Sequence[StepApart] = (),
    forms: Sequence[Mapping[str, Distance]] = (),
) -> Pair:
    """The means, with intervals over recordings or measurements.

    Args:
        one: A reward.
        other: Another one.
        each: How far apart they are, by recording or measurement.
        lines: The line of what they paid, in the same order.
        largest: See `Pair`.
        forms: How far apart they are by canonical form, by measurement.
    """
    known = {form: [it[form] for it in forms] for form in (forms[0] if forms else ())}
    means = {form: mean_within([it if isinstance(it, float) else None for it in of]) for form, of in known.items()}
    told = [(form, why) for it in reversed(forms) for form, why in it.items() if isinstance(why, str)]
    return Pair(
        one,
        other,
        mean_within([it.steps for it in each]),
        mean_within([it.returns for it in each]),
        mean_within([it.discordant for it in each]),
        mean_within([it.told_apart for it in each]),
        tuple(each),
        rescaling_of(lines),
        tuple(largest),
        means,
        {form: why for form, why in told if means[form].mean is None},
    )


def pairs_in(
    compared: Iterable[tuple[str, Log]],
    rewards: tuple[str, ...],
    forms: Sequence[Mapping[str, Mapping[str, Form]]] = (),
    most: int = 0,
) -> tuple[tuple[Pair, ...], list[str]]:
    """Every two rewards beside one another, and a line for each reward that is not known everywhere.

    Args:
        compared: What means are over, by name.
        rewards: Names.
        forms: By measurement and name, the rewards in canonical forms.
        most: So many steps are told that the two pay most differently.
    """
    each: dict[tuple[str, str], list[Apart]] = {pair: [] for pair in combinations(rewards, 2)}
    lines: dict[tuple[str, str], list[PayLine | None]] = {pair: [] for pair in each}
    largest: dict[tuple[str, str], list[StepApart]] = {pair: [] for pair in each}
    notes, lacking = list[str](), Counter[str]()
    count = 0
    for name, whole in compared if each else ():
        count += 1
        log = whole.without_starts()
        numbers = [*(f"{REWARD}{name}" for name in log.rewards), *(f"{BEHAVIOUR}{name}" for name in log.measures)]
        log = log.load([*EPISODES, "step", *numbers])
        paid = paid_in(log)
        can_end = "terminated" in log and bool(log["terminated"].any())
        unknown = {it: why for it, why in paid.unknown.items() if it in rewards}
        notes += [f"'{name}' does not count for reward {it!r}: {why}" for it, why in unknown.items()]
        lacking.update(it for it in rewards if it not in paid.returns and it not in unknown)
        for (one, other), found in each.items():
            if {one, other} <= paid.returns.keys():
                found.append(compare_paid(paid, one, other))
            if {one, other} <= paid.steps.keys():
                lines[one, other].append(line_of(paid.steps[one], paid.steps[other], can_end=can_end))
                known = [*largest[one, other], *(steps_apart(name, log, one, other) if most else ())]
                largest[one, other] = sorted(known, key=lambda step: -step.difference)[:most]
    notes += [f"{number:,} of {count:,} did not record reward {name!r}" for name, number in lacking.items()]
    notes += [f"No recording knows both {one!r} and {other!r}" for (one, other), found in each.items() if not found]
    apart = {(one, other): [compare_forms(one, of[one], other, of[other]) for of in forms] for one, other in each}
    return tuple(pair_of(*it, each[it], lines[it], largest[it], apart[it]) for it in each), notes


def mean_within(values: Sequence[float | None]) -> SeedMean:
    """The mean of numbers in [0, 1], its interval cut to that range; numbers that are None are left out."""
    return mean_over_seeds([value for value in values if value is not None], bounds=SHARE)


def mean_json(mean: SeedMean) -> dict[str, Any]:
    """Plain data; what the mean is over is no seed."""
    return {"mean": mean.mean, "low": mean.low, "high": mean.high, "count": mean.seeds}
