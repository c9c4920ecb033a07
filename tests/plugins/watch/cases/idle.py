"""Rewards for a pole on a cart that shall stand."""


def idle(step):
    """Minus the force, and a cost of each step. Hacked: falling soon ends the costs."""
    return -0.1 - float(abs(step.action[0]))


def alive(step):
    """1 a step. Honest: standing longer pays more."""
    return 1.0
