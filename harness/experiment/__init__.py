"""Runs the cells of an experiment: from what a user asks for to the folder of each cell."""
