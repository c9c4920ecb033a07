"""Data sets of episodes that others recorded, in two formats: Minari (HDF5) and LeRobot (a folder of Parquet files).

A `Dataset` says what is known of it and yields its steps piece by piece, so that no more than a piece is in memory.
Nothing in a data set is run: the specification of an env in it is text to be shown.
"""
