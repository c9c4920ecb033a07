"""Logs that anybody left in a folder, sorted into trainings by reward and seed, and read as a study. Trains nothing."""
