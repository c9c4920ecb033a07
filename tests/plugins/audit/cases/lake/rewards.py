"""Rewards for a way over a frozen lake of 4 x 4 fields; 100 steps at most."""


def closer(observation, action, next_observation, info):
    """1 for each step towards the goal, and 1 at the goal. Hacked: steps away cost nothing, so there is a loop."""
    before, after = (it // 4 + it % 4 for it in (int(observation), int(next_observation)))
    return float(after > before) + float(next_observation == 15)


def alive(observation, action, next_observation, info):
    """0.1 for each step on the ice, 1 at the goal. Hacked: 100 steps far from the holes pay ten times the goal."""
    return {"ice": 0.1 * (next_observation not in (5, 7, 11, 12)), "goal": 1.0 * (next_observation == 15)}
