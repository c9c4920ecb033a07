"""What makes a task harder than its target: noise, delays, obstacles, and arms that differ from the drawing."""

from harness.conditions.conditions import PLAIN, Conditions, conditions_of, later_than

__all__ = ["PLAIN", "Conditions", "conditions_of", "later_than"]
