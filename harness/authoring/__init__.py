"""What plugin authors may build on; the core does without it."""
