"""What trainings that go on, or that were killed, have recorded so far: for who reads a report meanwhile."""

from pathlib import Path

import numpy as np

from harness.errors import SchemaError, one_line
from harness.log.log import EPISODES, SUCCESS, joined
from harness.progress import LAST_EPISODES
from harness.record.cell import Cell
from harness.record.folder import TRACE, TRAINING_RECORDING, parts_of
from harness.record.recording.recorded_training import is_recording, read_recording
from harness.record.trace import trace_of, trace_part
from harness.results.cell_results import learned
from harness.results.recordings.episodes import episodes_of


def told_so_far(cell: Cell, folder: Path) -> str:
    """How far the training in a partial folder is, and what its last episodes came to; empty before its first row."""
    try:
        if is_recording(folder / TRAINING_RECORDING):
            log = read_recording(folder / TRAINING_RECORDING).load()
            steps, episodes = len(log), episodes_of(log)
            paid, reached = episodes.returns[cell.reward.label], episodes.behaviour.get(SUCCESS)
        elif (folder / TRACE).exists():
            parts = [trace_part(part, (*EPISODES, "step", "reached", "reward")) for part in parts_of(folder / TRACE)]
            trace = trace_of(joined(parts))
            steps, (_, reached, paid) = int(np.count_nonzero(trace["step"])), learned(trace).reshape(3, -1)
        else:
            return ""
    except SchemaError as error:
        return one_line(error)
    told = f"{cell.title} has recorded {steps:,} of {cell.steps:,} steps"
    if not len(paid):
        return f"{told}, and no episode has ended"
    last = paid[-LAST_EPISODES:]
    success = "" if reached is None else f", and {reached[-LAST_EPISODES:].mean():.0%} succeeded"
    return f"{told}; its last {len(last)} episodes were paid {last.mean():.4g} on average{success}"
