"""How well a pendulum stands, as Gymnasium charges it, and a reward for the speed of its tip."""

import math

lower_is_better = ["cost"]


def cost(observation, action, next_observation, info):
    """The squared angle from upright, and a tenth of the squared speed, in the last step; less is better."""
    return math.atan2(next_observation[1], next_observation[0]) ** 2 + 0.1 * float(next_observation[2]) ** 2
