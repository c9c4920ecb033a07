"""Data sets of episodes that others recorded: how one is opened, and what says of an episode that it succeeded.

A data set is a `harness.log.Log` of steps; its formats are plugins. Nothing in one is run: the specification of an env
in it is text to be shown.
"""
