"""Two rewards over several sets of recorded steps: the means of their distances."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np

from harness import Float, Ints
from harness.eta import Estimate, Rescaling, line_of, mean_over_seeds, rescaling_of
from harness.eta.interval import SHARE, cut_to
from harness.eta.rescaling import PayLine, rounded
from harness.files.plain import Plain, tells
from harness.log import Log
from harness.log.log import BEHAVIOUR, EPISODES, REWARD

from ..distance import Distance, Form, centred_unit, compare_forms, distance_between

NOT_KNOWN = "not a number in some rows"
MEANS = ("steps", "returns", "discordant", "told_apart")
"""What `Apart` measures, and `Pair` has the means of."""


@dataclass(frozen=True, eq=False)
class Paid:
    """What rewards paid for one set of recorded steps.

    Attributes:
        steps: By reward, what it pays for each step, (steps,), finite; only rewards that are known in every step.
        returns: By reward, its sum over each finished episode, (episodes,).
        unknown: By reward that is not known in every step: why.
        can_end: Whether an episode among them ended before its time, terminated.
    """

    steps: Mapping[str, Float]
    returns: Mapping[str, Float]
    unknown: Mapping[str, str] = field(default_factory=dict)
    can_end: bool = False


def paid_in(log: Log) -> Paid:
    """What the rewards of a log paid, in its steps and in its finished episodes; of a log of episodes, in these alone.

    Args:
        log: Of steps, of episodes, or of points, which are taken for episodes. Its start rows are no steps.
    """
    from harness.results.recordings.episodes import episodes_of

    episodes, unknown = episodes_of(log), {}
    pays = {name: np.asarray(log[f"{REWARD}{name}"], np.float64) for name in episodes.returns}
    for name, paid in pays.items():
        if np.isnan(paid).any() or np.isnan(episodes.returns[name]).any():
            unknown[name] = episodes.reasons.get(f"{REWARD}{name}", NOT_KNOWN)
    known = [name for name in pays if name not in unknown]
    of_steps = {name: pays[name] for name in known} if log.facts.unit == "step" else {}
    can_end = "terminated" in log and bool(log["terminated"].any())
    return Paid(of_steps, {name: episodes.returns[name] for name in known}, unknown, can_end)


@tells(*MEANS[:-1])
@dataclass(frozen=True)
class Apart:
    """How far apart two rewards are in one set of recorded steps. Scale and offset of a reward do not matter.

    Attributes:
        steps: Pearson distance of what they pay for each step, sqrt((1 - rho) / 2), in [0, 1]; None where one of them,
            and not the other, pays every step the same.
        returns: The same of the returns of finished episodes; None also below two of them.
        discordant: Share of the pairs of episodes that the two put in opposite orders, of those that both tell apart.
        told_apart: Share of all pairs of episodes that both tell apart; None below two episodes.
        lines: The line of what they paid for each step; empty where no steps were kept.
        largest: The steps that they pay most differently; empty where they were not looked for.
    """

    steps: float | None
    returns: float | None
    discordant: float | None
    told_apart: float | None
    lines: Sequence[PayLine | None] = field(default=(), compare=False)
    largest: Sequence["StepApart"] = field(default=(), compare=False)


def compare_paid(paid: Paid, one: str, other: str) -> Apart:
    """How far apart two rewards are, both known in `paid`."""
    steps, returns = (_pearson(of, one, other) for of in (paid.steps, paid.returns))
    lines = [line_of(paid.steps[one], paid.steps[other], can_end=paid.can_end)] if one in paid.steps else []
    return Apart(steps, returns, *_order(paid.returns, one, other), lines)


def _pearson(values: Mapping[str, Float], one: str, other: str) -> float | None:
    if one not in values or len(values[one]) < 2:
        return None
    first, second = (centred_unit(values[name], float(np.abs(values[name]).max())) for name in (one, other))
    return distance_between(first, second)


def _order(returns: Mapping[str, Float], one: str, other: str) -> tuple[float | None, float | None]:
    """The shares of `Apart`."""
    # Sums in another order differ in the last digits: such returns are equal.
    first, second = (np.unique(rounded(returns[name]), return_inverse=True)[1] for name in (one, other))
    pairs, ties_one, ties_other, ties = (
        _pairs(np.unique(values, axis=0, return_counts=True)[1])
        for values in (np.zeros_like(first), first, second, np.stack([first, second], axis=1))
    )
    if not pairs:
        return None, None
    apart = pairs - ties_one - ties_other + ties
    return (_inversions(second[np.lexsort((second, first))]) / apart if apart else None), apart / pairs


def _pairs(counts: Ints) -> int:
    """How many pairs groups of so many have."""
    return int((counts * (counts - 1) // 2).sum())


def _inversions(places: Ints) -> int:
    """How many pairs stand in falling order, without looking at all of them.

    The larger number of such a pair has the first bit that differs. So for each bit the ones are counted that stand
    before a zero, of numbers with the same bits above.
    """
    found = 0
    for bit in range(int(places.max(initial=0)).bit_length()):
        order = np.argsort(places >> (bit + 1), kind="stable")
        above, is_one = places[order] >> (bit + 1), (places[order] >> bit) & 1
        begins = np.searchsorted(above, above)  # where the numbers with these bits above begin
        before = np.cumsum(is_one) - is_one
        found += int(((1 - is_one) * (before - before[begins])).sum())
    return found


MOST = 3
"""So many steps are told of each pair."""
LEAST = 0.1
"""Standard deviations; steps that are paid less differently are not told."""


@dataclass(frozen=True)
class StepApart:
    """A step for which two rewards pay very differently.

    Attributes:
        folder: The recording.
        env: Number of the env in it.
        episode: Counted from 0 in that env.
        step: Counted from 0 in that episode.
        paid: By both.
        deviations: The same in standard deviations from the mean of each reward, over the steps of that recording.
    """

    folder: str
    env: int
    episode: int
    step: int
    paid: tuple[float, float]
    deviations: tuple[float, float]

    @property
    def difference(self) -> float:
        """The difference of the deviations, never negative."""
        return abs(self.deviations[0] - self.deviations[1])


def steps_apart(folder: str, log: Log, one: str, other: str) -> list[StepApart]:
    """The steps of a log without start rows with the largest differences, largest first, one of an episode at most.

    None where a reward pays all steps the same.
    """
    values = np.stack([log[f"{REWARD}{one}"], log[f"{REWARD}{other}"]])
    spread = values.std(axis=1, keepdims=True)
    if not (spread > 1e-9 * np.abs(values).max(axis=1, keepdims=True)).all():
        return []
    deviations = (values - values.mean(axis=1, keepdims=True)) / spread
    difference = np.abs(deviations[0] - deviations[1])
    found: dict[tuple[int, int], StepApart] = {}  # by env and episode
    for row in np.argsort(-difference, kind="stable"):
        if len(found) == MOST or difference[row] < LEAST:
            break
        env, episode, step = (int(log[name][row]) if name in log else 0 for name in ("env", "episode", "step"))
        (first, second), (first_from, second_from) = values[:, row].tolist(), deviations[:, row].tolist()
        apart = StepApart(folder, env, episode, step, (first, second), (first_from, second_from))
        found.setdefault((env, episode), apart)
    return list(found.values())


@tells("mean=value", "low", "high", "count=seeds")
class Mean(Estimate):
    """A mean over recordings, measurements, episodes or parts of a data set: its interval is over no seeds."""


@tells("rewards", *MEANS, "rescaled=rescaling", "each", "largest", "*forms", "*why")
@dataclass(frozen=True)
class Pair(Plain):
    """How far apart two rewards are. Every number is a mean over recordings or over measurements.

    Attributes:
        one: A reward.
        other: Another one.
        steps: Pearson distance of what they pay for each step, see `harness_plugins.audit.recorded.pair.Apart`.
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
    steps: Mean
    returns: Mean
    discordant: Mean
    told_apart: Mean
    each: tuple[Apart, ...]
    rescaling: Rescaling | None
    largest: tuple[StepApart, ...]
    forms: Mapping[str, Mean]
    reasons: Mapping[str, str]

    @property
    def rewards(self) -> tuple[str, str]:
        """Both."""
        return self.one, self.other

    @property
    def why(self) -> Mapping[str, Any]:
        """The reasons, where somebody asked for canonical forms."""
        return {"reasons": self.reasons} if self.forms else {}


