"""The chance that a success is paid more than a failure, with an interval and an answer.

The chance is the area under the ROC curve, AUC: the share of all pairs of a success and a failure in which the success
is paid more; pairs that are paid the same count half. Episodes of one operator resemble one another, so that the
interval is over operators, called clusters here: without any, each episode is its own.

The interval is of Newcombe's kind (2006, method 5): all chances that the data do not speak against, with the standard
error that each of them would have. That error is a model's. Where the data show a larger one, by the sum of what each
cluster adds to the AUC (DeLong 1988, Obuchowski 1997), it takes the model's place. Of clusters the interval reaches so
many standard errors as Student's t with the degrees of freedom of Satterthwaite. The table in
``docs/statistics-tables.md`` shows how often it holds the truth.

Episodes of different tasks are not compared. Each task has an AUC of its own, and all of them have the mean of these,
each as often as it has pairs: the share of all pairs within a task. Its variance is the sum over the tasks, each with
the square of its weight; what a cluster adds to several tasks is added up before it is squared.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Ints, Mask
from harness.eta.index import Estimate
from harness.eta.interval import CONFIDENCE, LEAST_SEEDS, SHARE, Interval, quantile
from harness.eta.rescaling import rounded
from harness.files.plain import Plain

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
class Auc(Plain):
    """How a reward ranks episodes of two kinds.

    Attributes:
        value: The chance that one of the first kind is paid more, in [0, 1]; None without an episode of each kind.
        low: The lower end of its 95 % interval; None where there is none.
        high: The upper end.
        answer: What can be said of it.
        reason: Why there is no interval, or why nothing is said in spite of one; else empty.
        above: Episodes of the first kind.
        below: Of the second kind.
        clusters: Over which the interval is.
        pairs: Of an episode of the first kind and one of the second, of one task.
        tasks: How many have such pairs.
    """

    value: float | None
    low: float | None
    high: float | None
    answer: RanksAs
    reason: str
    above: int
    below: int
    clusters: int
    pairs: int = 0
    tasks: int = 0


class _Task(NamedTuple):
    """Episodes that are compared with one another.

    Attributes:
        weight: Its share of all pairs.
        rows: Numbers of its episodes.
        above: Which of them are of the first kind.
        apart: How far the place of each is from the AUC of the task, which is the mean of either kind's.
        value: The AUC of the task.
    """

    weight: float
    rows: Ints
    above: Mask
    apart: Float
    value: float

    @property
    def counts(self) -> tuple[int, int]:
        """Episodes of either kind."""
        return int(self.above.sum()), int((~self.above).sum())


def auc_of(
    paid: Float,
    above: Mask,
    clusters: Sequence[str] | NDArray[Any] | None = None,
    tasks: Sequence[str] | NDArray[Any] | None = None,
) -> Auc:
    """How a reward ranks episodes.

    Args:
        paid: What it pays each episode, (episodes,), finite.
        above: Which episodes should be paid more, (episodes,).
        clusters: Who, or what, made each; None where each stands alone.
        tasks: What each does; only episodes of one task are compared. None where all do the same.
    """
    group = np.arange(len(paid)) if clusters is None else np.unique(np.asarray(clusters), return_inverse=True)[1]
    m, n, count = int(above.sum()), int((~above).sum()), len(np.unique(group))
    if not (m and n):
        return Auc(None, None, None, CANNOT_TELL, "there are no episodes of both kinds", m, n, count)
    members = _tasks(rounded(paid), above, tasks)
    if not members:
        return Auc(None, None, None, CANNOT_TELL, "no task has episodes of both kinds", m, n, count)
    value = min(1.0, sum(task.weight * task.value for task in members))
    pairs = sum(int(np.prod(task.counts)) for task in members)
    compared, kind = (np.concatenate(it) for it in zip(*((task.rows, task.above) for task in members), strict=True))
    of_above, of_below = (len(np.unique(group[compared[it]])) for it in (kind, ~kind))
    if min(of_above, of_below) < LEAST:
        noun = "episodes" if count == len(paid) else "groups of episodes, such as one training's or one operator's,"
        reason = f"no interval below {LEAST} {noun} of each kind"
        return Auc(value, None, None, CANNOT_TELL, reason, m, n, count, pairs, len(members))
    spread = _spread(members, value, group)
    model = _model_of(members)
    scale = _scale(spread, float(model(value)), max(kind.sum() / of_above, (~kind).sum() / of_below))
    freedom = np.inf if count == len(paid) else spread.freedom
    low, high = _ends(value, model, scale, quantile(CONFIDENCE, freedom))
    surely_low, surely_high = _ends(value, model, scale, quantile(DECIDING, freedom))
    answer = RANKS if surely_low > CHANCE else AGAINST if surely_high < CHANCE else CANNOT_TELL
    return Auc(value, low, high, answer, "", m, n, count, pairs, len(members))


def _tasks(paid: Float, above: Mask, tasks: Sequence[str] | NDArray[Any] | None) -> list[_Task]:
    """Those that have episodes of both kinds."""
    task = np.zeros(len(paid), int) if tasks is None else np.unique(np.asarray(tasks), return_inverse=True)[1]
    order = np.argsort(task, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(task[order])) + 1)
    both = [rows for rows in parts if 0 < above[rows].sum() < len(rows)]
    pairs = [int(above[rows].sum() * (~above[rows]).sum()) for rows in both]
    members = []
    for rows, count in zip(both, pairs, strict=True):
        placed = _places(paid[rows], above[rows])
        below = int((~above[rows]).sum())
        halves = np.rint(2.0 * below * placed[above[rows]]).sum()  # whole numbers: the same in every order
        value = float(halves) / (2.0 * count)
        members.append(_Task(count / sum(pairs), rows, above[rows], placed - value, value))
    return members


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


def _spread(members: Sequence[_Task], value: float, group: Ints) -> _Spread:
    """From what each cluster adds to the AUC, by task and kind.

    Where all episodes of a task and kind are of one cluster, they show no variance. The model's of one episode takes
    its place.
    """
    together = np.zeros((2, int(group.max()) + 1))
    there = np.zeros(together.shape, bool)
    parts: list[_Part] = []
    squares = 0.0
    for task in members:
        for place, kind in enumerate((task.above, ~task.above)):
            of_kind, inverse = np.unique(group[task.rows[kind]], return_inverse=True)
            sums = task.weight * np.bincount(inverse, task.apart[kind]) / kind.sum()
            together[place, of_kind] += sums
            there[place, of_kind] = True
            squares += float(sums @ sums)
            if len(of_kind) > 1:
                parts.append(_part(sums))
            elif len(members) > 1:
                parts.append(_Part(task.weight**2 * _of_one(value)[place], 1))
    both = together.sum(axis=0)
    across = float(both @ both) - squares
    # Clusters that act in several tasks are not there several times.
    freedom = min(_freedom(parts), _freedom([_part(sums[it]) for sums, it in zip(together, there, strict=True)]))
    return _Spread(max(0.0, sum(part.variance for part in parts) + across), freedom)


class _Part(NamedTuple):
    """What clusters of one kind add to a variance."""

    variance: float
    freedom: int


def _part(sums: Float) -> _Part:
    """From what each of at least two clusters adds to the AUC."""
    return _Part(float(sums @ sums) * len(sums) / (len(sums) - 1), len(sums) - 1)


def _freedom(parts: Sequence[_Part]) -> float:
    """The degrees of freedom of a sum of variances (Satterthwaite), which are never below those of a part."""
    alone = sum(part.variance for part in parts)
    freedom = alone**2 / sum(part.variance**2 / part.freedom for part in parts) if alone > 0.0 else 0.0
    return float(max(min(part.freedom for part in parts), freedom))


def _of_one(chance: float) -> tuple[float, float]:
    """The variance of the place of one episode of either kind, for exponential pay (Hanley, McNeil 1982)."""
    return chance / (2.0 - chance) - chance**2, 2.0 * chance**2 / (1.0 + chance) - chance**2


def _model(chance: Float | float, m: int, n: int) -> Any:
    """The variance of an AUC whose true value is `chance`, for exponential pay (Hanley, McNeil 1982)."""
    size = (m + n) / 2.0 - 1.0
    return (
        chance * (1.0 - chance) * (1.0 + size * ((1.0 - chance) / (2.0 - chance) + chance / (1.0 + chance))) / (m * n)
    )


def _model_of(members: Sequence[_Task]) -> Callable[[Float | float], Any]:
    """The same of the mean over tasks, by the chance that all of them have."""
    weights: dict[tuple[int, int], float] = {}
    for task in members:
        weights[task.counts] = weights.get(task.counts, 0.0) + task.weight**2
    return lambda chance: sum(weight * _model(chance, *counts) for counts, weight in weights.items())


def _scale(spread: _Spread, model: float, size: float) -> float:
    """By what factor the data's variance is larger than the model's; 1 where it is smaller.

    Where all pairs are ranked the same, the data show no variance: then the episodes of one kind and cluster, `size` of
    them on average, count as one.
    """
    return max(1.0, spread.variance / model) if model > 0.0 else size


def _ends(value: float, model: Callable[[Float | float], Any], scale: float, reach: float) -> Interval:
    """The least and the largest chance that is not farther from the AUC than so many standard errors of its own."""
    tried = np.linspace(0.0, 1.0, GRID)
    held = np.abs(value - tried) <= np.maximum(reach * np.sqrt(scale * model(tried)), 0.5 / (GRID - 1))
    ends = tried[held]
    return float(ends[0]), float(ends[-1])


def share_of(part: Float, whole: Float, clusters: Ints) -> Estimate:
    """How large the sum of `part` is in that of `whole`.

    Args:
        part: By episode, (episodes,), never above `whole`.
        whole: Likewise, never negative.
        clusters: Number of the cluster of each episode, from 0.
    """
    count, total = int(clusters.max(initial=-1)) + 1, float(whole.sum())
    if total <= 0.0:
        return Estimate(None, None, None, count)
    share = float(part.sum()) / total
    if count < LEAST_SEEDS:
        return Estimate(share, None, None, count)
    apart = np.bincount(clusters, part - share * whole, count) / total
    reach = quantile(CONFIDENCE, count - 1) * float(np.sqrt(apart @ apart * count / (count - 1)))
    return Estimate(share, max(SHARE[0], share - reach), min(SHARE[1], share + reach), count)
