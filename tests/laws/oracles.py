"""Synthetic experiments of which it is known whether their two rewards differ, kept as other programs keep them."""

import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.laws.said import INTERIM, REFUSED, Said, answered
from tests.laws.writers import chart, evaluations, events, monitor, progress

TOTAL, SEEDS = 100_000, 6
"""Steps of a training, and trainings of each reward."""
WINDOW = 100
"""Episodes that a point of stable-baselines3 averages."""
KINDS = {"learned": 300, "learning": 300, "+6": 150, "+12": 150, "exact": 100, "twice": 60}
"""How many experiments there are of each kind."""
FIRST = 10_000
"""Of the seeds: from here on, an exact test of what trainings really are finds 15 of 300 of equal rewards to differ."""
SILENT = (REFUSED, INTERIM, "cannot tell")
"""Words that claim nothing."""


@dataclass(frozen=True)
class Way:
    """How the trainings of one reward are logged.

    Attributes:
        points: At so many steps.
        shift: So much of the distance of two points later.
        jitter: Each point stands so much of that distance off.
        kept: The share of the points that are kept.
    """

    points: int
    shift: float = 0.0
    jitter: float = 0.0
    kept: float = 1.0

    def steps(self, rng, until):
        """After which steps points stand, rising."""
        apart = TOTAL / self.points
        at = apart * (np.arange(1, self.points + 1) + self.shift + self.jitter * rng.uniform(-0.5, 0.5, self.points))
        is_kept = rng.random(self.points) < self.kept
        is_kept[-1] = True
        return np.unique(np.round(at[is_kept & (at <= until + apart / 2)]).astype(int))


@dataclass(frozen=True)
class Oracle:
    """An experiment of two rewards.

    Attributes:
        final: Success of the baseline at the end.
        better: By how much that of the proposed reward is higher.
        learned: The share of the training after which nothing more is learned; above 1 while it is still learning.
        spread: The standard deviation of trainings.
        noise: That of a point.
        length: Steps of an episode.
        door: The program that logs.
        ways: How the baseline is logged, and how the proposed reward is.
        stopped: Trainings of the proposed reward that stopped halfway.
        seed: Of all that is drawn.
    """

    final: float
    better: float
    learned: float
    spread: float
    noise: float
    length: int
    door: str
    ways: tuple[Way, Way]
    stopped: int
    seed: int

    def trainings(self):
        """By reward and seed: the law of success by step, its way, after how many steps it stopped, and what draws."""
        rng = np.random.default_rng(self.seed)
        spread = self.spread * rng.normal(size=(2, SEEDS))
        for reward, way, more, off in zip(("base", "prop"), self.ways, (0.0, self.better), spread, strict=True):
            for seed in range(SEEDS):
                final = self.final + more + (off if self.noise or self.better else spread[0])[seed]
                until = TOTAL // 2 if reward == "prop" and seed < self.stopped else TOTAL
                yield (
                    reward,
                    seed,
                    _Law(min(final, 1.0), self.learned),
                    way,
                    until,
                    np.random.default_rng(rng.integers(2**32)),
                )