def pair_of(
    one: str,
    other: str,
    each: Sequence[Apart],
    forms: Sequence[Mapping[str, Distance]] = (),
) -> Pair:
    """The means, with intervals over recordings or measurements.

    Args:
        one: A reward.
        other: Another one.
        each: How far apart they are, by recording or measurement.
        forms: The same by canonical form, by measurement.
    """
    largest = sorted((step for it in each for step in it.largest), key=lambda step: -step.difference)
    known = {form: [it[form] for it in forms] for form in (forms[0] if forms else ())}
    means = {form: mean_within([it if isinstance(it, float) else None for it in of]) for form, of in known.items()}
    told = [(form, why) for it in reversed(forms) for form, why in it.items() if isinstance(why, str)]
    return Pair(
        one,
        other,
        **{name: mean_within([getattr(it, name) for it in each]) for name in MEANS},
        each=tuple(each),
        rescaling=rescaling_of([line for it in each for line in it.lines]),
        largest=tuple(largest[:MOST]),
        forms=means,
        reasons={form: why for form, why in told if means[form].value is None},
    )


def pairs_in(
    compared: Iterable[tuple[str, Log]],
    rewards: tuple[str, ...],
    forms: Sequence[Mapping[str, Mapping[str, Form]]] = (),
    shows_steps: bool = False,
) -> tuple[tuple[Pair, ...], list[str]]:
    """Every two rewards beside one another, and a line for each reward that is not known everywhere.

    Args:
        compared: What means are over, by name.
        rewards: Names.
        forms: By measurement and name, the rewards in canonical forms.
        shows_steps: Whether the steps are told that the two pay most differently.
    """
    found = {pair: list[Apart]() for pair in combinations(rewards, 2)}
    notes, lacking = list[str](), Counter[str]()
    count = 0
    for name, whole in compared if found else ():
        count += 1
        log = whole.without_starts()
        numbers = [*(f"{REWARD}{name}" for name in log.rewards), *(f"{BEHAVIOUR}{name}" for name in log.measures)]
        log = log.load([*EPISODES, "step", *numbers])
        paid = paid_in(log)
        unknown = {it: why for it, why in paid.unknown.items() if it in rewards}
        notes += [f"'{name}' does not count for reward {it!r}: {why}" for it, why in unknown.items()]
        lacking.update(it for it in rewards if it not in paid.returns and it not in unknown)
        for (one, other), each in found.items():
            if {one, other} <= paid.returns.keys():
                apart = compare_paid(paid, one, other)
                shown = steps_apart(name, log, one, other) if shows_steps and apart.lines else ()
                each.append(replace(apart, largest=shown))
    notes += [f"{number:,} of {count:,} did not record reward {name!r}" for name, number in lacking.items()]
    notes += [f"No recording knows both {one!r} and {other!r}" for (one, other), each in found.items() if not each]
    return tuple(
        pair_of(one, other, each, [compare_forms(one, it[one], other, it[other]) for it in forms])
        for (one, other), each in found.items()
    ), notes


def mean_within(values: Sequence[float | None]) -> Mean:
    """The mean of numbers in [0, 1], its interval cut to that range; numbers that are None are left out.

    They say how far apart two functions are: no training of them can fail, so none that was not seen is allowed for.
    """
    mean = Mean(**vars(mean_over_seeds([value for value in values if value is not None])))
    if mean.low is None or mean.high is None:
        return mean
    low, high = cut_to((mean.low, mean.high), SHARE)
    return replace(mean, low=low, high=high)
