"""The pay in one line: how much more an episode is paid, and how much of that is rescaling alone."""

import math
from typing import NamedTuple

from harness.eta.number import format_number, signed
from harness.eta.return_split import ReturnSplit
from harness.eta.scored_sums import BB, KK
from harness.eta.splits import Split, SumSplit
from harness.report.rows.ratios import is_drawable
from harness.results.comparison import Comparison

ALL = 0.1
"""Where the behaviour's share of a change is smaller than this, the change is nearly all rescaling."""


class PayPart(NamedTuple):
    """A part of the change of pay."""

    name: str
    """``ruler`` or ``behaviour``."""
    text: str
    """Its value, such as ``× 1.54`` or ``+386``."""
    size: float
    """Its logarithm, or its value: what its bar shows. Sizes of one change add up to all of it."""


class PaySentence(NamedTuple):
    """How much an episode is paid under the proposed reward, beside the baseline."""

    told: str
    """In a sentence without its end."""
    parts: tuple[PayPart, ...]
    """The ruler and the behaviour; empty where they are not known."""
    why: str
    """Why there are no parts, in a sentence; empty where there are."""
    grows: bool | None = None
    """Whether an episode is paid more; None where the number is none of episodes."""

    @property
    def is_ruler(self) -> bool:
        """Whether the behaviour's part is so small that the change is nearly all ruler."""
        if not self.parts:
            return False
        ruler, behaviour = (part.size for part in self.parts)
        return abs(behaviour) < ALL * abs(ruler + behaviour)


def pay_of(comparison: Comparison) -> PaySentence | None:
    """The pay of an episode in the manner that decides: a ratio where there is one, else a difference.

    Of an experiment whose returns are not known it is the number that they have, an index of the summed reward; None
    where no number is known.
    """
    split = comparison.number.pay
    if split is not None:
        proposed, baseline = (format_number(split.returns[pair].mean) for pair in (KK, BB))
        sides = f"An episode is paid {proposed} instead of {baseline}"
        pay = _ratio(f"{sides}: {{}} times as much", split.ratio) or _difference(sides, split)
        change = split.total.change.mean
        return pay and pay._replace(grows=None if not change else change > 0.0)
    named = {"eta_P": "The note's I_P, what the trainings earned,", "eta_N": "The note's I_N, what they lost,"}
    splits = comparison.number.splits
    of_index = (_ratio(f"{told} is {{}} times as large", splits[name]) for name, told in named.items())
    return next((it for it in of_index if it is not None), None)


def _ratio(told: str, split: Split) -> PaySentence | None:
    eta = split.eta
    if not is_drawable(eta):
        return None
    told = told.format(format_number(eta.value))
    if not (is_drawable(split.ruler) and is_drawable(split.behaviour)):
        return _without_parts(told, split.ruler.near_zero or split.ruler.note)
    parts = (("ruler", split.ruler), ("behaviour", split.behaviour))
    return PaySentence(
        told,
        tuple(PayPart(name, f"× {format_number(it.value)}", math.log(it.value or 1.0)) for name, it in parts),
        "",
    )


def _difference(sides: str, split: ReturnSplit) -> PaySentence | None:
    total: SumSplit = split.total
    change = total.change.mean
    if change is None:
        return None
    told = f"{sides}: {format_number(abs(change))} {'more' if change >= 0.0 else 'less'}"
    if total.ruler.mean is None or total.behaviour.mean is None:
        return _without_parts(told, total.ruler.note)
    parts = (("ruler", total.ruler.mean), ("behaviour", total.behaviour.mean))
    return PaySentence(told, tuple(PayPart(name, signed(value), value) for name, value in parts), "")


def _without_parts(told: str, note: str) -> PaySentence:
    return PaySentence(told, (), f"How much of that is rescaling alone is not known: {note}.")
