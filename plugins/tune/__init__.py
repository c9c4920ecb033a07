"""Searches hyperparameters of one algorithm, with an equal budget for every reward."""
