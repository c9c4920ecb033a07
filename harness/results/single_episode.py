"""One episode of an evaluation as a trace of its own, so that metrics can be asked about it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harness.record.trace import Trace


def single_episode(trace: Trace, rows: NDArray[np.int64]) -> Trace:
    """The trace of an evaluation that had this episode alone, in env 0.

    Args:
        trace: An evaluation: one episode in each env.
        rows: Row numbers of the episode, its start row first.
    """
    env = int(trace["env"][rows[0]])
    columns = {name: column[rows] for name, column in trace.columns.items()}
    columns["env"] = np.zeros_like(columns["env"])
    facts = trace.facts
    known = {"ik_steps": facts.ik_steps, "work": facts.work}
    own = {name: values if values is None else values[env : env + 1] for name, values in known.items()}
    return Trace(columns, replace(facts, **own))
