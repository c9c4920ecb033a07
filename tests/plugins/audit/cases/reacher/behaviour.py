import math


def success(observation, action, next_observation, info):
    """Whether the fingertip is within 5 cm of the target in the last step."""
    return math.hypot(next_observation[8], next_observation[9]) < 0.05
