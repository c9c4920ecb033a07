"""Synthetic experiments with a known truth, modelled on the committed records: what statistics are tried on.

Every generator takes how many experiments to make, so that thousands are made at once.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import default_rng
from scipy.special import betaincinv, ndtr

from harness.eta import BB, BK, KB, KK, Question

EPISODES = 100
"""Of one evaluation: a rate is a whole number of hundredths."""
POINTS = 160
"""Of a curve, evenly spaced over the training; an index is proportional to the mean over them."""
LEVEL = 0.05
"""Of all answers of a report together."""
CHUNK = 2000
"""Experiments whose curves are in memory at once when a truth is computed."""


def error(share, experiments):
    """Three standard errors of a share of so many experiments."""
    return 3.0 * (share * (1.0 - share) / experiments) ** 0.5


def is_kept(what, share, most, experiments):
    """Whether a share of the experiments is no larger than was promised, but for chance; it is printed."""
    print(f"{what}: {share:.3f}, at most {most}")  # noqa: T201
    return share <= most + error(most, experiments)


def values_of(seeds, places=1, measures=1, effect=0.0, seed=0):
    """Normal values of a question, (2, seeds, places, measures)."""
    values = default_rng(seed).normal(size=(2, seeds, places, measures))
    values[1] += effect
    return values


def question_of(*args, **kwargs):
    """A question about such values."""
    return Question.of(values_of(*args, **kwargs))


@dataclass(frozen=True)
class Level:
    """A lognormal quantity of a run.

    Attributes:
        median: In its unit.
        spread: Standard deviation of the logarithm from seed to seed.
        paired: Correlation of the logarithms of two runs that share a seed.
    """

    median: float
    spread: float
    paired: float = 0.0


@dataclass(frozen=True)
class Training:
    """How the accumulated reward of runs goes: it falls, turns and climbs, every run on its own terms.

    Attributes:
        fall: Reward lost over a whole training in which nothing is learnt.
        turn: When the run learns, as a share of the training.
        climb: Reward earned over a whole training by who has learnt.
        width: How long learning takes, as a share of `turn`.
    """

    fall: Level
    turn: Level
    climb: Level
    width: float

    def curves(self, normals):
        """Accumulated reward of runs, (..., POINTS), from standard normals, (..., 3)."""
        levels = (self.fall, self.turn, self.climb)
        fall, turn, climb = (
            level.median * np.exp(level.spread * normals[..., i, None]) for i, level in enumerate(levels)
        )
        width = self.width * turn
        time = np.arange(1, POINTS + 1) / POINTS
        learnt = np.logaddexp(0.0, (time - turn) / width) - np.logaddexp(0.0, -turn / width)
        return (fall + climb) * width * learnt - fall * time


@dataclass(frozen=True)
class Ruler:
    """What the proposed reward makes of a run's curve: its losses and its gains count otherwise, in each run a little.

    Attributes:
        loss: Factor on negative values.
        gain: Factor on positive values.
        spread: Standard deviation of the logarithm of both from run to run.
    """

    loss: float
    gain: float
    spread: float

    def of_runs(self, rng, shape):
        """Factors on losses and on gains, (*shape, 1) both."""
        loss, gain = np.exp(self.spread * rng.normal(size=(2, *shape, 1)))
        return self.loss * loss, self.gain * gain


@dataclass(frozen=True)
class CurveScenario:
    """Two trainings and the rulers between their rewards.

    Attributes:
        baseline: Its runs, scored by the baseline.
        proposed: Its runs, scored by the proposed reward.
        ruler: From the baseline's reward to the proposed one.
    """

    baseline: Training
    proposed: Training
    ruler: Ruler


FALLS_FIRST = CurveScenario(
    baseline=Training(Level(10560.0, 0.35, 0.5), Level(0.086, 0.38, 0.5), Level(23630.0, 0.17, 0.1), width=0.43),
    proposed=Training(Level(8235.0, 0.34, 0.5), Level(0.09, 0.73, 0.5), Level(30580.0, 0.24, 0.1), width=0.32),
    ruler=Ruler(loss=0.5, gain=1.6, spread=0.1),
)
"""As SAC in arp-2021: curves fall first, some for 1 % of the training, some for 20 %. I_N is a few thousandths of
I_P, and its logarithm has a standard deviation of 1.3 (baseline) and 1.9 from seed to seed."""

SHALLOW = CurveScenario(
    baseline=Training(Level(3961.0, 0.05, 0.5), Level(0.143, 0.05, 0.5), Level(1647.0, 0.14, 0.3), width=0.65),
    proposed=Training(Level(5343.0, 0.11, 0.5), Level(0.102, 0.08, 0.5), Level(2121.0, 0.15, 0.3), width=1.1),
    ruler=Ruler(loss=0.75, gain=1.9, spread=0.05),
)
"""As SAC with 10,000 steps in fd100: half of the training is negative, seeds are alike."""


def unchanged(scenario):
    """The scenario in which the proposed reward is the baseline in all but name: every eta is 1."""
    return CurveScenario(scenario.baseline, scenario.baseline, Ruler(1.0, 1.0, scenario.ruler.spread))


def falling_curves(scenario, rng, experiments, seeds):
    """Accumulated-reward curves of paired runs, (experiments, seeds, POINTS), by reward and training."""
    shape = (experiments, seeds)
    shared, *own = rng.normal(size=(3, *shape, 3))
    levels = (scenario.baseline.fall, scenario.baseline.turn, scenario.baseline.climb)
    weight = np.array([level.paired for level in levels])
    first, second = (np.sqrt(weight) * shared + np.sqrt(1.0 - weight) * each for each in own)
    baseline, proposed = scenario.baseline.curves(first), scenario.proposed.curves(second)
    loss, gain = scenario.ruler.of_runs(rng, shape)
    other_loss, other_gain = scenario.ruler.of_runs(rng, shape)
    return {
        BB: baseline,
        KK: proposed,
        BK: np.where(proposed < 0.0, proposed / loss, proposed / gain),
        KB: np.where(baseline < 0.0, baseline * other_loss, baseline * other_gain),
    }


def true_sums(scenario, rng, seeds=100_000):
    """I_N and I_P, as means over the points, of the mean curve of so many seeds; by reward and training."""
    means = dict.fromkeys((BB, KK, BK, KB), 0.0)
    for _ in range(seeds // CHUNK):
        for pair, runs in falling_curves(scenario, rng, 1, CHUNK).items():
            means[pair] = means[pair] + runs[0].mean(axis=0) * CHUNK / seeds
    return {pair: (np.minimum(mean, 0.0).mean(), np.maximum(mean, 0.0).mean()) for pair, mean in means.items()}


@dataclass(frozen=True)
class Rate:
    """Success rates of trained policies.

    Attributes:
        mean: Over all seeds.
        likeness: Correlation of two episodes of one seed; 0: seeds do not differ, next to 1: all or nothing.
    """

    mean: float
    likeness: float

    def draw(self, rng, shape):
        """Rates over EPISODES episodes: beta-binomial."""
        if self.mean in (0.0, 1.0):
            return np.full(shape, self.mean)
        size = 1.0 / self.likeness - 1.0
        return rng.binomial(EPISODES, rng.beta(self.mean * size, (1.0 - self.mean) * size, size=shape)) / EPISODES


RATES = {
    "never fails": Rate(1.0, 0.0),
    "saturated": Rate(0.995, 0.03),
    "high": Rate(0.95, 0.05),
    "skewed": Rate(0.957, 0.2),
    "middle": Rate(0.6, 0.15),
}
"""As recorded in fd100: dense; the SAC baseline; arp; potential, 0.96 on average with one seed at 0.70; PPO on
potential. `skewed` is as skewed as any record: two seeds of three hardly ever fail."""


def lognormal_steps(rng, shape, median=8.0, spread=0.25):
    """Steps to the target of trained policies; recorded spreads are 0.05 to 0.47."""
    return median * np.exp(spread * rng.normal(size=shape))


@dataclass(frozen=True)
class Family:
    """A family of comparisons: in each group, one baseline and several proposed rewards that share its runs.

    Twelve metrics of behaviour, six of them on a lattice, and two sums whose ratio is an eta. Nothing has an effect.

    Attributes:
        groups: How many.
        proposed: Rewards of each group that are compared with its baseline.
        pairing: Share of the variance that a seed's runs have in common.
        likeness: Share of the variance that a run's metrics have in common.
    """

    groups: int = 4
    proposed: int = 5
    pairing: float = 0.2
    likeness: float = 0.5


METRICS, ETAS = 12, 2
CLAIMS = METRICS + ETAS
FAILURES, RARE = slice(6, 10), slice(10, 12)
"""Claims on a lattice: rates of failure, skewed, and hits of the ground, 0 for nine seeds of ten."""
FAILURE_MEANS = np.array([0.01, 0.05, 0.05, 0.2])
SPREADS = np.array([0.0, 0.0, 0.0, 0.25, 0.25, 0.45, *[0.0] * 6, 1.3, 0.35])
"""Of the logarithm of each claim's values; 0 for a metric that is normal or on a lattice."""


