"""What recorded trainings in any Gymnasium environment say. Imports no gymnasium, and runs no code of theirs."""

from harness.results.recordings.study import Study, load_study

__all__ = ["Study", "load_study"]
