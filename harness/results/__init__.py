"""Reads the results in an experiment's folder. Importing it loads no robot, policy, environment or engine."""

from harness.results.results import Results, load_results

__all__ = ["Results", "load_results"]
