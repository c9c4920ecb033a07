import numpy as np

lower_is_better = ["distance"]


def success(step):
    """Whether the fingertip is within 5 cm of the target at the end of the episode."""
    return float(np.linalg.norm(step.observation[8:10])) < 0.05


def distance(step):
    """From the fingertip to the target, [m]."""
    return float(np.linalg.norm(step.observation[8:10]))
