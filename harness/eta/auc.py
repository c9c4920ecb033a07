"""The chance that a success is paid more than a failure, with an interval and an answer.

The chance is the area under the ROC curve, AUC: the share of all pairs of a success and a failure in which the success
is paid more; pairs that are paid the same count half. Episodes of one operator resemble one another, so that the
interval is over operators, called clusters here: without any, each episode is its own.

The interval is of Newcombe's kind (2006, method 5): all chances that the data do not speak against, with the standard
error that each of them would have. That error is a model's. Where the data show a larger one, by the sum of what each
cluster adds to the AUC (DeLong 1988, Obuchowski 1997), it takes the model's place. Of clusters the interval reaches so
many standard errors as Student's t with the degrees of freedom of Satterthwaite. The table in
``docs/statistics-tables.md`` shows how often it holds the truth.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.eta.interval import CONFIDENCE, Interval, quantile

RanksAs: TypeAlias = Literal["RANKS AS SUCCESS DOES", "RANKS AGAINST IT", "CANNOT TELL"]
RANKS, AGAINST, CANNOT_TELL = get_args(RanksAs)

LEAST = 3
"""The fewest episodes of each kind, and the fewest clusters that have some, with an interval and an answer."""
DECIDING = 0.98
"""The answer rests on the interval of this confidence: by simulation it then errs in less than 5 of 100 data sets."""
CHANCE = 0.5
GRID = 4001
"""So many chances are tried for the ends of an interval."""


@dataclass(frozen=True)
class Auc:
    """How a reward ranks episodes of two kinds.

    Attributes:
        value: The chance that one of the first kind is paid more, in [0, 1]; None without an episode of each kind.
        low: The lower end of its 95 % interval; None where there is none.
        high: The upper end.
        answer: What can be said of it.
        reason: Why there is no interval; empty if there is one.
        above: Episodes of the first kind.
        below: Of the second kind.
        clusters: Over which the interval is.
    """

    value: float | None
    low: float | None
    high: float | None
    answer: RanksAs
    reason: str
    above: int
    below: int
    clusters: int

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def auc_of(paid: Float, above: Mask, clusters: Sequence[str] | NDArray[Any] | None = None) -> Auc:
    """How a reward ranks episodes.

    Args:
        paid: What it pays each episode, (episodes,), finite.
        above: Which episodes should be paid more, (episodes,).
        clusters: Who, or what, made each; None where each stands alone.
    """
    group = np.arange(len(paid)) if clusters is None else np.unique(np.asarray(clusters), return_inverse=True)[1]
    m, n, count = int(above.sum()), int((~above).sum()), len(np.unique(group))
    if not (m and n):
        return Auc(None, None, None, CANNOT_TELL, "there are no episodes of both kinds", m, n, count)
    placed = _places(rounded(paid), above)
    value = float(placed[above].mean())
    of_above, of_below = (len(np.unique(group[kind])) for kind in (above, ~above))
    if min(of_above, of_below) < LEAST:
        noun = "episodes" if count == len(paid) else "operators or files"
        reason = f"no interval below {LEAST} {noun} of each kind"
        return Auc(value, None, None, CANNOT_TELL, reason, m, n, count)
    spread = _spread(placed - value, above, group)
    scale = _scale(spread, value, m, n, max(m / of_above, n / of_below))
    freedom = np.inf if count == len(paid) else spread.freedom
    low, high = _ends(value, m, n, scale, quantile(CONFIDENCE, freedom))
    surely_low, surely_high = _ends(value, m, n, scale, quantile(DECIDING, freedom))
    answer = RANKS if surely_low > CHANCE else AGAINST if surely_high < CHANCE else CANNOT_TELL
    return Auc(value, low, high, answer, "", m, n, count)


def rounded(values: Float) -> Float:
    """Sums in another order differ in the last digits: such numbers are made equal."""
    unit = 1e-9 * float(np.abs(values).max(initial=0.0))
    made: Float = np.round(values / unit) if unit else np.asarray(values, np.float64)
    return made


def _places(paid: Float, above: Mask) -> Float:
    """The share of the other kind that each episode is on the right side of, (episodes,).

    The mean over the episodes of either kind is the AUC.
    """
    x, y = np.sort(paid[above]), np.sort(paid[~above])
    placed = np.empty(len(paid))
    for kind, others in ((above, y), (~above, x)):
        values = paid[kind]
        left, right = (np.searchsorted(others, values, side=side) for side in ("left", "right"))
        placed[kind] = (left + right) / (2.0 * len(others))
    placed[~above] = 1.0 - placed[~above]
    return placed


class _Spread(NamedTuple):
    """How far the AUC of such data is from what it is drawn around."""

    variance: float
    freedom: float


def _spread(apart: Float, above: Mask, group: NDArray[np.int64]) -> _Spread:
    """From how far the place of each episode is from the AUC, which is the mean of either kind's, (episodes,)."""
    count = int(group.max()) + 1
    first = np.bincount(group[above], apart[above], count) / above.sum()
    other = np.bincount(group[~above], apart[~above], count) / (~above).sum()
    parts = []
    for sums, kind in ((first, above), (other, ~above)):
        clusters = len(np.unique(group[kind]))
        parts.append((float(sums @ sums) * clusters / (clusters - 1), clusters - 1))
    alone = sum(part for part, _ in parts)
    freedom = alone**2 / sum(part**2 / free for part, free in parts) if alone > 0.0 else 0.0
    least = min(free for _, free in parts)  # Satterthwaite's is never below it
    return _Spread(max(0.0, alone + 2.0 * float(first @ other)), float(max(least, freedom)))


def _model(chance: Float | float, m: int, n: int) -> Any:
    """The variance of an AUC whose true value is `chance`, for exponential pay (Hanley, McNeil 1982)."""
    size = (m + n) / 2.0 - 1.0
    return (
        chance * (1.0 - chance) * (1.0 + size * ((1.0 - chance) / (2.0 - chance) + chance / (1.0 + chance))) / (m * n)
    )


def _scale(spread: _Spread, value: float, m: int, n: int, size: float) -> float:
    """By what factor the data's variance is larger than the model's; 1 where it is smaller.

    Where all pairs are ranked the same, the data show no variance: then the episodes of one kind and cluster, `size` of
    them on average, count as one.
    """
    model = float(_model(value, m, n))
    return max(1.0, spread.variance / model) if model > 0.0 else size


def _ends(value: float, m: int, n: int, scale: float, reach: float) -> Interval:
    """The least and the largest chance that is not farther from the AUC than so many standard errors of its own."""
    tried = np.linspace(0.0, 1.0, GRID)
    held = np.abs(value - tried) <= np.maximum(reach * np.sqrt(scale * _model(tried, m, n)), 0.5 / (GRID - 1))
    ends = tried[held]
    return float(ends[0]), float(ends[-1])
