"""Recorded trainings of a bandit, as the readers of trainings are tested with."""

from tests.results.recordings.conftest import study_folder

__all__ = ["study_folder"]