def family_values(family, rng, seeds):
    """One family's values of the baselines, (groups, 1, seeds, CLAIMS), and of the proposed rewards.

    The last ETAS claims are sums, positive: a claim about them is one about the ratio of their means.
    """
    shape = (family.groups, 1 + family.proposed, seeds)
    common = rng.normal(size=(family.groups, 1, seeds, CLAIMS))
    own = np.sqrt(family.likeness) * rng.normal(size=(*shape, 1))
    own = own + np.sqrt(1.0 - family.likeness) * rng.normal(size=(*shape, CLAIMS))
    values = np.sqrt(family.pairing) * common + np.sqrt(1.0 - family.pairing) * own
    for claims in (slice(3, 6), slice(METRICS, CLAIMS)):  # lognormal, with a mean of 1
        values[..., claims] = np.exp(SPREADS[claims] * values[..., claims] - SPREADS[claims] ** 2 / 2)
    # Rates of failure in hundredths, beta by their normals; rounded at random, which keeps their means.
    size = 1.0 / 0.05 - 1.0
    rates = betaincinv(FAILURE_MEANS * size, (1.0 - FAILURE_MEANS) * size, ndtr(values[..., FAILURES]))
    values[..., FAILURES] = np.floor(rates * EPISODES + rng.random(size=rates.shape)) / EPISODES
    values[..., RARE] = np.round(5.0 * np.maximum(values[..., RARE] - 1.3, 0.0)) / EPISODES
    return values[:, :1], values[:, 1:]
