"""Comparisons at a glance, as text: a line for each, and what is the same in all."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Literal, NamedTuple, TypeAlias

from harness.eta.amounts import short_values
from harness.eta.behaviour_change import Change
from harness.eta.headline import (
    SHORT,
    ReturnSplit,
    count_seeds,
    estimate_text,
    factor_text,
    format_number,
    is_drawable,
    key_of,
    signed,
    value_text,
)
from harness.eta.index import NOTHING
from harness.eta.manner import TRAINING, WHOLE
from harness.eta.splits import BB, KK
from harness.results.comparison import Comparison
from harness.text import visible

ARROW = " -> "
"""Between what is measured of the baseline and of the proposed reward."""
PAY = "pay of an episode"
ETAS = ("eta_N", "eta_P")
OWN = "own"
"""What an environment's own reward is called."""
Numbers: TypeAlias = Literal["none", "indices", "pay"]
OF_NUMBERS: Mapping[Numbers, tuple[str, ...]] = {
    "none": (),
    "indices": ("eta_N", "eta_P", "ruler of eta_P"),
    "pay": (PAY, "change", "ruler", "behaviour"),
}
READING: Mapping[Numbers, str] = {
    "none": "What was paid is not compared.",
    "indices": (
        "The pay of an episode is not known. eta_N and eta_P compare what the trainings were paid, by the note's rule: "
        "an eta_N below 1 and an eta_P above 1 count as better. The ruler is the part of eta_P that is rescaling alone."
    ),
    "pay": (
        "Pay is that of an episode, each training by its own reward: x 2 is twice the baseline's. More pay is neither "
        "better nor worse. The ruler is the part of the change that is rescaling alone: both rewards pay the same "
        "episodes. The rest is behaviour."
    ),
}


class Overview(NamedTuple):
    """The columns of a table with a line for each comparison."""

    subject: str
    """``robot`` or ``agent``."""
    measure: str
    """The name of the measure that decides."""
    numbers: Numbers
    """Which numbers follow it: the pay of an episode, without one both indices, or none."""

    @property
    def headings(self) -> tuple[str, ...]:
        """The headings of `overview_row`."""
        return ("", f"the {self.subject}", "decided by", self.measure, *OF_NUMBERS[self.numbers])

    @property
    def reading(self) -> str:
        """How to read the table."""
        return f"{self.measure}: baseline -> proposed. {READING[self.numbers]}"


def overview_of(combinations: Sequence[Comparison]) -> Overview:
    """The columns for these comparisons, of which there must be at least one."""
    names = dict.fromkeys(name for it in combinations for name in it.measured.deciding[:1])
    numbers: Numbers = "none"
    if any(it.number.has_pay for it in combinations):
        numbers = "pay" if any(it.number.pay for it in combinations) else "indices"
    measure = " / ".join(map(short_name, names)) or "behaviour"
    trained = f" {TRAINING}" if names and all(it.manner in (WHOLE, TRAINING) for it in combinations) else ""
    return Overview(combinations[0].group.subject, f"{measure}{trained}", numbers)


def shared_text(combinations: Sequence[Comparison]) -> str:
    """What is the same in all combinations, of which there must be at least one."""
    varying, first = varying_kinds(combinations), combinations[0]
    told = [label for kind, label in first.group.shown.items() if kind not in varying]
    if varying and len({it.proposed for it in combinations}) == 1:
        told.append(first.proposed)
    if len({it.baseline for it in combinations}) == 1:
        own = ", the environment's own reward" if first.baseline == OWN else ""
        told.append(f"against {first.baseline}{own}")
    if "steps" not in varying:
        told.append(f"{first.group.steps:,} steps")
    if len({it.counts for it in combinations}) == 1:
        told.append(" against ".join(dict.fromkeys(map(count_seeds, first.counts))))
    return " · ".join(told)


def line_names(combinations: Sequence[Comparison]) -> list[str]:
    """A name for each combination: what differs between the groups, and the reward if there are several."""
    varying = varying_kinds(combinations)
    with_reward = not varying or len({it.proposed for it in combinations}) > 1
    named = zip(combinations, reward_names(combinations), strict=True)
    return [" · ".join(filter(None, (group_name(it, varying), reward * with_reward))) for it, reward in named]


def reward_names(combinations: Sequence[Comparison]) -> list[str]:
    """The proposed reward of each combination, with the one that it is compared with if that is not always the same."""
    several = len({it.baseline for it in combinations}) > 1
    return [f"{it.names.proposed} against {it.baseline}" if several else it.names.proposed for it in combinations]


def varying_kinds(combinations: Sequence[Comparison]) -> list[str]:
    """Kinds of labels that differ between groups; ``steps``, or the ``manner`` of evaluations, where these differ."""
    told = [{**it.group.labels, "steps": it.group.steps, "manner": it.group.manner} for it in combinations]
    kinds = [*dict.fromkeys(kind for it in combinations for kind in it.group.labels), "steps", "manner"]
    return [kind for kind in kinds if len({of.get(kind) for of in told}) > 1]


