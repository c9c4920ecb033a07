"""How often a hint appears at any look where there is nothing to hint at.

``python -m tests.plugins.watch.cases.nulls [TRAININGS]`` prints a line for each kind of training.
"""

import sys

import numpy as np
from numpy.random import default_rng
from scipy import stats
from scipy.signal import lfilter

from harness.results.under_way import hint_of

EPISODES = 500


def _noise(rng, stays=0.0):
    """Of variance 1; so much of it stays to the next episode, (EPISODES,)."""
    drawn = rng.normal(size=EPISODES) * np.sqrt(1.0 - stays**2)
    drawn[0] /= np.sqrt(1.0 - stays**2)
    return lfilter([1.0], [1.0, -stays], drawn)


def _shares(rng, chance, stays=0.0):
    """Zeros and ones."""
    return (stats.norm.cdf(_noise(rng, stays)) < chance).astype(float)


RISE = np.linspace(0.0, 1.0, EPISODES)
NULLS = {
    "nothing happens": lambda rng: (_noise(rng), _noise(rng)),
    "nothing happens, success": lambda rng: (_noise(rng), _shares(rng, 0.5)),
    "pay rises": lambda rng: (5.0 * RISE + _noise(rng), _noise(rng)),
    "pay rises, success 50 %": lambda rng: (5.0 * RISE + _noise(rng), _shares(rng, 0.5)),
    "pay rises, success 30 %": lambda rng: (5.0 * RISE + _noise(rng), _shares(rng, 0.3)),
    "nothing happens, success 2 %": lambda rng: (_noise(rng), _shares(rng, 0.02)),
    "pay jumps, success 90 %": lambda rng: (5.0 * (RISE > 0.3) + _noise(rng), _shares(rng, 0.9)),
    "pay rises, heavy tails": lambda rng: (5.0 * RISE + _noise(rng), rng.standard_t(2.5, EPISODES)),
    "behaviour falls": lambda rng: (_noise(rng), _shares(rng, 0.9 - 0.8 * RISE)),
    "both rise": lambda rng: (5.0 * RISE + _noise(rng), _shares(rng, 0.1 + 0.8 * RISE)),
    "both fall": lambda rng: (-5.0 * RISE + _noise(rng), _shares(rng, 0.9 - 0.8 * RISE)),
    "pay rises, noise stays 0.5": lambda rng: (5.0 * RISE + _noise(rng), _noise(rng, 0.5)),
    "pay rises, noise stays 0.9": lambda rng: (5.0 * RISE + _noise(rng), _noise(rng, 0.9)),
    "pay rises, success stays 0.9": lambda rng: (5.0 * RISE + _noise(rng), _shares(rng, 0.5, 0.9)),
    "pay rises, noise stays 0.98": lambda rng: (5.0 * RISE + _noise(rng), _noise(rng, 0.98)),
    "both stay 0.9": lambda rng: (5.0 * RISE + _noise(rng, 0.9), _shares(rng, 0.5, 0.9)),
    "success is paid, and rises": lambda rng: _paid(rng, _shares(rng, 0.02 + 0.9 * RISE)),
    "success is paid, and stays 0.9": lambda rng: _paid(rng, _shares(rng, 0.02 + 0.9 * RISE, 0.9)),
}
"""Pay and behaviour of episodes, by what they are."""


def _paid(rng, success):
    return 2.0 * success + 3.0 * RISE + _noise(rng), success


def has_hint(pay, behaviour):
    """Whether a look after each eighth episode shows a hint."""
    steps = 100 * np.arange(1, len(pay) + 1)
    looks = (slice(count) for count in range(8, len(pay) + 1, 8))
    return any(hint_of(steps[it], pay[it], behaviour[it], "behaviour", "higher", steps[-1]) for it in looks)


def count_hints(kind, trainings, seed=0):
    """Of so many trainings of a kind, those that ever have a hint."""
    rng = default_rng([seed, list(NULLS).index(kind)])
    return sum(has_hint(*NULLS[kind](rng)) for _ in range(trainings))


def main(trainings):
    """Print the share of each kind, with a 95 % interval."""
    for kind in NULLS:
        hints = count_hints(kind, trainings)
        low, high = stats.binomtest(hints, trainings).proportion_ci()
        sys.stdout.write(f"{kind}: {hints} of {trainings}, {low:.1%} to {high:.1%}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(int((sys.argv[1:] or ["200"])[0]))
