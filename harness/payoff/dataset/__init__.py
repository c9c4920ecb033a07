"""Rewards pay the steps of data sets of others."""
