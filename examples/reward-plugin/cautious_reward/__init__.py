"""An example plugin: a reward of one file."""
