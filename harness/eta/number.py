"""The sentences about pay and the note's indices: how much each changed, and how much of that is rescaling alone."""

import math
from typing import TYPE_CHECKING

from harness.eta.index import NOTHING, Ratio
from harness.eta.scored_sums import BB, KK
from harness.eta.seed_mean import SeedMean
from harness.eta.splits import Names, Split, Splits

if TYPE_CHECKING:
    from harness.eta.return_split import ReturnSplit


def number_sentence(names: Names, splits: Splits) -> str:
    """A sentence on how much each index changed, and how much of that is ruler and behaviour."""
    told = [_ratio_sentence(name, name.replace("eta", "I"), names, split) for name, split in splits.items()]
    return " ".join([*told, *(f"{name}: {flag}." for name, split in splits.items() for flag in split.flags)])


def return_sentence(names: Names, split: "ReturnSplit") -> str:
    """The pay of an episode: its ratio if there is one, else its difference, and both parts, with their intervals."""
    proposed, baseline = (format_number(split.returns[pair].mean) for pair in (KK, BB))
    told = f"An episode is paid {proposed} with {names.proposed} and {baseline} with {names.baseline}: "
    if split.has_ratio:
        eta, ruler, behaviour = (_factor_text(it) for it in (split.ratio.eta, split.ratio.ruler, split.ratio.behaviour))
        told, sign, reason = f"{told}{eta} times as much", "x ", split.ratio.ruler.near_zero or split.ratio.ruler.note
    else:
        change, ruler, behaviour = (
            _mean_text(it) for it in (split.total.change, split.total.ruler, split.total.behaviour)
        )
        told, sign, reason = f"{told}a change of {change}", "", split.total.ruler.note
    if not ruler:
        return f"{told}. It cannot be split: {reason}."
    flags = "".join(f" The ratio: {flag}." for flag in split.ratio.flags) if split.has_ratio else ""
    return f"{told}. Rescaling alone (the ruler): {sign}{ruler}. Behaviour: {sign}{behaviour}.{flags}"


def _ratio_sentence(name: str, amount: str, names: Names, split: Split) -> str:
    """A sentence on a ratio, with its name, and on the amount that it is a ratio of."""
    eta = split.eta
    if eta.value is None:
        return f"{name} n/a: {eta.note}."
    if eta.near_zero is not None:
        return f"{name} says little: {eta.near_zero}."
    told = f"{amount} with {names.proposed} is {_text(eta)} times that with {names.baseline}"
    if split.ruler.value is None or split.ruler.near_zero is not None:
        return f"{told}; not split: {split.ruler.near_zero or split.ruler.note}."
    return (
        f"{told}: x {_text(split.ruler)} from counting the same runs differently (ruler), "
        f"x {_text(split.behaviour)} from different runs (behaviour)."
    )


def _text(ratio: Ratio) -> str:
    told = f"{ratio.value:.3g}"
    if ratio.low is None or ratio.high is None:
        return told
    return f"{told} [{ratio.low:.3g}, {ratio.high:.3g}]"


def _factor_text(ratio: Ratio) -> str:
    """A ratio and its interval; empty where it has no value, or says little."""
    if ratio.value is None or ratio.near_zero is not None:
        return ""
    ends = "" if ratio.low is None or ratio.high is None else _ends(ratio.low, ratio.high)
    return f"{format_number(ratio.value)}{ends}"


def _mean_text(mean: SeedMean) -> str:
    if mean.mean is None:
        return ""
    return signed(mean.mean) + ("" if mean.low is None or mean.high is None else _ends(mean.low, mean.high))


def _ends(low: float, high: float) -> str:
    return f" [{format_number(low)}, {format_number(high)}]"


def signed(value: float | None) -> str:
    """A difference, with its sign."""
    return f"{'+' if value and value > 0.0 else ''}{format_number(value)}"


def format_number(value: float | None) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if value is None:
        return NOTHING
    rounded = float(f"{value:.2e}") + 0.0  # no -0.0: an interval may end there
    size = math.floor(math.log10(abs(rounded))) if rounded else 0
    if not -4 <= size < 6:
        return f"{rounded:.2e}"
    return f"{rounded:,.{max(0, 2 - size)}f}"
