"""The sentences about the number: how much it changed, and how much of that is only a change of ruler."""

from typing import TYPE_CHECKING

from harness.eta.index import Ratio
from harness.eta.seed_mean import SeedMean
from harness.eta.splits import Names, Split, Splits

if TYPE_CHECKING:
    from harness.eta.return_split import ReturnSplit


def number_sentence(names: Names, splits: Splits) -> str:
    """A sentence on how much each index changed, and how much of that is ruler and behaviour."""
    told = [_ratio_sentence(name, name.replace("eta", "I"), names, split) for name, split in splits.items()]
    return " ".join([*told, *(f"{name}: {flag}." for name, split in splits.items() for flag in split.flags)])


def return_sentence(names: Names, split: "ReturnSplit") -> str:
    """The same for the mean return of an episode: as a ratio if there is one, else as a difference."""
    eta = split.ratio.eta
    if eta.value is not None and eta.near_zero is None:
        told = _ratio_sentence("The ratio of mean returns", "The mean return", names, split.ratio)
        return " ".join([told, *(f"The ratio: {flag}." for flag in split.ratio.flags)])
    change, ruler, behaviour = (_mean_text(it) for it in (split.total.change, split.total.ruler, split.total.behaviour))
    told = f"The mean return with {names.proposed} minus that with {names.baseline} is {change}"
    if split.total.ruler.mean is None:
        return f"{told}; not split: {split.total.ruler.note}."
    return (
        f"{told}: {ruler} from counting the same runs differently (ruler), {behaviour} from different runs (behaviour)."
    )


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


def _mean_text(mean: SeedMean) -> str:
    if mean.mean is None:
        return "n/a"
    told = _digits(mean.mean, "+")
    return told if mean.low is None or mean.high is None else f"{told} [{_digits(mean.low)}, {_digits(mean.high)}]"


def _digits(value: float, sign: str = "") -> str:
    """A number with three digits, without an exponent up to a million."""
    return f"{float(f'{value:.3g}'):{sign},.6g}"
