"""Recorded runs scored by a reward, or why they cannot be: a reward may be gone, changed or broken since."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.errors import HarnessError, one_line
from harness.record.trace import Trace
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.reward import Reward
from harness.score.scorer import score_trace


class ScoredRuns(NamedTuple):
    """What a reward pays for runs."""

    values: list[Float] | None
    """Of every run, one value per row, (rows,); None where the runs could not be scored."""
    reason: str = ""
    """Why they could not; empty if they were."""


def score_runs(choice: Choice, registry: Registry, own: Trace | None, runs: Sequence[Trace]) -> ScoredRuns:
    """The shaped reward of every row of `runs` under a reward.

    Args:
        choice: The reward.
        registry: The plugins.
        own: What the reward itself paid, with the column ``reward``: one that pays it otherwise now is another reward.
            None where nothing is recorded.
        runs: To score.
    """
    try:
        return ScoredRuns(_score(choice, registry, own, runs))
    except HarnessError as error:  # a reward that is not installed any more: the rest can still be said
        return ScoredRuns(None, str(error))
    except Exception as error:  # one that is, and cannot any more: a plugin may raise anything
        return ScoredRuns(None, f"a reward could not score the runs: {one_line(error)}")


def _score(choice: Choice, registry: Registry, own: Trace | None, runs: Sequence[Trace]) -> list[Float]:
    reward: Reward = choice.build(registry, "rewards")
    if own is not None and not _pays(reward, own):
        raise HarnessError(f"reward {choice.label} pays its own recorded steps otherwise than then: it has changed")
    scored = [score_trace(reward, run) for run in runs]
    if not all(np.isfinite(values).all() for values in scored):
        raise HarnessError(f"reward {choice.label} is not finite on the runs of another reward")
    return scored


def _pays(reward: Reward, trace: Trace) -> bool:
    """Whether the reward pays what is recorded; up to last bits, in which another machine may differ."""
    return np.allclose(score_trace(reward, trace), trace["reward"], rtol=1e-9, atol=1e-12)
