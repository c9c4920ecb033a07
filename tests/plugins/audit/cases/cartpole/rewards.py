"""Rewards for a pole that shall be balanced for 500 steps."""


def steady(step):
    """0.1 a step, and a change of direction costs 1. Hacked: falling pays 1, balancing costs hundreds."""
    return {"alive": 0.1, "change": -1.0 * float(step.action != step.before.action)}


def centred(step):
    """1 a step, less for place and angle. Honest: a step where it stands pays, none costs more than 1."""
    place, _, angle, _ = (abs(float(it)) for it in step.observation)
    return {"alive": 1.0, "place": -0.1 * place, "angle": -1.0 * angle}
