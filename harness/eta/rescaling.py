"""Whether a reward is another one times a number plus a number, from what both paid for the same steps.

Such rewards differ in their scale, and tell a learner the same about which step is better, with two exceptions: with a
factor below 0 the better step of one is the worse step of the other; and where episodes can end before their time, an
offset pays for living longer, or for ending sooner.

Both columns have to lie on one line, in every step, up to rounding: that of single precision, because most observations
are in it, from which a reward may be computed again. Steps may come in several recordings: of each it is enough to keep
two steps of its line, see `PayLine`.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from harness.arrays import Float
from harness.files.plain import Plain

ROUNDINGS = 8.0
"""So many units in the last place a payment may be off the line: a reward takes a few operations. In single precision
these are a millionth."""
FEW = 100
"""Up to so many different payments are counted."""
TWO = 2
"""Fewer steps say nothing."""
SHORT = 2.0**16
"""A number whose binary digits are no more than 16 is exact in every precision, as 10, -1 or 0.5."""

Payment: TypeAlias = tuple[float, float]
"""What both rewards paid for one step."""


@dataclass(frozen=True)
class PayLine(Plain):
    """The line on which all steps of one recording lie.

    Attributes:
        near: The step for which the first reward paid least, positive or negative.
        far: The step for which it paid something most different from that.
        precision: Of the numbers: the spacing of floating-point numbers at 1.
        steps: How many steps lie on it.
        payments: The different numbers that the first reward paid, the smallest `FEW` + 1 of them.
        can_end: Whether an episode ended before its time, terminated.
    """

    near: Payment
    far: Payment
    precision: float
    steps: int
    payments: frozenset[float]
    can_end: bool = False


@dataclass(frozen=True)
class Rescaling(Plain):
    """A reward that is ``factor`` x another one + ``offset``.

    Attributes:
        factor: Never 0.
        offset: 0 where it is nothing but rounding.
        steps: In how many steps, all that both rewards are known in.
        payments: How many different numbers the other one paid for them; None: more than `FEW`. Over 2 numbers any
            reward that is a function of the other one is a line. Over 1 the offset is taken for 0.
        can_end: Whether episodes can end before their time, terminated.
    """

    factor: float
    offset: float
    steps: int
    payments: int | None
    can_end: bool = field(default=False, compare=False)

    @property
    def is_ruler(self) -> bool:
        """Whether it is nothing but another scale: both rewards tell a learner the same of which step is better."""
        return self.factor > 0.0 and (self.offset == 0.0 or not self.can_end)

    def sentence(self, reward: str, other: str) -> str:
        """What `reward` is, how that was found, and whether it is more than another scale."""
        count = f"more than {FEW}" if self.payments is None else self.payments
        numbers = "one number alone" if self.payments == 1 else f"{count} different numbers"
        told = [f"{reward} {self.formula(other)}, in all {self.steps:,} steps, for which {other} paid {numbers}"]
        if self.factor < 0.0:
            told.append(f"It is the opposite reward: it pays less where {other} pays more")
        if self.offset != 0.0 and self.can_end:
            what = "living longer" if self.offset > 0.0 else "ending sooner"
            told.append(f"Episodes can end before their time, so that the offset is no mere ruler: it pays for {what}")
        return ". ".join(told)

    def formula(self, other: str) -> str:
        """What it is, to follow on its name: ``is 2 x other - 1``."""
        if self.offset == 0.0 and _digits(self.factor) == "1":
            return f"pays the same as {other}"
        scaled = other if _digits(self.factor) == "1" else f"{_digits(self.factor)} x {other}"
        if self.offset == 0.0:
            return f"is {scaled}"
        return f"is {scaled} {'-' if self.offset < 0.0 else '+'} {_digits(abs(self.offset))}"


def line_of(one: Float, other: Float, *, can_end: bool = False) -> PayLine | None:
    """The line on which what `other` paid lies over what `one` paid; None where there is none.

    Args:
        one: What a reward paid for each step, (steps,); steps in which either is NaN do not count.
        other: The same of another reward.
        can_end: Whether an episode among them ended before its time, terminated.
    """
    known = np.isfinite(one) & np.isfinite(other)
    one, other = one[known], other[known]
    if not len(one):
        return None
    near = int(np.argmin(np.abs(one)))
    far = int(np.argmax(np.abs(one - one[near])))
    ends = _payment(one, other, near), _payment(one, other, far)
    precision = _precision(one, other)
    if not _is_on_line(one, other, *ends, precision):
        return None
    return PayLine(*ends, precision, len(one), frozenset(np.unique(one)[: FEW + 1].tolist()), can_end)


def rescaling_of(lines: Sequence[PayLine | None]) -> Rescaling | None:
    """What the lines of several recordings say together; None if they are not one line, or one reward alone changes.

    Where neither ever changes, as an alive bonus, one is taken for the other one times a number.
    """
    known = [line for line in lines if line is not None]
    if not known or len(known) < len(lines):
        return None
    near = min((line.near for line in known), key=lambda payment: abs(payment[0]))
    far = max((end for line in known for end in (line.near, line.far)), key=lambda payment: abs(payment[0] - near[0]))
    can_end, steps = any(line.can_end for line in known), sum(line.steps for line in known)
    if far[0] == near[0]:
        return _of_constants({line.near for line in known}, steps, can_end)
    if far[1] == near[1]:
        return None
    precision = max(line.precision for line in known)
    one, other = np.array([end for line in known for end in (line.near, line.far)]).T
    if not _is_on_line(one, other, near, far, precision):
        return None
    factor = (far[1] - near[1]) / (far[0] - near[0])
    offset = near[1] - factor * near[0]
    if abs(offset) <= ROUNDINGS * precision * (abs(near[1]) + abs(factor * near[0])):
        offset = 0.0
    payments = len(frozenset[float]().union(*(line.payments for line in known)))
    return Rescaling(factor, offset, steps, payments if payments <= FEW else None, can_end)


def _of_constants(paid: Set[Payment], steps: int, can_end: bool) -> Rescaling | None:
    """The same where the first reward always paid one number; None if the other one did not, or one alone is 0."""
    (one, other), *others = paid
    if others or steps < TWO or (one == 0.0) != (other == 0.0):
        return None
    return Rescaling(1.0 if one == 0.0 else other / one, 0.0, steps, 1, can_end)


def _is_on_line(one: Float, other: Float, near: Payment, far: Payment, precision: float) -> bool:
    """Whether all steps lie on the line through two of them; where the first never changes, whether neither does."""
    if far[0] == near[0]:
        return bool((other == near[1]).all())
    factor = (far[1] - near[1]) / (far[0] - near[0])
    offset = near[1] - factor * near[0]
    off = np.abs(other - (factor * one + offset))
    return bool((off <= ROUNDINGS * precision * (np.abs(other) + np.abs(factor * one) + abs(offset))).all())


def rounded(values: Float) -> Float:
    """Sums in another order differ in the last digits: such numbers are made equal."""
    unit = 1e-9 * float(np.abs(values).max(initial=0.0))
    made: Float = np.round(values / unit) if unit else np.asarray(values, np.float64)
    return made


def _payment(one: Float, other: Float, step: int) -> Payment:
    return float(one[step]), float(other[step])


def _precision(one: Float, other: Float) -> float:
    """The spacing of numbers at 1 in the precision that explains what is off the line.

    Where one of the two paid short numbers alone, which are exact, only the rounding of the other one can.
    """
    inexact = [values for values in (one, other) if not _are_short(values)]
    is_single = bool(inexact) and (len(inexact) == 2 or _are_single(inexact[0]))
    return float(np.finfo(np.float32 if is_single else np.float64).eps)


def _are_short(values: Float) -> bool:
    mantissas, _ = np.frexp(values)
    return bool((np.rint(SHORT * mantissas) == SHORT * mantissas).all())


def _are_single(values: Float) -> bool:
    with np.errstate(over="ignore"):  # of a number that single precision has not
        return bool((values.astype(np.float32) == values).all())


def _digits(value: float) -> str:
    return f"{value:.6g}"
