"""Reads the results in an experiment's folder. Importing it loads no robot, policy, environment or engine."""

from harness.results.comparison import Comparison, Group
from harness.results.load import load_results
from harness.results.results import Results

__all__ = ["Comparison", "Group", "Results", "load_results"]
