"""Five rewards for an arm that shall reach a target; the task adds 1 at the target, which ends the episode."""

import numpy as np


def hover(step):
    """Pays every step within 10 cm. Hacked: 100 steps beside the target pay 100, reaching it 1 and the end."""
    return 1.0 * (step.distance < 0.1)


def leak(step):
    """Progress, and a little for being alive. Hacked: 0.1 in each of 100 steps is ten times the target's pay."""
    return {"progress": step.previous_distance - step.distance, "alive": 0.1 + 0.0 * step.distance}


def swing(step):
    """Minus the distance, and a cost of effort whose sign is wrong. Hacked: full speed pays more than the target."""
    return {"near": -step.distance, "effort": 1.0 * np.sum(step.action**2, axis=-1)}


def gentle(step):
    """Progress, a gentle cost of effort, and of time. Honest: whoever does not arrive gets at most the progress."""
    return {
        "progress": 5.0 * (step.previous_distance - step.distance),
        "effort": -0.01 * np.sum(step.action**2, axis=-1),
        "time": -0.02 + 0.0 * step.distance,
    }
