"""The made-up experiments are what they are said to be: their truths, and their likeness to the committed records."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.eta import BB, KK
from tests.eta.scenarios import (
    FALLS_FIRST,
    SHALLOW,
    falling_curves,
    true_sums,
)


def rng():
    """The same numbers for every test."""
    return default_rng(0)


@pytest.mark.parametrize(("scenario", "eta_n", "eta_p"), [(FALLS_FIRST, 0.427, 1.49), (SHALLOW, 0.838, 1.58)])
def test_etas_are_near_the_recorded_ones(scenario, eta_n, eta_p):
    """SAC with arp against SAC with the baseline: within 15 %."""
    sums = true_sums(scenario, rng(), 10_000)
    assert_allclose(np.divide(sums[KK], sums[BB]), [eta_n, eta_p], rtol=0.15)


def test_spread_of_the_depth_is_near_the_recorded_one():
    """Of log I_N over the runs of arp-2021, SAC: 1.3 of the baseline, 1.9 of arp; a rare run is never negative."""
    curves = falling_curves(FALLS_FIRST, rng(), 1, 4000)
    runs = (curves[BB][0], curves[KK][0])
    depths = np.log([np.quantile(-np.minimum(run, 0.0).sum(axis=1), [0.16, 0.84]) for run in runs])
    assert_allclose(np.diff(depths)[:, 0] / 2, [1.3, 1.9], rtol=0.15)
