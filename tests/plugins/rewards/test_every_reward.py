"""What is the same question for several rewards; the contract asks the rest."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_array_equal

from harness_plugins.kit import check_contract
from harness_plugins.rewards.aarp import Aarp
from harness_plugins.rewards.adaptive import Adaptive
from harness_plugins.rewards.baseline_eq21 import BaselineEq21
from harness_plugins.rewards.dense import Dense
from harness_plugins.rewards.potential import Potential
from harness_plugins.rewards.relative import Relative
from harness_plugins.rewards.shifted import Shifted
from tests.plugins.rewards.distances import DISTANCES

FACTORS = st.sampled_from([0.25, 2.0, 64.0])
LEAST = 1 / 1024
"""Above the floor of `relative`, [m]."""


@pytest.mark.parametrize(
    "reward",
    [
        Aarp(k1=1.0, k2=1.0, growth=2.0, k_max=4.0),  # the gain soon meets its cap
        Adaptive(k_far=2.0, k_near=0.5),
        Potential(gamma=1.0, scale=3.0),
        Relative(denominator="current"),
        Shifted(reward="aarp:growth=2", offset=-0.5),
    ],
)
def test_contract(reward):
    """With other settings than the defaults too."""
    check_contract("reward", reward)


@pytest.mark.parametrize("reward", [Aarp(), BaselineEq21(), Dense(), Potential()])
@given(DISTANCES, FACTORS)
def test_scaling_the_workspace_scales_the_reward(episode, reward, distances, factor):
    """Values are in metres."""
    scaled = episode(reward, [factor * distance for distance in distances])
    assert_array_equal(scaled, factor * episode(reward, distances))


@pytest.mark.parametrize(
    ("reward", "least"), [(Adaptive(), 0.0), (Relative(), LEAST), (Relative(denominator="current"), LEAST)]
)
@given(DISTANCES, FACTORS)
def test_scaling_the_workspace_changes_nothing(episode, reward, least, distances, factor):
    """Scale-free, above the floor where there is one."""
    distances = np.maximum(distances, least)
    assert_array_equal(episode(reward, factor * distances), episode(reward, distances))


@pytest.mark.parametrize("reward", [Dense, Potential])
@given(DISTANCES, FACTORS)
def test_scale_multiplies_the_reward(episode, reward, distances, factor):
    """As a larger workspace does."""
    assert_array_equal(episode(reward(scale=factor), distances), factor * episode(reward(), distances))
