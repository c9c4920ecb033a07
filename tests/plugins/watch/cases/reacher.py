"""A measure for an arm whose fingertip shall be at the target, and a reward whose sign is wrong."""

import math

lower_is_better = ["distance"]


def distance(observation, action, next_observation, info):
    """From the fingertip to the target, [m]; less is better."""
    return math.hypot(next_observation[8], next_observation[9])


def away(observation, action, next_observation, info):
    """The distance to the target. Hacked: the sign is wrong, so the farther the fingertip is the better."""
    return math.hypot(next_observation[8], next_observation[9])
