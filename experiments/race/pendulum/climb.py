def climb(observation, action, next_observation, info):
    """How much higher it got in this step, ten times, and the height."""
    return float(10.0 * (next_observation[0] - observation[0]) + next_observation[0])
