def success(observation, action, next_observation, info):
    """Whether the car is at the flag."""
    return bool(next_observation[0] >= 0.45)
