"""What becomes of the returns when the workspace is larger."""

from collections.abc import Sequence

import numpy as np

from harness.audit.rollout import Rollout
from harness.audit.score import pay_distances
from harness.reward import Reward

FACTOR = 2.0


def workspace_ratios(reward: Reward, rollouts: Sequence[Rollout]) -> dict[str, float | None]:
    """Shaped return of each script with all distances `FACTOR` times as large, over that with them as they are.

    The event terms are the task's and stay: a ratio of 2 halves their weight. None where nothing is paid.
    """
    return {rollout.script: _ratio(reward, rollout) for rollout in rollouts}


def _ratio(reward: Reward, rollout: Rollout) -> float | None:
    usual, larger = (
        float(np.where(rollout.running, pay_distances(reward, factor * rollout.distances), 0.0).sum())
        for factor in (1.0, FACTOR)
    )
    return larger / usual if usual and np.isfinite(larger / usual) else None
