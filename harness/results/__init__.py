"""Reads the results in an experiment's folder. Importing it loads no robot, policy, environment or engine."""

from typing import TYPE_CHECKING

from harness.face import face_of
from harness.results.comparison import Comparison as Comparison, Group as Group
from harness.results.results import Results as Results

if TYPE_CHECKING:
    from harness.report.section import Fact as Fact, Grid as Grid, Section as Section, Shown as Shown
else:
    __all__, __getattr__ = face_of(__name__)
