"""The verdict: a test of a few questions about the robot, whose error rate is known, and what follows from it."""
