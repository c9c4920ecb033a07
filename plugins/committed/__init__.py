"""Summaries of an experiment: records and figures that are small enough to be kept beside the code."""
