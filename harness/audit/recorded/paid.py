"""What several rewards paid for the same steps or episodes, and how far apart two of them are in that."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.audit.distance import centred_unit, distance_between
from harness.log import Log
from harness.log.log import BEHAVIOUR, REWARD
from harness.results.recordings.episodes import Episodes

NOT_KNOWN = "not a number in some rows"


@dataclass(frozen=True, eq=False)
class Paid:
    """What rewards paid for one set of recorded steps.

    Attributes:
        steps: By reward, what it pays for each step, (steps,), finite; only rewards that are known in every step.
        returns: By reward, its sum over each finished episode, (episodes,).
        unknown: By reward that is not known in every step: why.
    """

    steps: Mapping[str, Float]
    returns: Mapping[str, Float]
    unknown: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class Acted:
    """What one training, one evaluation of a policy, or random actions left.

    Attributes:
        name: Where it lies, in words.
        steps: How many rows there are.
        episodes: Those that ended.
        log: Reads its rows.
        taught: The reward that taught; of a log that does not say it, what else tells it from others.
        evaluation: Whether a finished policy acted.
        manner: How it chose actions, ``deterministic``; may be empty.
        seed: Of the training; None if nobody says it.
    """

    name: str
    steps: int
    episodes: Episodes
    log: Callable[[], Log]
    taught: str = ""
    evaluation: bool = False
    manner: str = ""
    seed: int | None = None

    @property
    def training(self) -> tuple[str, int | str]:
        """The training that was recorded, or evaluated: by its reward and its seed, as far as that is told."""
        return self.taught, self.name if self.seed is None else self.seed


def acted_in(name: str, log: Log, taught: str = "", evaluation: bool = False) -> Acted:
    """What is in a log."""
    return Acted(name, len(log), episodes_in(log), lambda: log, taught, evaluation)


def paid_in(log: Log, episodes: Episodes) -> Paid:
    """What the rewards of a log paid, in its steps and in its finished episodes; of a log of episodes, in these alone.

    Args:
        log: Of steps, of episodes, or of points, which are taken for episodes.
        episodes: Its episodes, see `episodes_in`.
    """
    failed = {it.column: it.reason for it in log.facts.failed}
    told, unknown = episodes.part(0, len(log)).reasons, {}
    pays = {name: log[f"{REWARD}{name}"] for name in log.rewards}
    for name, paid in pays.items():
        if np.isnan(paid).any() or np.isnan(episodes.returns[name]).any():
            column = f"{REWARD}{name}"
            unknown[name] = episodes.reasons.get(column) or failed.get(column) or told.get(name, NOT_KNOWN)
    known = [name for name in pays if name not in unknown]
    steps = steps_of(log) if log.facts.unit == "step" else None
    of_steps = {} if steps is None else {name: np.asarray(pays[name], np.float64)[steps] for name in known}
    return Paid(of_steps, {name: episodes.returns[name] for name in known}, unknown)


def episodes_in(log: Log) -> Episodes:
    """The finished episodes of a log, in the order in which they ended; `last` counts rows.

    Of a log of episodes or points every row is one.
    """
    pays: dict[str, Float] = {name: np.asarray(log[f"{REWARD}{name}"], np.float64) for name in log.rewards}
    measures: dict[str, Float] = {name: np.asarray(log[f"{BEHAVIOUR}{name}"], np.float64) for name in log.measures}
    if log.facts.unit != "step":
        return Episodes(np.arange(len(log)), pays, measures, {})
    steps, numbers = steps_of(log), np.unique(episode_numbers(log), return_inverse=True)[1]
    ended = np.flatnonzero(_ends(log) & steps)
    sums = {name: np.bincount(numbers, np.where(steps, paid, 0.0)) for name, paid in pays.items()}
    returns = {name: np.asarray(of[numbers[ended]], np.float64) for name, of in sums.items()}
    return Episodes(ended, returns, {name: values[ended] for name, values in measures.items()}, {})


def episode_numbers(log: Log) -> NDArray[np.int64]:
    """A number for each row, the same in all rows of one episode, (rows,)."""
    env, episode = (
        np.asarray(log[name], np.int64) if name in log else np.zeros(len(log), np.int64) for name in ("env", "episode")
    )
    return env * (int(episode.max(initial=0)) + 1) + episode


def steps_of(log: Log) -> Mask:
    """Which rows are steps, and no starts of episodes, (rows,)."""
    return ~np.asarray(log["start"], bool) if "start" in log else np.ones(len(log), bool)


def _ends(log: Log) -> Mask:
    """Which rows end an episode. Where no column tells it, the last episode of each env may still go on."""
    flags: list[Mask] = [np.asarray(log[name], bool) for name in ("terminated", "truncated") if name in log]
    numbers = episode_numbers(log)
    ends: Mask = np.zeros(len(log), bool)
    if flags:
        ends |= flags[0] | flags[-1]
        return ends
    known, from_end = np.unique(numbers[::-1], return_index=True)
    env = np.asarray(log["env"])[len(log) - 1 - from_end] if "env" in log else np.zeros(len(known))
    ends[(len(log) - 1 - from_end)[:-1][np.diff(env) == 0]] = True
    return ends


@dataclass(frozen=True)
class Apart:
    """How far apart two rewards are in one set of recorded steps. Scale and offset of a reward do not matter.

    Attributes:
        steps: Pearson distance of what they pay for each step, sqrt((1 - rho) / 2), in [0, 1]; None where one of them,
            and not the other, pays every step the same.
        returns: The same of the returns of finished episodes; None also below two of them.
        discordant: Share of the pairs of episodes that the two put in opposite orders, of those that both tell apart.
        told_apart: Share of all pairs of episodes that both tell apart; None below two episodes.
    """

    steps: float | None
    returns: float | None
    discordant: float | None
    told_apart: float | None


def compare_paid(paid: Paid, one: str, other: str) -> Apart:
    """How far apart two rewards are, both known in `paid`."""
    return Apart(
        _pearson(paid.steps, one, other), _pearson(paid.returns, one, other), *_order(paid.returns, one, other)
    )


def pairs_of(names: tuple[str, ...]) -> list[tuple[str, str]]:
    """Every two of them once."""
    return list(combinations(names, 2))


def _pearson(values: Mapping[str, Float], one: str, other: str) -> float | None:
    if one not in values or len(values[one]) < 2:
        return None
    first, second = (centred_unit(values[name], float(np.abs(values[name]).max())) for name in (one, other))
    return distance_between(first, second)


def _order(returns: Mapping[str, Float], one: str, other: str) -> tuple[float | None, float | None]:
    """The shares of `Apart`. From Kendall's tau-b, which scipy finds without looking at all pairs."""
    from scipy.stats import kendalltau

    count = len(returns[one])
    pairs = count * (count - 1) // 2
    if not pairs:
        return None, None
    # Sums in another order differ in the last digits: such returns are equal.
    first, second = (_rounded(returns[name]) for name in (one, other))
    ties_one, ties_other = _ties(first), _ties(second)
    apart = pairs - ties_one - ties_other + _ties(np.stack([first, second], axis=1))
    if not apart:
        return None, 0.0
    tau = float(kendalltau(first, second).statistic)
    surplus = round(tau * float(np.sqrt(pairs - ties_one) * np.sqrt(pairs - ties_other)))
    return (apart - surplus) / 2 / apart, apart / pairs


def _rounded(values: Float) -> Float:
    unit = 1e-9 * float(np.abs(values).max())
    rounded: Float = np.round(values / unit) if unit else values
    return rounded


def _ties(values: Float) -> int:
    """How many pairs of rows are equal."""
    _, counts = np.unique(values, axis=0, return_counts=True)
    return int((counts.astype(np.int64) * (counts - 1) // 2).sum())
