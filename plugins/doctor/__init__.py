"""Finds out what works on this machine: files that an installation lacks, and simulators and environments that fail."""
