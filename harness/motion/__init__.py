"""Motion commands, NOTE Table II: how an action becomes joint targets within the robot's limits."""
