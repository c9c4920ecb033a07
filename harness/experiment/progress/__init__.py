"""Reports on cells while they run, and writes down what they leave when they end."""
