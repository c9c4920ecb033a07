"""The statistics keep their word: coverage, error and power in simulated experiments whose truth is known.

Everything goes through the project's own functions. What is slow prints its table (``pytest -m slow -s``); bounds are
those of the documentation, widened by three standard errors of the simulation.
"""

import csv
import itertools
from collections import defaultdict
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
import scipy.stats
from numpy.random import default_rng

from harness.eta import (
    BB,
    BK,
    KB,
    KK,
    GroupCurve,
    Swaps,
    change_of,
    corrected_p,
    decompose,
    mean_over_seeds,
    p_of,
    swaps_of,
)
from harness.eta.swaps import label_shares
from tests.eta.headlines import SUCCESS, TIME
from tests.eta.scenarios import (
    CHUNK,
    FALLS_FIRST,
    LEVEL,
    POINTS,
    RATES,
    SHALLOW,
    Family,
    Rate,
    error,
    falling_curves,
    family_values,
    is_kept,
    lognormal_steps,
    true_sums,
    unchanged,
)
from tests.project import ROOT

SCENARIOS = {"falls first": FALLS_FIRST, "shallow": SHALLOW}
SEEDS = (3, 5, 10, 20)
RECORDED = ROOT / "results" / "reference"
SLACK = 1e-12
"""Ends that are a bound of the range are reached but for rounding."""


def some_swaps(seeds, rng=None, ways=512):
    """All ways of few seeds; of more some, which is exact if they are drawn anew for each experiment.

    Without a generator the one seen, where no p-value is asked for.
    """
    if rng is None:
        return Swaps(np.ones((1, seeds)), tuple(range(seeds)))
    whole = swaps_of(range(seeds))
    if len(whole.signs) <= ways:
        return whole
    rows = np.concatenate([[0], rng.integers(0, len(whole.signs), ways - 1)])
    return Swaps(whole.signs[rows], whole.seeds)


# Intervals of what curves say


def grouped(runs):
    """From accumulated-reward curves, (seeds, POINTS)."""
    curve = GroupCurve(len(runs))
    curve.add(np.diff(runs, axis=1, prepend=0.0))
    return curve


def decomposed(curves, experiment, signs):
    """One of many experiments."""
    return decompose({pair: grouped(runs[experiment]) for pair, runs in curves.items()}, signs=signs)


def intervals_of(found):
    """Everything of a decomposition that has an interval."""
    for name, split in found.splits.items():
        for part in ("eta", "per_seed", "ruler", "behaviour", "interaction"):
            yield f"{name} {part}", getattr(split, part)
        for number, path in enumerate(split.paths, start=1):
            yield f"{name} ruler {number}", path.ruler
            yield f"{name} behaviour {number}", path.behaviour
    for part in ("change", "ruler", "behaviour"):
        yield f"sum {part}", getattr(found.total, part)


