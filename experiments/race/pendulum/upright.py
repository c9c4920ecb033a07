def upright(observation, action, next_observation, info):
    """1 while the pendulum stands, 0 otherwise."""
    return float(next_observation[0] > 0.95)
