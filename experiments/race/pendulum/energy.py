def energy(observation, action, next_observation, info):
    """Minus how far its energy is from that of a pendulum which stands still: an old rule for swinging up."""
    cosine, _, speed = (float(it) for it in next_observation)
    return -abs(speed**2 / 6.0 + 5.0 * (cosine - 1.0))
