"""An example plugin: a simulator on pinocchio's articulated body algorithm."""
