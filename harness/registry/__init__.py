"""From a typed name to the object that a plugin registered under it."""
