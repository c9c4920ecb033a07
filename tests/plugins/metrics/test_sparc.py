"""Spectral arc length: the published reference value, an independent computation, and what it does not depend on."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.linalg import norm
from numpy.random import default_rng

from harness.log import trace_of
from harness.record import EpisodeFacts
from harness_plugins.metrics.episodes import Sparc, spectral_arcs


def moved(*speeds, period=0.1):
    """Finished episodes whose end effector moves along x with these speeds, (steps,) each."""
    lengths = [len(speed) + 1 for speed in speeds]
    rows = sum(lengths)
    still = np.zeros(rows)
    return trace_of(
        {
            "env": np.repeat(np.arange(len(speeds), dtype=np.int32), lengths),
            "episode": np.zeros(rows, np.int32),
            "reward": still,
            "terminated": np.zeros(rows, bool),
            "truncated": np.isin(np.arange(rows), np.cumsum(lengths) - 1),
            "end_effector_x": np.concatenate([np.cumsum(np.concatenate([[0.0], speed])) for speed in speeds]),
            "end_effector_y": still,
            "end_effector_z": still,
        },
        EpisodeFacts(control_period=period),
    )


def spectral_arc(speed, period):
    """Of one profile."""
    return spectral_arcs([speed], period)[0]


def transformed(speed, period):
    """The definition, its Fourier transform summed term by term."""
    size = 16 * 2 ** int(np.ceil(np.log2(len(speed))))
    frequencies = np.arange(size // 2 + 1) / (size * period)
    frequencies = frequencies[frequencies <= 10.0]
    turns = np.outer(frequencies * period, np.arange(len(speed)))
    magnitude = np.abs((np.exp(-2j * np.pi * turns) * speed).sum(axis=1)) / speed.sum()
    end = max(index for index, value in enumerate(magnitude) if value >= 0.05)
    points = np.stack([frequencies[: end + 1] / frequencies[end], magnitude[: end + 1]], axis=1)
    return -float(norm(np.diff(points, axis=0), axis=1).sum())


def test_value_that_the_authors_publish():
    """Of a Gaussian speed sampled at 100 Hz, in the documentation of their code: -1.41403."""
    assert spectral_arc(np.exp(-5.0 * np.arange(-1.0, 1.0, 0.01) ** 2), 0.01) == pytest.approx(-1.41403, abs=5e-6)


def test_value_of_the_definition(subtests):
    """By a transform that is summed term by term: above half the control rate there is no spectrum."""
    for period in [0.01, 0.02, 0.1]:
        for samples in [4, 7, 33, 100]:
            with subtests.test(period=period, samples=samples):
                speed = default_rng(samples).uniform(0.0, 1.0, samples)
                assert spectral_arc(speed, period) == pytest.approx(transformed(speed, period))


@given(st.floats(1e-2, 1e3))
def test_amplitude_does_not_matter(factor):
    """Twice as far in the same time is as smooth."""
    speed = np.sin(np.linspace(0.0, np.pi, 40))
    assert spectral_arc(factor * speed, 0.02) == pytest.approx(spectral_arc(speed, 0.02))


def test_duration_does_not_matter():
    """The same motion in four times the time, as long as both are sampled well enough."""
    slow, fast = (np.sin(np.linspace(0.0, np.pi, samples)) ** 2 for samples in (800, 200))
    assert spectral_arc(slow, 0.01) == pytest.approx(spectral_arc(fast, 0.01), abs=0.02)


def test_stops_on_the_way_are_less_smooth():
    """One stroke, two with a stop between them, and four."""
    values = [Sparc()(moved(np.abs(np.sin(np.linspace(0.0, n * np.pi, 80))))) for n in (1, 2, 4)]
    assert values[0] > values[1] > values[2]


def test_mean_over_the_episodes():
    """Each counts once, and only speeds within it."""
    one, two = np.linspace(1.0, 2.0, 9), np.abs(np.sin(np.arange(1.0, 30.0)))
    assert Sparc()(moved(one, two)) == pytest.approx((spectral_arc(one, 0.1) + spectral_arc(two, 0.1)) / 2)


@pytest.mark.parametrize(
    "speed", [np.ones(3), np.zeros(20), np.full(20, 1e-9)], ids=["short", "still", "next to still"]
)
def test_short_and_standing_episodes_do_not_count(speed):
    """Alone they give no value."""
    moving = np.linspace(1.0, 2.0, 9)
    assert Sparc()(moved(speed, moving)) == pytest.approx(spectral_arc(moving, 0.1))
    assert Sparc()(moved(speed)) is None


def test_short_period_has_a_value():
    """Where next to nothing of the spectrum is below 10 Hz."""
    assert spectral_arc(np.ones(4), 1e-4) == pytest.approx(-1.0, abs=0.01)


def test_none_without_the_control_period():
    """Frequencies are not known."""
    assert Sparc()(moved(np.ones(9), period=None)) is None
