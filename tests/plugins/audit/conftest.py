"""Rollouts of the scripted policies without an engine, and rewards whose properties are known."""

from tests.payoff.conftest import by_script, robot, rollouts, task

__all__ = ["by_script", "robot", "rollouts", "task"]
