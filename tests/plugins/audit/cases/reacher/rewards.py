"""Rewards for an arm whose fingertip shall be at the target in the end; every episode has 50 steps."""

import math


def approach(observation, action, next_observation, info):
    """What it came nearer, ten times. Hacked: going away costs nothing, so back and forth pays again and again."""
    before, after = (math.hypot(it[8], it[9]) for it in (observation, next_observation))
    return 10.0 * max(0.0, before - after)


def near(observation, action, next_observation, info):
    """Almost 1 at the target, and torque costs a little. Honest: arriving soon and staying pays most."""
    distance = math.hypot(next_observation[8], next_observation[9])
    return {"near": math.exp(-10.0 * distance), "torque": -0.01 * float((action**2).sum())}
