"""Reads the results in an experiment's folder. Importing it loads no robot, policy, environment or engine."""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.results.comparison import Comparison as Comparison, Group as Group
from harness.results.results import Results as Results

if TYPE_CHECKING:
    from harness.record.recording.recorded_training import read_recording as read_recording
    from harness.record.trace import read_trace as read_trace
else:
    __all__, __getattr__ = face_of(__name__, __file__)
