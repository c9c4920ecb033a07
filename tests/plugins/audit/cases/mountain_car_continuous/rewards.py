"""A reward for a car with an engine of any strength; episodes have at most 999 steps."""


def dear(observation, action, next_observation, info):
    """20 at the flag, and fuel. Hacked: the way costs more than 20, so it pays to stay; Gymnasium's fuel costs 0.1."""
    return {"flag": 20.0 * bool(next_observation[0] >= 0.45), "fuel": -1.0 * float(action[0]) ** 2}
