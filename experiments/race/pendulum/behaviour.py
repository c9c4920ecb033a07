def success(observation, action, next_observation, info):
    """Whether the pendulum stands, almost still, at the end of the episode."""
    return bool(next_observation[0] > 0.95 and abs(next_observation[2]) < 1.0)
