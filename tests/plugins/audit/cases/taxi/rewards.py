"""A reward for a taxi that shall bring a passenger to one of four places; 200 steps at most."""


def pickup(observation, action, next_observation, info):
    """10 for each pick-up, 20 for the way's end, -1 a step. Hacked: drop the passenger at once and pick up again."""
    before, after = ((int(it) // 4) % 5 for it in (observation, next_observation))
    arrived = after == int(next_observation) % 4
    return {"time": -1.0, "pickup": 10.0 * (before != 4 and after == 4), "arrived": 20.0 * arrived}
