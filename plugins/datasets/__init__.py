"""What readers of data sets share: facts, labels, what the metadata declare, and HDF5 files that anybody has made.

A data set of episodes that others recorded is a `harness.log.Log` of steps; its formats are in ``plugins/logs``.
Nothing in a data set is run: the specification of an env in it is text to be shown.
"""
