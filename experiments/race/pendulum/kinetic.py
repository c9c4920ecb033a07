def kinetic(observation, action, next_observation, info):
    """Its kinetic energy: a pendulum that hangs still can never stand, so movement is paid."""
    return float(next_observation[2]) ** 2
