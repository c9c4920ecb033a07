import math


def close(observation, action, next_observation, info):
    """Almost 1 where it stands, almost 0 from an angle of a quarter turn on; torque costs a little."""
    angle = math.atan2(next_observation[1], next_observation[0])
    return math.exp(-(angle**2)) - 0.01 * float(action[0]) ** 2