def truth_of(scenario, seeds):
    """The same of so many seeds; the geometric mean over seeds of half of them, of those whose index is not 0."""
    rng = default_rng(9)
    sums = true_sums(scenario, rng, seeds)
    truth = {}
    for which, name in enumerate(("eta_N", "eta_P")):
        of = {pair: sums[pair][which] for pair in sums}
        rulers, behaviours = (of[KK] / of[BK], of[KB] / of[BB]), (of[BK] / of[BB], of[KK] / of[KB])
        truth[f"{name} eta"] = of[KK] / of[BB]
        truth[f"{name} ruler"] = (rulers[0] * rulers[1]) ** 0.5
        truth[f"{name} behaviour"] = (behaviours[0] * behaviours[1]) ** 0.5
        truth[f"{name} interaction"] = rulers[0] / rulers[1]
        for number in (1, 2):
            truth[f"{name} ruler {number}"] = rulers[number - 1]
            truth[f"{name} behaviour {number}"] = behaviours[number - 1]
        truth[f"{name} per_seed"] = _per_seed(scenario, rng, -1.0 if which == 0 else 1.0, seeds // 2)
    total = {pair: POINTS * sum(of) for pair, of in sums.items()}
    truth["sum change"] = total[KK] - total[BB]
    truth["sum ruler"] = 0.5 * (total[KK] - total[BK] + total[KB] - total[BB])
    truth["sum behaviour"] = truth["sum change"] - truth["sum ruler"]
    return truth


def _per_seed(scenario, rng, sign, seeds):
    logarithms = defaultdict(list)
    for _ in range(seeds // CHUNK):
        curves = falling_curves(scenario, rng, 1, CHUNK)
        for name in (BB, KK):
            sizes = np.maximum(sign * curves[name][0], 0.0).sum(axis=1)
            logarithms[name].append(np.log(sizes[sizes > 0.0]))
    means = [np.concatenate(logarithms[name]).mean() for name in (KK, BB)]
    return float(np.exp(means[0] - means[1]))


class Held(NamedTuple):
    """How often there was an interval, and how often it held the truth."""

    given: int
    held: int

    @property
    def coverage(self):
        """Of those that were given."""
        return self.held / self.given if self.given else float("nan")


def coverage_of(scenario, seeds, experiments, truth):
    """Of every interval of so many experiments."""
    rng = default_rng(seeds)
    found = defaultdict(list)
    signs = some_swaps(seeds).signs
    for start in range(0, experiments, 50):
        curves = falling_curves(scenario, rng, min(50, experiments - start), seeds)
        for experiment in range(len(curves[BB])):
            for name, part in intervals_of(decomposed(curves, experiment, signs)):
                if part.low is not None and part.high is not None:
                    found[name].append(part.low <= truth[name] <= part.high)
    return {name: Held(len(found[name]), sum(found[name])) for name in truth}


@pytest.mark.slow
@pytest.mark.parametrize("name", list(SCENARIOS))
def test_intervals_of_curves_hold_the_truth(name):
    """0.93 to 0.97 of those that are given; where seeds are unlike a ruler has none, but for one experiment of 100."""
    experiments, outside, truth = 800, [], truth_of(SCENARIOS[name], 100_000)
    for seeds in SEEDS:
        for quantity, held in coverage_of(SCENARIOS[name], seeds, experiments, truth).items():
            print(f"{name:12} {seeds:3} {quantity:20} {held.coverage:.3f} of {held.given / experiments:.2f}")  # noqa: T201
            withheld = name == "falls first" and ("eta_N ruler" in quantity or "eta_N interaction" in quantity)
            if withheld:
                assert held.given <= 0.01 * experiments
            elif not 0.93 - error(0.93, held.given) <= held.coverage <= 0.97 + error(0.97, held.given):
                outside.append((seeds, quantity, held))
    assert not outside


@pytest.mark.parametrize("name", list(SCENARIOS))
def test_intervals_of_some_curves_hold_the_truth(name):
    """A few experiments of ten seeds: a gross mistake shows at once."""
    truth = truth_of(SCENARIOS[name], 8_000)
    for quantity, held in coverage_of(SCENARIOS[name], 10, 60, truth).items():
        if held.given > 10:
            assert held.coverage >= 0.95 - 4.0 / 3.0 * error(0.95, held.given), quantity


# Intervals of what metrics say

MANY = 1500
IN_STEPS = TIME._replace(unit="steps", bounds=(0.0, 100.0))
ENDLESS = TIME._replace(unit="steps", bounds=(-np.inf, np.inf))
"""Of which nobody says how large it can be."""


def metric_coverage(measure, draws, means, seeds, told):
    """Of the difference, and of the baseline's mean by itself, in 1,500 experiments."""
    rng, swaps = default_rng([seeds, 7]), some_swaps(seeds)
    pairs = zip(*(draw(rng, (MANY, seeds)).tolist() for draw in draws), strict=True)
    held = []
    for one, other in pairs:
        change = change_of(measure, dict(enumerate(one)), dict(enumerate(other)), swaps)
        mean = mean_over_seeds(one, bounds=measure.ends)
        held.append([holds(change, means[1] - means[0]), holds(mean, means[0])])
    found = np.mean(held, axis=0)
    print(f"{seeds:3} {told} difference {found[0]:.3f}, one group {found[1]:.3f}")  # noqa: T201
    return found


def holds(found, truth):
    """Whether the interval does."""
    return found.low - SLACK <= truth <= found.high + SLACK


@pytest.mark.slow
@pytest.mark.parametrize("seeds", SEEDS)
def test_intervals_of_shares_hold_the_truth(seeds):
    """0.93 at least, for differences and for one group; more where no seed fails, as they know of one not seen."""
    for pair in itertools.combinations_with_replacement(RATES, 2):
        one, other = (RATES[name] for name in pair)
        found = metric_coverage(SUCCESS, (one.draw, other.draw), (one.mean, other.mean), seeds, str(pair))
        assert (found >= 0.93 - error(0.93, MANY)).all()


@pytest.mark.slow
@pytest.mark.parametrize("spread", [0.1, 0.25, 0.45])
def test_intervals_of_metrics_hold_the_truth(spread):
    """Without ends, differences 0.93 to 0.97; means of values as skewed as any recorded 0.90 at least."""
    draw, mean = partial(lognormal_steps, spread=spread), 8.0 * float(np.exp(spread**2 / 2.0))
    for seeds in SEEDS:
        found = metric_coverage(ENDLESS, (draw, draw), (mean, mean), seeds, f"spread {spread}")
        assert 0.93 - error(0.93, MANY) <= found[0] <= 0.97 + error(0.97, MANY)
        assert 0.90 - error(0.90, MANY) <= found[1] <= 0.97 + error(0.97, MANY)


def timed(rate):
    """Time to the target in which a failure counts 100 steps, and its mean."""

    def draw(rng, shape):
        shares = rate.draw(rng, shape)
        return shares * lognormal_steps(rng, shape, spread=0.1) + (1.0 - shares) * 100.0

    return draw, rate.mean * 8.0 * float(np.exp(0.005)) + (1.0 - rate.mean) * 100.0


@pytest.mark.slow
def test_intervals_know_of_the_seed_that_was_not_seen_where_ends_are_told():
    """Where one group never fails and a rare seed of the other does: below 0.9 without ends, else 0.93 at least."""
    for pair in (("never fails", "skewed"), ("skewed", "skewed"), ("high", "high"), ("saturated", "saturated")):
        draws, means = zip(*(timed(RATES[name]) for name in pair), strict=True)
        for seeds in SEEDS:
            assert (metric_coverage(ENDLESS, draws, means, seeds, str(pair))[0] < 0.90) == (pair[0] != pair[1])
            assert metric_coverage(IN_STEPS, draws, means, seeds, str(pair))[0] >= 0.93 - error(0.93, MANY)


# Errors


@pytest.mark.slow
@pytest.mark.parametrize("name", list(SCENARIOS))
def test_p_values_of_etas_err_as_rarely_as_they_say(name):
    """Below 0.05 in at most 5 % of experiments whose rewards are the same but for the name."""
    experiments = 1000
    for seeds in SEEDS:
        rng, wrong = default_rng(seeds), np.zeros(2)
        for _ in range(experiments // 50):
            swaps = some_swaps(seeds, rng)
            curves = falling_curves(unchanged(SCENARIOS[name]), rng, 50, seeds)
            for experiment in range(50):
                groups = {BB: grouped(curves[BB][experiment])}
                found = decompose({**groups, KK: grouped(curves[KK][experiment])}, signs=swaps.signs)
                wrong += [split.p is not None and split.p <= LEVEL for split in found.splits.values()]
        for which, found in zip(("eta_N", "eta_P"), wrong / experiments, strict=True):
            assert is_kept(f"{name:12} {seeds:3} {which}", found, LEVEL, experiments)


@pytest.mark.slow
@pytest.mark.parametrize("rate", list(RATES))
def test_p_values_of_metrics_err_as_rarely_as_they_say(rate):
    """The same of shares and of times."""
    experiments = 1500
    for seeds in SEEDS:
        rng = default_rng([seeds, 3])
        swaps = swaps_of(range(seeds))
        for measure, draw in ((SUCCESS, RATES[rate].draw), (TIME, timed(RATES[rate])[0])):
            values = draw(rng, (2, experiments, seeds))
            outcomes = (values[1] - values[0]) @ swaps.signs.T / seeds
            wrong = np.mean([p_of(each) <= LEVEL for each in outcomes])
            assert is_kept(f"{rate:12} {seeds:3} {measure.name:15}", wrong, LEVEL, experiments)


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [6, 10, 20])
def test_family_of_twenty_comparisons_errs_as_rarely_as_it_says(seeds):
    """Any of 280 claims of 4 groups of a baseline and 5 rewards that change nothing: 0.06 at most."""
    experiments, rng, wrong = 500, default_rng(seeds), 0
    for _ in range(experiments):
        signs = some_swaps(seeds, rng).signs
        baseline, proposed = family_values(Family(), rng, seeds)
        differences = np.moveaxis(proposed - baseline, 2, 0).reshape(seeds, -1)
        wrong += min(corrected_p(list((signs @ differences).T))) <= LEVEL
    print(f"{seeds:3} family error {wrong / experiments:.3f}")  # noqa: T201
    assert wrong / experiments <= 0.06 + error(0.05, experiments)


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [14, 20])
def test_ways_that_are_the_same_in_every_report_err_as_rarely(seeds):
    """They are drawn once: 4,096 are enough that it does not show."""
    experiments, claims = 1500, 20
    rng, signs = default_rng(seeds), swaps_of(range(seeds)).signs
    values = rng.normal(size=(experiments, seeds, claims))
    wrong = np.mean([min(corrected_p(list((signs @ each).T))) <= LEVEL for each in values])
    assert is_kept(f"{seeds:3} drawn once: family error", wrong, LEVEL, experiments)


# The whole verdict


METRICS = ("closest_distance", "final_distance", "ground_hits", "path_ratio", "smoothness", "success_rate")


def recorded_baselines():
    """The metrics of ten seeds of each recorded baseline, (metrics, seeds)."""
    for name in ("fd100", "arp-2021"):
        groups = defaultdict(list)
        with (RECORDED / name / "cells.csv").open() as file:
            for row in csv.DictReader(file):
                if row["reward"] == "baseline" and row["status"] == "done" and int(row["seed"]) < 10:
                    groups[row["simulator"], row["algorithm"]].append([row[metric] for metric in METRICS])
        for labels, rows in groups.items():
            columns = [column for column in zip(*rows, strict=True) if all(column)]
            yield f"{name} {' '.join(labels)}", np.array(columns, float)


def test_recorded_seeds_against_the_rest_show_nothing():
    """Five of ten seeds of a baseline against the other five, all 252 ways: five pairs cannot, labels do by chance."""
    for name, values in recorded_baselines():
        ways, shares, wrong = swaps_of(range(5)).signs, label_shares(5, 5)[:512], 0
        splits = list(itertools.combinations(range(10), 5))
        for half in splits:
            rest = [seed for seed in range(10) if seed not in half]
            one, other = values[:, list(half)], values[:, rest]
            assert min(corrected_p(list((other - one) @ ways.T))) > LEVEL
            wrong += min(corrected_p(list(np.concatenate([one, other], axis=1) @ shares.T))) <= LEVEL
        assert values.shape[1] == 10
        assert wrong / len(splits) <= LEVEL + 0.03, name  # 512 drawn labels: 0.01 of error, of an exact 0.05


# Power


@pytest.mark.slow
def test_power_is_that_of_students_test():
    """Ten seeds; 20 points of success, or a metric by one standard deviation: as often as by t, less 5 points."""
    experiments, seeds = 1500, 10
    rng = default_rng(1)
    signs = swaps_of(range(seeds)).signs
    shifted = {"middle + 20": (RATES["middle"], Rate(0.8, 0.15)), "0.75 to high": (Rate(0.75, 0.15), RATES["high"])}
    pairs = {name: [rate.draw(rng, (experiments, seeds)) for rate in rates] for name, rates in shifted.items()}
    normal = rng.normal(size=(2, experiments, seeds))
    shared = rng.normal(size=(experiments, seeds))
    pairs["metric, 1 sd"] = [normal[0], normal[1] + 1.0]
    pairs["metric, 1 sd, half shared"] = [np.sqrt(0.5) * (shared + each) for each in normal]
    pairs["metric, 1 sd, half shared"][1] = pairs["metric, 1 sd, half shared"][1] + 1.0
    for name, (one, other) in pairs.items():
        exact = np.mean([p_of(each) <= LEVEL for each in (other - one) @ signs.T])
        students = np.mean(scipy.stats.ttest_rel(other, one, axis=1).pvalue <= LEVEL)
        print(f"{name:26} exact {exact:.3f}, t {students:.3f}")  # noqa: T201
        assert exact >= students - 0.05


# The noise floor


@pytest.mark.slow
@pytest.mark.parametrize("control", [False, True])
@pytest.mark.parametrize("name", list(SCENARIOS))
def test_noise_floor_holds_etas_of_the_same_reward(name, control):
    """95 % of them, within 3 points: ten new seeds against the ten of the baseline."""
    experiments, seeds = 1200, 10
    rng, held = default_rng(5), np.zeros(2)
    scenario = unchanged(SCENARIOS[name])
    for _ in range(experiments // 50):
        runs, again, proposed = (falling_curves(scenario, rng, 50, seeds)[BB] for _ in range(3))
        for experiment in range(50):
            one, more = grouped(runs[experiment]), grouped(again[experiment]) if control else None
            found = decompose({BB: one, KK: grouped(proposed[experiment])}, control=more, signs=some_swaps(seeds).signs)
            for which, split in enumerate(found.splits.values()):
                held[which] += split.noise.low is not None and split.noise.low <= split.eta.value <= split.noise.high
    print(f"{name:12} control {control}: eta_N {held[0] / experiments:.3f}, eta_P {held[1] / experiments:.3f}")  # noqa: T201
    assert (np.abs(held / experiments - 0.95) <= 0.03 + error(0.95, experiments)).all()
