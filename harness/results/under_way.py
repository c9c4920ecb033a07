"""What trainings that go on, or that were killed, have recorded so far: for who reads a report meanwhile."""

from pathlib import Path

import numpy as np

from harness.errors import SchemaError, one_line
from harness.log.log import SUCCESS
from harness.progress import LAST_EPISODES
from harness.record.cell import Cell
from harness.record.folder import TRACE, TRAINING_RECORDING
from harness.record.recording.recorded_training import is_recording, read_recording
from harness.record.trace import read_trace
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
            trace = read_trace(folder / TRACE)
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
