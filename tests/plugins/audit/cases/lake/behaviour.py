def success(observation, action, next_observation, info):
    """Whether it is at the goal."""
    return bool(next_observation == 15)
