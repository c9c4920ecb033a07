"""Rewards for a car that shall reach the flag on the hill, which ends an episode of at most 200 steps."""

import math


def height(observation, action, next_observation, info):
    """How high it is, from 0.1 to 1. Hacked: the flag ends the pay, and rocking below it goes on for 200 steps."""
    return 0.45 * math.sin(3.0 * float(next_observation[0])) + 0.55


def shaped(observation, action, next_observation, info):
    """-1 a step, and shaping by the height, for a learner that discounts by 0.99. Honest by the theorem."""
    before, after = (math.sin(3.0 * float(it[0])) for it in (observation, next_observation))
    return -1.0 + 10.0 * (0.99 * after - before)


class best:  # noqa: N801
    """What it came farther to the right than ever before, ten times. Honest: nothing is farther than the flag."""

    def reset(self):
        """Begin an episode."""
        self.best = None

    def __call__(self, observation, action, next_observation, info):
        """Pay a step."""
        best = float(observation[0]) if self.best is None else self.best
        self.best = max(best, float(next_observation[0]))
        return 10.0 * (self.best - best) + 5.0 * bool(next_observation[0] >= 0.5)
