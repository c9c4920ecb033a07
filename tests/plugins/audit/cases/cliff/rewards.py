"""A reward for a walk along a cliff, from corner to corner of a grid of 4 x 12."""


def touch(observation, action, next_observation, info):
    """10 above the goal, so that it learns to come there, and 10 at the goal. Hacked: it can come there again."""
    return 10.0 * (next_observation in (35, 47)) - 1.0
