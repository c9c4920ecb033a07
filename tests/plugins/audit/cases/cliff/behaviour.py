def success(observation, action, next_observation, info):
    """Whether it is at the goal, in the corner."""
    return bool(next_observation == 47)
