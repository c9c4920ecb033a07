"""One episode of an evaluation as a trace of its own, for which metrics can be computed."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harness.record.trace import Trace


def single_episode(trace: Trace, rows: NDArray[np.int64]) -> Trace:
    """The trace of an evaluation with this episode alone, in env 0.

    Args:
        trace: An evaluation: one episode in each env.
        rows: Row numbers of the episode, its start row first.
    """
    env = int(trace["env"][rows[0]])
    columns = {name: column[rows] for name, column in trace.columns.items()}
    columns["env"] = np.zeros_like(columns["env"])
    steps, work = trace.facts.ik_steps, trace.facts.work
    own = slice(env, env + 1)
    return Trace(columns, replace(trace.facts, ik_steps=steps and steps[own], work=work and work[own]))
