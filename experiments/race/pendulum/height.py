def height(observation, action, next_observation, info):
    """The height of the pendulum: 1 where it stands, -1 where it hangs."""
    return float(next_observation[0])
