"""Checkpoints, from which a killed training goes on."""
