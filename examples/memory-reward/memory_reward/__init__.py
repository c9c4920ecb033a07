"""An example plugin: a reward that remembers."""
