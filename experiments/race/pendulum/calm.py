def calm(observation, action, next_observation, info):
    """The height, minus a tenth of the speed: it shall stand still up there."""
    return float(next_observation[0] - 0.1 * abs(next_observation[2]))