def group_name(comparison: Comparison, varying: Sequence[str]) -> str:
    """The name of a combination's group: its labels of the kinds that differ."""
    group = comparison.group
    told = {**group.shown, "steps": f"{group.steps:,} steps", "manner": f"evaluated {group.manner}"}
    return " · ".join(told[kind] for kind in varying)


def overview_row(name: str, comparison: Comparison, with_intervals: bool, overview: Overview) -> tuple[str, ...]:
    """The values under the headings of an overview."""
    answer, number = comparison.headline.answer.value.upper(), comparison.number
    measured = (name, answer, decider_text(comparison), measure_text(comparison.decisive))
    if overview.numbers == "none":
        return measured
    if overview.numbers == "pay":
        return (*measured, *pay_texts(number.pay, with_intervals))
    write = estimate_text if with_intervals else value_text
    return (*measured, *(write(number.splits[name].eta) for name in ETAS), value_text(number.splits["eta_P"].ruler))


def pay_texts(pay: ReturnSplit | None, with_intervals: bool = False) -> tuple[str, ...]:
    """The pay of an episode under both rewards, how much it changed, and both parts, as everywhere else.

    Args:
        pay: The pay; None if it is not known.
        with_intervals: Whether the interval of the change stands beside it.
    """
    if pay is None:
        return (NOTHING,) * 4
    own = ARROW.join(format_number(pay.returns[pair].value) for pair in (BB, KK))
    write = estimate_text if with_intervals else value_text
    if pay.has_ratio:
        return own, f"x {write(pay.ratio.eta)}", factor_text(pay.ratio.ruler), factor_text(pay.ratio.behaviour)
    return own, write(pay.total.change, signed), signed(pay.total.ruler.value), signed(pay.total.behaviour.value)


def measure_text(change: Change | None) -> str:
    """Both values of a measure, with as many digits as tell them apart."""
    if change is None or change.baseline is None or change.proposed is None:
        return NOTHING
    return ARROW.join(short_values(change))


def decider_text(comparison: Comparison) -> str:
    """The measure that decided, with its values if the overview has no column for it."""
    name, first = comparison.headline.decided_by, comparison.decisive
    deciding = {key_of(it): it for it in comparison.decisive_changes}
    return decided_by_text(name, None if first is None else key_of(first), measure_text(deciding.get(name or "")))


def decided_by_text(name: str | None, first: str | None, values: str) -> str:
    """The measure `name` that decided, with `values` if it is not the `first` one, which has a column."""
    if name is None:
        return "-"
    return short_name(name) if name == first else f"{short_name(name)}, {values}"


def short_name(key: str) -> str:
    """The name of a measure for a heading or a cell, from its `harness.eta.headline.key_of`."""
    name, blank, manner = key.partition(" ")
    return f"{SHORT.get(name, name.replace('_', ' '))}{blank}{manner}"


def index_rows(combinations: Sequence[Comparison], with_intervals: bool) -> list[tuple[str, ...]]:
    """The note's two etas of each comparison, each beside its ruler x behaviour; none where the overview has them.

    An eta whose index is 0 under both rewards has no value here.
    """
    if not combinations or overview_of(combinations).numbers != "pay":
        return []
    rows, write = [], estimate_text if with_intervals else value_text
    for name, comparison in zip(line_names(combinations), combinations, strict=True):
        splits, told = comparison.number.index_splits, list[str]()
        for split in map(splits.get, ETAS):
            is_split = split and split.paths and is_drawable(split.eta)
            parts = f"{value_text(split.ruler)} x {value_text(split.behaviour)}" if split and is_split else NOTHING
            told += [write(split.eta) if split else NOTHING, parts]
        rows += [(name or comparison.proposed, *told)] if splits else []
    return rows


def overview_rows(combinations: Sequence[Comparison]) -> list[tuple[str, ...]]:
    """A line for each comparison, with intervals."""
    named = zip(line_names(combinations), combinations, strict=True)
    return [overview_row(name, it, True, overview_of(combinations)) for name, it in named]


def overview_html(combinations: Sequence[Comparison]) -> str:
    """A table with a row per comparison, for a notebook; empty without any."""
    if not combinations:
        return ""
    overview, rows = overview_of(combinations), overview_rows(combinations)
    lines = [_html_row("th", overview.headings), *(_html_row("td", row) for row in rows)]
    shared = escape(visible(shared_text(combinations)))
    return f"<p><b>{shared}</b></p><table>{''.join(lines)}</table><p>{escape(overview.reading)}</p>"


def _html_row(tag: str, texts: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(visible(text))}</{tag}>' for text in texts)}</tr>"
