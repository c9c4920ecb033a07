"""Does a reward rank behaviour that others recorded as success does? Trains nothing, and makes no env."""
