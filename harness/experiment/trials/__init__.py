"""Tries what an experiment will ask of rewards, measures and environments for an episode, before the first cell."""
