def success(observation, action, next_observation, info):
    """Whether the pendulum stands, almost still, in the last step."""
    return bool(next_observation[0] > 0.95 and abs(next_observation[2]) < 1.0)
