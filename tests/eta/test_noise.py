"""What eta comes to between runs that differ by their seeds alone."""

import itertools

import numpy as np
import pytest

from harness.eta.curve import GroupCurve, curve_of
from harness.eta.index import Ratio
from harness.eta.noise import SPLITS, noise_floor, split_halves
from tests.eta.test_decompose import dip_and_climb

NEGATIVE, POSITIVE = 0, 1


def group(seeds: int, seed: int = 105, noise: float = 1.0) -> GroupCurve:
    """The baseline's runs."""
    return curve_of(list(dip_and_climb(seeds, seed, noise=noise)))


def log_ends(noise: Ratio) -> np.ndarray:
    """Of the range."""
    assert noise.low is not None
    assert noise.high is not None
    return np.log([noise.low, noise.high])


def all_halves(runs: np.ndarray) -> np.ndarray:
    """The logarithm of I_P's ratio between halves, for every way to take half of the runs."""
    curves, logarithms = np.cumsum(runs, axis=1), []
    for half in itertools.combinations(range(len(runs)), len(runs) // 2):
        rest = [run for run in range(len(runs)) if run not in half]
        one, other = (np.maximum(curves[list(part)].mean(axis=0), 0.0).sum() for part in (half, rest))
        logarithms.append(np.log(one / other))
    return np.array(logarithms)


def test_noise_floor_is_about_one():
    """Halves of the baseline's own seeds differ by the noise: 1 lies inside, and more noise makes it wider."""
    quiet, loud = (noise_floor(group(8, noise=noise), None, POSITIVE) for noise in (0.5, 2.0))
    for noise in (quiet, loud):
        assert noise.value == 1.0
        assert noise.low < 1.0 < noise.high
        assert noise.note == "halves of 8 runs, scaled to all"
    assert np.ptp(log_ends(loud)) > 2.0 * np.ptp(log_ends(quiet))


def test_halves_are_scaled_to_all():
    """Of 6 runs there are 20 ways to take 3; groups of 6 differ by a root of 2 less; t of 5 degrees of freedom."""
    expected = np.quantile(all_halves(dip_and_climb(6)), [0.025, 0.975]) * 0.5**0.5 * 2.571 / 1.960
    assert log_ends(noise_floor(group(6), None, POSITIVE)) == pytest.approx(expected, rel=0.05)


def test_control_is_as_large_as_what_is_compared():
    """Halves of the baseline's runs and of those of the control together, in any mixture, as they are."""
    runs, again = dip_and_climb(4), dip_and_climb(4, seed=1)
    noise = noise_floor(group(4), group(4, seed=1), POSITIVE)
    expected = np.quantile(all_halves(np.concatenate([runs, again])), [0.025, 0.975]) * 2.365 / 1.960
    assert log_ends(noise) == pytest.approx(expected, rel=0.15)
    assert noise.note == "the baseline trained again with other seeds"


def test_each_index_has_its_own():
    """The height of the climb varies more than the depth of the dip."""
    negative, positive = (noise_floor(group(8), None, which) for which in (NEGATIVE, POSITIVE))
    assert np.ptp(log_ends(positive)) > 1.2 * np.ptp(log_ends(negative))


@pytest.mark.parametrize("runs", [1, 2, 3])
def test_noise_floor_needs_four_runs(runs: int):
    """Halves of fewer are single runs."""
    reason = f"{runs} runs of the baseline: halves of them need at least 4"
    assert noise_floor(group(runs), None, POSITIVE) == Ratio(None, notes=(reason,))


def test_control_counts_among_the_runs():
    """Two runs and two of the control are four."""
    assert noise_floor(group(2), group(2, seed=1), POSITIVE).value == 1.0


def test_halves_without_an_index_leave_no_floor():
    """A half that never falls below zero has nothing to divide by."""
    runs = np.ones((4, 5))
    runs[0] = -9.0
    noise = noise_floor(curve_of(list(runs)), None, NEGATIVE)
    assert noise == Ratio(None, notes=("a half of the baseline's runs has an index of 0",))


@pytest.mark.parametrize("count", [4, 5, 8])
def test_halves_are_disjoint_and_equally_large(count: int):
    """Each run is in one half at most; of an odd number one is in none."""
    first, second = split_halves(count)
    assert first.shape == second.shape == (SPLITS, count)
    assert not (first * second).any()
    for half in (first, second):
        np.testing.assert_array_equal((half > 0.0).sum(axis=1), count // 2)
        np.testing.assert_allclose(half.sum(axis=1), 1.0)


def test_halves_differ():
    """They are drawn at random, every run now in the one, now in the other, and the same each time."""
    first, second = split_halves(6)
    assert (first.any(axis=0) & second.any(axis=0)).all()
    np.testing.assert_array_equal(first, split_halves(6)[0])