@dataclass(frozen=True)
class _Law:
    """Success rises on a line."""

    final: float
    learned: float

    def at(self, steps):
        """Success of an episode."""
        return np.clip(self.final * np.minimum(np.asarray(steps) / TOTAL / self.learned, 1.0), 0.0, 1.0)

    def before(self, steps, length):
        """The mean of the last 100 episodes that ended by then."""
        of = self.at(length * np.arange(1, TOTAL // length + 2))
        known = np.concatenate([[0.0], np.cumsum(of)])
        ended = np.minimum(np.asarray(steps) // length, len(of))
        first = np.maximum(ended - WINDOW, 0)
        return (known[ended] - known[first]) / (ended - first)


def _point(oracle, law, way, until, rng):
    """Steps and values of a curve."""
    steps = way.steps(rng, until)
    steps = steps[steps >= oracle.length]
    return steps, np.clip(law.before(steps, oracle.length) + rng.normal(0, oracle.noise, len(steps)), 0, 1)


def _progress(folder, oracle):
    for reward, seed, *drawn in oracle.trainings():
        steps, values = _point(oracle, *drawn)
        more = {"rollout/ep_len_mean": np.full(len(steps), oracle.length)} if oracle.seed % 2 else {}
        progress(folder / f"{reward}_{seed}" / "progress.csv", steps, values, **more)


def _events(folder, oracle):
    for reward, seed, *drawn in oracle.trainings():
        events(folder / f"{reward}_{seed}", *_point(oracle, *drawn))


def _chart(folder, oracle):
    runs = {f"{reward}_{seed}": _point(oracle, *drawn) for reward, seed, *drawn in oracle.trainings()}
    chart(folder / "export.csv", "global_step", runs)


def _evaluations(folder, oracle):
    for reward, seed, law, way, until, rng in oracle.trainings():
        steps = way.steps(rng, until)
        success = rng.random((len(steps), 20)) < law.at(steps)[:, None]
        evaluations(folder / reward / str(seed) / "evaluations.npz", steps, success)


def _monitor(folder, oracle):
    for number, (reward, seed, law, _, until, rng) in enumerate(oracle.trainings()):
        count = until // oracle.length
        lengths = rng.integers(oracle.length - 5, oracle.length + 6, count)
        success = rng.random(count) < law.at(np.cumsum(lengths))
        monitor(
            folder / reward / f"{seed}.monitor.csv", -lengths + 20.0 * success, lengths, success, 1.7e9 + 1e5 * number
        )


CURVES: Mapping[str, Callable[[Path, Oracle], None]] = {"progress": _progress, "events": _events, "chart": _chart}
DOORS = {**CURVES, "evaluations": _evaluations, "monitor": _monitor}


def drawn(kind, number):
    """An experiment of a kind of `KINDS`."""
    rng = np.random.default_rng([number, *map(ord, kind)])
    is_exact = kind in ("exact", "twice")
    ways = [
        Way(
            int(np.exp(rng.uniform(np.log(5), np.log(80)))),
            rng.choice([0.0, 0.0, rng.uniform(-0.5, 0.5)]),
            rng.choice([0.0, 0.5]),
            rng.choice([1.0, 1.0, 0.7]),
        )
        for _ in range(2)
    ]
    is_learning = kind in ("learning", "exact") or (kind != "learned" and number % 3 == 0)
    return Oracle(
        rng.uniform(0.4, 0.85),
        {"+6": 0.06, "+12": 0.12, "twice": 0.06}.get(kind, 0.0),
        rng.uniform(1.0, 1.3) if is_learning else rng.uniform(0.3, 0.7),
        (0.015, 0.03, 0.06)[0 if kind == "exact" else number % 3],
        0.0 if is_exact else 0.02,
        int(rng.choice([20, 50, 100, 200])),
        list(CURVES if is_exact else DOORS)[number // 3 % (len(CURVES) if is_exact else len(DOORS))],
        (ways[0], ways[number % 4 > 0]),
        int(number % 10 == 9 and not is_exact) * 2,
        FIRST + 1_000 * [*KINDS].index(kind) + number,
    )


@dataclass
class Tally:
    """What was said of the experiments of a kind."""

    kind: str
    oracles: list[tuple[Oracle, Said]]

    @property
    def claims(self):
        """Those of which something is claimed."""
        return [(of, said) for of, said in self.oracles if said.word not in SILENT]

    def share(self, stopped=0):
        """How often something is claimed where so many trainings stopped halfway."""
        return sum(of.stopped == stopped for of, _ in self.claims) / sum(
            of.stopped == stopped for of, _ in self.oracles
        )

    @property
    def farthest(self):
        """Points between the two rewards, where no training is missing."""
        whole = (said.shares for _, said in self.oracles if said.shares and said.word != INTERIM)
        return max((abs(proposed - baseline) for baseline, proposed in whole), default=0.0)

    @property
    def differing(self):
        """Pairs of logs of the same trainings, in two ways that have an end, of which two things are said."""
        pairs = zip(self.oracles[::2], self.oracles[1::2], strict=True)
        ends = ((first, second) for (_, first), (_, second) in pairs if first.shares and second.shares)
        return [(first, second) for first, second in ends if first.word != second.word]

    @property
    def sentence(self):
        """One line."""
        words = Counter(said.word for _, said in self.oracles)
        return f"{self.kind}: {len(self.claims)} claims of {len(self.oracles)}: {words}"


def _told(oracle):
    with tempfile.TemporaryDirectory() as folder:
        DOORS[oracle.door](Path(folder), oracle)
        return oracle, answered(["report", folder], {"N": str(oracle.length)})


def tally(kind, numbers: Iterable[int]):
    """What is said of the experiments of a kind."""
    found = []
    for number in numbers:
        oracle = drawn(kind, number)
        for way in oracle.ways if kind == "twice" else ():
            found.append(_told(replace(oracle, ways=(way, way))))
        if kind != "twice":
            found.append(_told(oracle))
    return Tally(kind, found)
