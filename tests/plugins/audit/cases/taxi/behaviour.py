def success(observation, action, next_observation, info):
    """Whether the passenger is where they want to be."""
    return bool((int(next_observation) // 4) % 5 == int(next_observation) % 4)
