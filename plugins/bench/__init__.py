"""Where the time of a cell goes."""
