"""Hyperparameters of one algorithm, searched with an equal budget for every reward."""
